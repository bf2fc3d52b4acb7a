use serde::Serialize;

/// Maximum difference that counts as rounding.
const ROUNDING: f64 = 1e-12;

/// Maximum number of differences for the exact distribution, whose time grows with their third power. Beyond
/// it, the normal distribution agrees to three digits.
const MAX_EXACT: usize = 200;

/// A two-sided signed-rank test of paired differences (Wilcoxon 1945).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SignedRank {
    /// Probability of ranks at least as one-sided as these if each difference were equally likely to have the
    /// other sign.
    pub p_value: f64,
    /// Number of pairs.
    pub n_pairs: usize,
    /// Number of pairs with a difference; the others do not count in the test.
    pub n_different: usize,
}

/// Tests whether differences lie around 0; `None` if there are no differences. Equal absolute values share
/// their mean rank.
///
/// Ranks do not depend on the size of extreme values: a skill of -8 counts as the largest of all differences,
/// not as ten of them.
pub fn signed_rank(differences: &[f64]) -> Option<SignedRank> {
    let n_pairs = differences.len();
    let different: Vec<f64> = differences.iter().copied().filter(|d| d.abs() > ROUNDING).collect();
    let ranks = doubled_ranks(&different);
    let signed = different.iter().zip(&ranks).map(|(d, &rank)| if *d > 0.0 { rank } else { -rank });
    let statistic = signed.sum::<i64>().abs();
    let p_value =
        if different.len() <= MAX_EXACT { exact(&ranks, statistic) } else { normal(&ranks, statistic) };
    (n_pairs > 0).then_some(SignedRank { p_value, n_pairs, n_different: different.len() })
}

