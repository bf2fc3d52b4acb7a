use super::signed_rank::{SignedRank, signed_rank};
use super::{Interval, mean, percentile};
use nextview::geometry::random::Random;

/// Maximum number of values that are drawn individually for an interval.
const MAX_DRAWN: usize = 10_000;

/// Maximum number of objects that are drawn individually if there are more values than that.
const MAX_DRAWN_OBJECTS: usize = 200;

/// The values of a quantity: for each object the values of its runs, which differ in seed, candidates or
/// first view.
///
/// Every number is first averaged within an object: objects with more runs do not count more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// No object is empty.
    objects: Vec<Vec<f64>>,
}

impl Sample {
    /// Creates a sample of these objects; objects without values are left out.
    pub fn new(objects: impl IntoIterator<Item = Vec<f64>>) -> Self {
        Self { objects: objects.into_iter().filter(|values| !values.is_empty()).collect() }
    }

    /// Returns the number of objects.
    pub fn n_objects(&self) -> usize {
        self.objects.len()
    }

    /// Returns the mean of each object.
    pub fn object_means(&self) -> Vec<f64> {
        self.objects.iter().filter_map(|values| mean(values)).collect()
    }

    /// Returns the mean over objects; `None` if there are no objects.
    pub fn mean(&self) -> Option<f64> {
        mean(&self.object_means())
    }

    /// Returns the median over objects; `None` if there are no objects.
    pub fn median(&self) -> Option<f64> {
        percentile(&self.object_means(), 0.5)
    }

    /// Returns the 95 % interval of the mean by a two-level bootstrap: objects are resampled, and the runs
    /// within each of them (Davison & Hinkley 1997, section 3.8). `None` if nothing can be resampled: one
    /// object with one run.
    ///
    /// If runs of an object differ more than objects do, the interval is a little too wide: the means of the
    /// objects already vary with their runs.
    ///
    /// Samples of more than 10,000 values use the central limit theorem instead of draws: the mean of an
    /// object's runs is normal then, and with more than 200 objects so is the mean over these.
    pub fn interval(&self) -> Option<Interval> {
        let n = self.objects.len();
        let varies = n > 1 || self.objects.first().is_some_and(|values| values.len() > 1);
        if self.objects.iter().map(Vec::len).sum::<usize>() > MAX_DRAWN {
            let means: Vec<VaryingMean> = self.objects.iter().map(|values| VaryingMean::of(values)).collect();
            return Some(interval_of_means(&means));
        }
        varies.then(|| self.resampled_interval())
    }

    fn resampled_interval(&self) -> Interval {
        let n = self.objects.len();
        let of_object = |random: &mut Random| resampled_mean(&self.objects[random.index(n)], random);
        let resampled = |random: &mut Random| (0..n).map(|_| of_object(random)).sum::<f64>() / n as f64;
        Interval::by_bootstrap(n, resampled)
    }

    /// Tests whether the means of the objects lie around 0; `None` if there are no objects.
    pub fn signed_rank(&self) -> Option<SignedRank> {
        signed_rank(&self.object_means())
    }
}

/// The mean of a resample of the values. A single value uses no random number.
fn resampled_mean(values: &[f64], random: &mut Random) -> f64 {
    match values {
        [value] => *value,
        values => {
            let n = values.len();
            (0..n).map(|_| values[random.index(n)]).sum::<f64>() / n as f64
        }
    }
}

/// The mean of an object's runs, and its variance under resampling.
#[derive(Clone, Copy, Debug)]
struct VaryingMean {
    mean: f64,
    variance: f64,
}

impl VaryingMean {
    fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n / n;
        Self { mean, variance }
    }

    /// A normal number with this mean and variance (Box & Muller 1958).
    fn draw(self, random: &mut Random) -> f64 {
        let (radius, angle) = ((1.0 - random.unit()).ln() * -2.0, random.unit() * std::f64::consts::TAU);
        self.mean + (self.variance * radius).sqrt() * angle.cos()
    }
}

