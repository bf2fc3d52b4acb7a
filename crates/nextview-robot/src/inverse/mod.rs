//! Inverse kinematics: the joint values that bring the flange to a pose.
//!
//! The geometry of an arm selects the method, not its name: closed forms for six turning axes of which three
//! meet (a wrist) or three are parallel, closed forms with a sampled seventh joint, and numerical search for
//! all other arms.

mod axis;
mod circle;
mod closed_form;
mod descent;
mod free;
mod numeric;
mod parallel_axes;
mod redundant;
mod solutions;
mod turns;
mod wrist;

use crate::Arm;
use nextview::geometry::Pose;

impl Arm {
    /// Returns all joint values within the limits that bring the flange to a pose, in lexicographic order;
    /// empty if none do. Each reproduces the pose to 1e-6 in metres and radians.
    ///
    /// - Six turning axes with a wrist (three axes that meet, first or last) or with three parallel axes
    ///   between a first one and two that meet: every solution, from a closed form. Axes count as parallel
    ///   within 0.01 rad and as meeting within 5 mm. This also covers calibrated arms with slightly
    ///   misaligned axes; damped Newton steps remove the difference. For an arm misaligned by 1 mrad and 0.5
    ///   mm, up to 2 % of the solutions near singular poses are missed, and all solutions of 0.3 % of the
    ///   poses.
    /// - Seven joints, one of which can be held to leave such an arm: that joint is sampled at 64 values, or
    ///   at 1024 if none of these has a solution, and every solution for each value is returned.
    /// - All other arms: the solutions found by damped least squares from 50 seeded starts, possibly not all.
    ///
    /// If limits allow further turns, each is a separate solution, up to 2π on either side of the value
    /// nearest to 0. In a singular pose, eight values stand for a joint with arbitrary value.
    ///
    /// Sources: Brandstötter, Angerer and Hofbaur 2014 (arms with a wrist); Hawkins 2013 (parallel axes); He
    /// and Liu 2021 (a seventh axis held). Their formulas require textbook axes; here, the same circles are
    /// intersected for arbitrary axes (the subproblems of Paden and Kahan; Murray, Li and Sastry 1994,
    /// section 3.2).
    pub fn inverse(&self, base_from_flange: &Pose) -> Vec<Vec<f64>> {
        solutions::all(self, base_from_flange, None)
    }

    /// As [`inverse`](Self::inverse), but nearest solution first: the one that the slowest joint reaches
    /// soonest at full speed. A seventh axis, a joint without influence and the first numerical start also
    /// try their values in `near`.
    ///
    /// # Panics
    ///
    /// If the number of values is not that of joints, or one is not finite.
    pub fn inverse_near(&self, base_from_flange: &Pose, near: &[f64]) -> Vec<Vec<f64>> {
        assert_eq!(near.len(), self.joints.len(), "a value for each joint");
        assert!(near.iter().all(|value| value.is_finite()), "finite values, not {near:?}");
        let time = |values: &[f64]| {
            let times = self.joints.iter().zip(values.iter().zip(near));
            times.map(|(joint, (a, b))| (a - b).abs() / joint.limits.velocity).fold(0.0, f64::max)
        };
        // A start, or the value of a held joint, must be within the limits.
        let joints = self.joints.iter().zip(near);
        let within = joints.map(|(joint, value)| value.clamp(joint.limits.lower, joint.limits.upper));
        let mut found = solutions::all(self, base_from_flange, Some(&within.collect::<Vec<_>>()));
        // Stable: equal times keep their lexicographic order.
        found.sort_by(|a, b| time(a).total_cmp(&time(b)));
        found
    }
}

#[cfg(test)]
mod tests;