/// Twice the rank of each absolute value, from 1; equal values have their mean rank.
fn doubled_ranks(differences: &[f64]) -> Vec<i64> {
    let mut sorted: Vec<f64> = differences.iter().map(|difference| difference.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    let rank = |difference: &f64| {
        let below = sorted.partition_point(|other| *other < difference.abs());
        let equal = sorted.partition_point(|other| *other <= difference.abs()) - below;
        (2 * below + equal + 1) as i64
    };
    differences.iter().map(rank).collect()
}

/// The probability that ranks with random signs sum to this or more, on either side.
fn exact(doubled_ranks: &[i64], statistic: i64) -> f64 {
    // The probability of each sum of the ranks with positive sign.
    let mut sums = vec![1.0];
    for &rank in doubled_ranks {
        let mut next = vec![0.0; sums.len() + rank as usize];
        for (sum, probability) in sums.iter().enumerate() {
            next[sum] += 0.5 * probability;
            next[sum + rank as usize] += 0.5 * probability;
        }
        sums = next;
    }
    let total = sums.len() as i64 - 1;
    let is_extreme = |positive: usize| (2 * positive as i64 - total).abs() >= statistic;
    let extreme = sums.iter().enumerate().filter(|(positive, _)| is_extreme(*positive));
    extreme.map(|(_, probability)| probability).sum::<f64>().min(1.0)
}

/// The probability by the normal distribution with this variance.
fn normal(doubled_ranks: &[i64], statistic: i64) -> f64 {
    let variance: f64 = doubled_ranks.iter().map(|&rank| (rank as f64).powi(2)).sum();
    two_sided(statistic as f64 / variance.sqrt())
}

/// Probability that a standard normal number is at least this far from 0, to within 3e-7 (Abramowitz & Stegun
/// 1964, 7.1.26).
fn two_sided(z: f64) -> f64 {
    let x = z / std::f64::consts::SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let terms = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    terms.iter().fold(0.0, |sum, term| (sum + term) * t) * (-x * x).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    /// Uses all signs, with ranks counted one by one.
    fn slow_p_value(differences: &[f64]) -> f64 {
        let different: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
        let n = different.len();
        let mut order: Vec<f64> = different.iter().map(|d| d.abs()).collect();
        order.sort_by(f64::total_cmp);
        let rank = |d: f64| {
            let places: Vec<usize> = (0..n).filter(|&i| order[i] == d.abs()).collect();
            places.iter().map(|&i| i as f64 + 1.0).sum::<f64>() / places.len() as f64
        };
        let ranks: Vec<f64> = different.iter().map(|&d| rank(d)).collect();
        let sum = |is_positive: &dyn Fn(usize) -> bool| {
            (0..n).map(|i| if is_positive(i) { ranks[i] } else { -ranks[i] }).sum::<f64>().abs()
        };
        let found = sum(&|i| different[i] > 0.0);
        let n_extreme = (0..1_usize << n).filter(|code| sum(&|i| code >> i & 1 == 1) >= found - 1e-9).count();
        n_extreme as f64 / (1_usize << n) as f64
    }

    #[test]
    fn agrees_with_all_signs() {
        let mut random = Random::new(2, 0);
        for n in [1, 2, 3, 5, 8, 11] {
            for _ in 0..20 {
                // Many ties and some zeros.
                let differences: Vec<f64> = (0..n).map(|_| random.index(9) as f64 - 3.0).collect();
                let found = signed_rank(&differences).unwrap();
                assert!((found.p_value - slow_p_value(&differences)).abs() < 1e-12, "{differences:?}");
                assert_eq!(found.n_different, differences.iter().filter(|d| **d != 0.0).count());
            }
        }
    }

    #[test]
    fn known_values() {
        let p_value = |differences: &[f64]| signed_rank(differences).map(|test| test.p_value);
        assert_eq!(p_value(&[]), None);
        assert_eq!(p_value(&[0.0, 1e-15]), Some(1.0));
        assert_eq!(p_value(&[1.0; 5]), Some(2.0 / 32.0), "five pairs are never enough for 0.05");
        assert_eq!(p_value(&[1.0, 2.0, 3.0, 4.0, 5.0, 60.0]), Some(2.0 / 64.0));
        // Darwin's differences of maize plants (Fisher 1935): the negative ranks sum to 24.
        let maize = [49., -67., 8., 16., 6., 23., 28., 41., 14., 29., 56., 24., 75., 60., -48.];
        assert!((p_value(&maize).unwrap() - 0.0413).abs() < 5e-5, "{:?}", p_value(&maize));
    }

    #[test]
    fn many_pairs_are_normal() {
        let mut random = Random::new(3, 0);
        for shift in [0.0, 0.05, 0.1] {
            let differences: Vec<f64> = (0..MAX_EXACT).map(|_| random.unit() - 0.5 + shift).collect();
            let ranks = doubled_ranks(&differences);
            let found = signed_rank(&differences).unwrap().p_value;
            let signed = differences.iter().zip(&ranks).map(|(d, &rank)| if *d > 0.0 { rank } else { -rank });
            let approximate = normal(&ranks, signed.sum::<i64>().abs());
            assert!((found - approximate).abs() < 2e-3, "{found} {approximate}");
        }
        assert!((two_sided(1.959_964) - 0.05).abs() < 1e-6 && (two_sided(0.0) - 1.0).abs() < 1e-6);
        let many: Vec<f64> = (0..1000).map(|i| f64::from(i) - 300.0).collect();
        assert!(signed_rank(&many).unwrap().p_value < 1e-9);
    }

    /// If A and B do not differ, at most one test in twenty has p of at most 0.05.
    #[test]
    fn false_alarms_are_as_rare_as_promised() {
        let mut random = Random::new(4, 0);
        let n_alarms = (0..1000)
            .filter(|_| {
                let differences: Vec<f64> = (0..12).map(|_| (random.unit() - 0.5).powi(3)).collect();
                signed_rank(&differences).unwrap().p_value <= 0.05
            })
            .count();
        // Expected 47 for twelve pairs, standard deviation 7.
        assert!((25..70).contains(&n_alarms), "{n_alarms}");
    }
}