/// The interval of the mean over these objects.
fn interval_of_means(objects: &[VaryingMean]) -> Interval {
    let n = objects.len();
    if n <= MAX_DRAWN_OBJECTS {
        let of_object = |random: &mut Random| objects[random.index(n)].draw(random);
        let resampled = |random: &mut Random| (0..n).map(|_| of_object(random)).sum::<f64>() / n as f64;
        return Interval::by_bootstrap(n, resampled);
    }
    let means: Vec<f64> = objects.iter().map(|object| object.mean).collect();
    let between = VaryingMean::of(&means);
    let within = objects.iter().map(|object| object.variance).sum::<f64>() / (n * n) as f64;
    Interval::of_normal(between.mean, (between.variance + within).sqrt())
}

/// Two quantities, A and B, measured on the same objects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairedSample {
    objects: Vec<PairedObject>,
}

/// The values of A and B on an object, at least one each.
#[derive(Clone, Debug, PartialEq)]
pub struct PairedObject {
    a: Vec<f64>,
    b: Vec<f64>,
    /// Whether value i of A and value i of B have the same draws.
    runs_are_paired: bool,
}

impl PairedObject {
    /// Creates an object from values keyed by their draws. Values are paired by key if A and B have the same
    /// keys. `None` if either has no value.
    pub fn new<K: Ord>(mut a: Vec<(K, f64)>, mut b: Vec<(K, f64)>) -> Option<Self> {
        [&mut a, &mut b].into_iter().for_each(|values| values.sort_by(|x, y| x.0.cmp(&y.0)));
        let runs_are_paired = a.iter().map(|value| &value.0).eq(b.iter().map(|value| &value.0));
        let [a, b] = [a, b].map(|values| values.into_iter().map(|(_, value)| value).collect::<Vec<f64>>());
        (!a.is_empty() && !b.is_empty()).then_some(Self { a, b, runs_are_paired })
    }

    /// The means of A and B.
    fn means(&self) -> [f64; 2] {
        [&self.a, &self.b].map(|values| values.iter().sum::<f64>() / values.len() as f64)
    }

    /// The mean of a weighted sum of A and B under resampling of the runs; pairs of runs stay together.
    fn weighted(&self, [of_a, of_b]: [f64; 2]) -> VaryingMean {
        if self.runs_are_paired {
            let sums = self.a.iter().zip(&self.b).map(|(a, b)| of_a * a + of_b * b);
            return VaryingMean::of(&sums.collect::<Vec<_>>());
        }
        let [a, b] = [&self.a, &self.b].map(|values| VaryingMean::of(values));
        VaryingMean {
            mean: of_a * a.mean + of_b * b.mean,
            variance: of_a.powi(2) * a.variance + of_b.powi(2) * b.variance,
        }
    }

    /// The means of a resample of the runs; pairs of runs stay together.
    fn resampled_means(&self, random: &mut Random) -> [f64; 2] {
        if !self.runs_are_paired {
            return [resampled_mean(&self.a, random), resampled_mean(&self.b, random)];
        }
        if let ([a], [b]) = (&self.a[..], &self.b[..]) {
            return [*a, *b];
        }
        let n = self.a.len();
        let mut sums = [0.0; 2];
        for _ in 0..n {
            let i = random.index(n);
            sums[0] += self.a[i];
            sums[1] += self.b[i];
        }
        sums.map(|sum| sum / n as f64)
    }
}

impl PairedSample {
    /// Creates a sample of these objects.
    pub fn new(objects: impl IntoIterator<Item = PairedObject>) -> Self {
        Self { objects: objects.into_iter().collect() }
    }

    /// Returns the number of objects.
    pub fn n_objects(&self) -> usize {
        self.objects.len()
    }

    /// Keeps the objects on which the means of A and B are positive, as a ratio requires.
    pub fn positive(self) -> Self {
        let is_positive = |object: &PairedObject| object.means().iter().all(|&mean| mean > 0.0);
        Self { objects: self.objects.into_iter().filter(is_positive).collect() }
    }

