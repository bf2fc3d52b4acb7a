/// The flow gain of every view, the paper's eqs. (4) and (5): the sum of exp(-(it - k)) over the plans k, up
/// to the present one, in which the view was optimal (in V_global). `it` is the number of the present plan.
///
/// `plans` holds V_global of every plan, the present one last.
pub fn flow_gain<'a>(plans: impl DoubleEndedIterator<Item = &'a [u32]>, n_views: usize) -> Vec<f64> {
    let mut gain = vec![0.0; n_views];
    for (age, optimal) in plans.rev().enumerate() {
        let weight = (-(age as f64)).exp();
        optimal.iter().for_each(|&view| gain[view as usize] += weight);
    }
    gain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weighs_plans_by_age() {
        let plans: [&[u32]; 3] = [&[0, 1], &[1], &[1, 2]];
        let gain = flow_gain(plans.into_iter(), 4);
        let e = (-1.0_f64).exp();
        let expected = [e * e, 1.0 + e + e * e, 1.0, 0.0];
        assert!(gain.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{gain:?}");
    }
}