    /// Returns the means of A, one per object.
    pub fn of_a(&self) -> Vec<f64> {
        self.objects.iter().map(|object| object.means()[0]).collect()
    }

    /// Returns the means of B, one per object.
    pub fn of_b(&self) -> Vec<f64> {
        self.objects.iter().map(|object| object.means()[1]).collect()
    }

    /// Returns B - A for each object.
    pub fn differences(&self) -> Vec<f64> {
        self.objects.iter().map(|object| difference(object.means())).collect()
    }

    /// Returns the 95 % interval of the mean of B - A, as in [`Sample::interval`]: objects are resampled, and
    /// within each the pairs of runs, or the runs of A and B separately if they are not paired.
    pub fn interval(&self) -> Option<Interval> {
        let n = self.objects.len();
        if self.is_large() {
            return Some(interval_of_means(&self.weighted([-1.0, 1.0])));
        }
        self.bootstrap(|random| {
            let of_object =
                |random: &mut Random| difference(self.objects[random.index(n)].resampled_means(random));
            (0..n).map(|_| of_object(random)).sum::<f64>() / n as f64
        })
    }

    /// Returns the mean of B divided by that of A; `None` if there are no objects or if it is not a number.
    pub fn ratio(&self) -> Option<f64> {
        Some(mean(&self.of_b())? / mean(&self.of_a())?).filter(|ratio| ratio.is_finite())
    }

    /// Returns the 95 % interval of this ratio by the same resamples; for large samples, that of its linear
    /// part.
    pub fn ratio_interval(&self) -> Option<Interval> {
        let n = self.objects.len();
        if self.is_large() {
            let (ratio, a) = (self.ratio()?, mean(&self.of_a())?);
            let around = interval_of_means(&self.weighted([-ratio / a, 1.0 / a]));
            return Some(around.map(|deviation| ratio + deviation));
        }
        self.bootstrap(|random| {
            let mut sums = [0.0; 2];
            for _ in 0..n {
                let means = self.objects[random.index(n)].resampled_means(random);
                sums = [sums[0] + means[0], sums[1] + means[1]];
            }
            sums[1] / sums[0]
        })
    }

    /// Tests whether the differences of the objects lie around 0; `None` if there are no objects.
    pub fn signed_rank(&self) -> Option<SignedRank> {
        signed_rank(&self.differences())
    }

    fn is_large(&self) -> bool {
        self.objects.iter().map(|object| object.a.len().max(object.b.len())).sum::<usize>() > MAX_DRAWN
    }

    fn weighted(&self, weights: [f64; 2]) -> Vec<VaryingMean> {
        self.objects.iter().map(|object| object.weighted(weights)).collect()
    }

    fn bootstrap(&self, resampled: impl FnMut(&mut Random) -> f64) -> Option<Interval> {
        let n = self.objects.len();
        let varies =
            n > 1 || self.objects.first().is_some_and(|object| object.a.len().max(object.b.len()) > 1);
        varies.then(|| Interval::by_bootstrap(n, resampled))
    }
}

fn difference([a, b]: [f64; 2]) -> f64 {
    b - a
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All resamples of `n` things, each a list of indices.
    fn resamples(n: usize) -> Vec<Vec<usize>> {
        (0..n.pow(n as u32)).map(|code| (0..n).map(|i| code / n.pow(i as u32) % n).collect()).collect()
    }

    /// The value below which this share of the weight lies.
    fn weighted_percentile(mut values: Vec<(f64, f64)>, share: f64) -> f64 {
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = values.iter().map(|value| value.1).sum();
        let mut below = 0.0;
        for (value, weight) in &values {
            below += weight;
            if below >= share * total {
                return *value;
            }
        }
        values[values.len() - 1].0
    }

    /// The interval by all resamples of objects and all of their runs, with their probabilities.
    fn exact_interval(objects: &[Vec<f64>]) -> [f64; 2] {
        let n = objects.len();
        let means: Vec<Vec<f64>> = objects
            .iter()
            .map(|values| {
                let of = |resample: Vec<usize>| {
                    resample.iter().map(|&i| values[i]).sum::<f64>() / values.len() as f64
                };
                resamples(values.len()).into_iter().map(of).collect()
            })
            .collect();
        let mut all = Vec::new();
        for resample in resamples(n) {
            let mut sums = vec![(0.0, 1.0)];
            for &object in &resample {
                let weight = 1.0 / means[object].len() as f64;
                sums = sums
                    .iter()
                    .flat_map(|&(sum, w)| means[object].iter().map(move |mean| (sum + mean, w * weight)))
                    .collect();
            }
            all.extend(sums.into_iter().map(|(sum, weight)| (sum / n as f64, weight)));
        }
        [0.025, 0.975].map(|share| weighted_percentile(all.clone(), share))
    }

    #[test]
    fn two_levels_agree_with_all_resamples() {
        for objects in [
            vec![vec![0.0, 1.0, 4.0], vec![2.0, 2.5], vec![5.0, 3.0, 3.5]],
            vec![vec![0.0, 3.0, 1.0], vec![2.0], vec![-1.0, 0.5]],
            vec![vec![1.0, 2.0, 4.0, 8.0]],
        ] {
            let interval = Sample::new(objects.clone()).interval().unwrap();
            let [low, high] = exact_interval(&objects);
            // The ends of 10 000 resamples have a standard error of about 0.03 standard deviations, and the
            // possible means lie up to 0.1 apart.
            assert!((interval.low - low).abs() < 0.11 && (interval.high - high).abs() < 0.11, "{interval:?}");
            assert_eq!(Sample::new(objects).interval(), Some(interval), "the same every time");
        }
    }

    #[test]
    fn single_runs_make_it_a_bootstrap_over_objects() {
        let values = [0.0, 1.0, 5.0, 2.5, 3.1];
        let sample = Sample::new(values.map(|value| vec![value]));
        assert_eq!(sample.interval(), Interval::of_mean(&values));
        assert_eq!((sample.mean(), sample.median()), (mean(&values), Some(2.5)));
        assert_eq!(Sample::new([vec![1.0]]).interval(), None);
        assert_eq!(Sample::new([vec![]]), Sample::default());
        assert_eq!((Sample::default().mean(), Sample::default().interval()), (None, None));
    }

    /// Means of twelve uniform numbers, nearly normal: objects and runs each have a standard deviation of 1.
    #[test]
    fn intervals_hold_the_true_mean_about_as_often_as_they_promise() {
        let mut random = Random::new(11, 0);
        let mut draw = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
        let (mut n_holding, mut n_flat_holding) = (0, 0);
        for _ in 0..300 {
            let objects: Vec<Vec<f64>> = (0..20)
                .map(|_| {
                    let object = draw();
                    (0..3).map(|_| object + draw()).collect()
                })
                .collect();
            let holds = |interval: Interval| (interval.low..interval.high).contains(&0.0);
            n_holding += usize::from(holds(Sample::new(objects.clone()).interval().unwrap()));
            let flat = objects.concat();
            n_flat_holding += usize::from(holds(Interval::of_mean(&flat).unwrap()));
        }
        // Two levels are a little too wide: expected about 288 (96 %), standard deviation 4. A bootstrap that
        // treats all runs as independent is far too narrow.
        assert!((276..=299).contains(&n_holding), "{n_holding}");
        assert!(n_flat_holding < 270, "{n_flat_holding}");
    }

    fn object(a: &[f64], b: &[f64]) -> PairedObject {
        let keyed = |values: &[f64]| values.iter().copied().enumerate().collect();
        PairedObject::new(keyed(a), keyed(b)).unwrap()
    }

    #[test]
    fn pairs_of_runs_stay_together() {
        // Draws differ by tens, A and B by one in each draw.
        let objects =
            [object(&[10.0, 20.0, 30.0], &[11.0, 21.0, 31.0]), object(&[-10.0, 50.0], &[-9.0, 51.0])];
        let paired = PairedSample::new(objects);
        assert_eq!(paired.interval(), Some(Interval { low: 1.0, high: 1.0 }));
        assert_eq!((paired.differences(), paired.of_a()), (vec![1.0, 1.0], vec![20.0, 20.0]));
        // Other keys are other draws.
        let other = PairedObject::new(vec![(0, 10.0), (1, 20.0)], vec![(5, 11.0), (6, 21.0)]).unwrap();
        assert!(!other.runs_are_paired);
        let interval = PairedSample::new([other.clone(), other]).interval().unwrap();
        assert!(interval.low < -4.0 && interval.high > 6.0, "{interval:?}");
        let sorted = PairedObject::new(vec![(1, 20.0), (0, 10.0)], vec![(0, 11.0), (1, 21.0)]).unwrap();
        assert_eq!((sorted.a, sorted.runs_are_paired), (vec![10.0, 20.0], true));
        assert_eq!(PairedObject::new(vec![(0, 1.0)], vec![]), None);
    }

    #[test]
    fn the_ratio_is_that_of_the_means_shown() {
        let paired = PairedSample::new([object(&[190.0], &[168.0]), object(&[5.2], &[4.8])]);
        let ratio = paired.ratio().unwrap();
        assert!((ratio - 86.4 / 97.6).abs() < 1e-12, "{ratio}");
        let interval = paired.ratio_interval().unwrap();
        assert!(interval.low <= ratio && ratio <= interval.high, "{interval:?}");
        let with_zero = PairedSample::new([object(&[0.0], &[1.0]), object(&[2.0], &[1.0])]);
        assert_eq!(with_zero.positive().ratio(), Some(0.5));
        assert_eq!(PairedSample::default().ratio(), None);
    }

    /// Objects with their runs, all of them normal around the object's mean.
    fn drawn(n_objects: usize, n_runs: usize) -> Vec<Vec<f64>> {
        let mut random = Random::new(5, 0);
        let of_object = |_| {
            let mean = VaryingMean { mean: 3.0, variance: 0.2 }.draw(&mut random);
            (0..n_runs).map(|_| VaryingMean { mean, variance: 1.0 }.draw(&mut random)).collect()
        };
        (0..n_objects).map(of_object).collect()
    }

    fn assert_near(a: Interval, b: Interval) {
        let width = a.high - a.low;
        assert!(
            (a.low - b.low).abs() < 0.03 * width && (a.high - b.high).abs() < 0.03 * width,
            "{a:?} {b:?}"
        );
    }

    #[test]
    fn intervals_of_large_samples_agree_with_those_of_all_draws() {
        for (n_objects, n_runs) in [(4, 2600), (150, 70), (300, 35)] {
            let sample = Sample::new(drawn(n_objects, n_runs));
            assert_near(sample.interval().unwrap(), sample.resampled_interval());
            // A and B have part of their draws in common.
            let paired = sample.objects.iter().zip(drawn(n_objects, n_runs)).map(|(a, b)| {
                let b = a.iter().zip(b.iter().rev()).map(|(a, b)| 5.0 + 0.5 * a + 0.1 * b).collect();
                PairedObject { a: a.iter().map(|a| 10.0 + a).collect(), b, runs_are_paired: true }
            });
            let paired = PairedSample::new(paired);
            let small = |paired: &PairedSample, of: fn([f64; 2]) -> f64| {
                let n = paired.objects.len();
                Interval::by_bootstrap(n, |random| {
                    let mut sums = [0.0; 2];
                    for _ in 0..n {
                        let means = paired.objects[random.index(n)].resampled_means(random);
                        sums = [sums[0] + means[0] / n as f64, sums[1] + means[1] / n as f64];
                    }
                    of(sums)
                })
            };
            assert_near(paired.interval().unwrap(), small(&paired, difference));
            assert_near(paired.ratio_interval().unwrap(), small(&paired, |[a, b]| b / a));
        }
    }
}
