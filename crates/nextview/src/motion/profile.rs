/// Distance over time of the fastest motion from rest to rest within limits on speed and acceleration. Its
/// speed over time is a trapezoid, or a triangle if the path is too short for full speed.
///
/// ```
/// use nextview::motion::SpeedProfile;
///
/// let profile = SpeedProfile::new(1.0, 0.25, 0.5); // 1 m at 0.25 m/s, which is reached after 0.5 s
/// assert_eq!(profile.duration(), 0.5 + 3.75 - 0.25 + 0.5);
/// assert_eq!(profile.distance_at(0.5), 0.0625);
/// assert_eq!(profile.time_at(0.0625), 0.5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedProfile {
    length: f64,
    acceleration: f64,
    /// Time of acceleration, and of deceleration, seconds.
    ramp: f64,
    duration: f64,
}

impl SpeedProfile {
    /// Creates the profile of a path of this length, not negative, under positive limits; all finite.
    pub fn new(length: f64, speed: f64, acceleration: f64) -> Self {
        let ramp = (speed / acceleration).min((length / acceleration).sqrt());
        let cruise = (length - acceleration * ramp * ramp).max(0.0);
        let duration = 2.0 * ramp + if cruise > 0.0 { cruise / speed } else { 0.0 };
        Self { length, acceleration, ramp, duration }
    }

    /// Total time, seconds.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Distance from the start at this time: 0 before the start, the whole length after the end.
    pub fn distance_at(&self, time: f64) -> f64 {
        let left = self.duration - time;
        if time <= self.ramp {
            0.5 * self.acceleration * time.max(0.0).powi(2)
        } else if left <= self.ramp {
            self.length - 0.5 * self.acceleration * left.max(0.0).powi(2)
        } else {
            self.acceleration * self.ramp * (time - 0.5 * self.ramp)
        }
    }

    /// Time at which a distance from the start is reached; the inverse of [`distance_at`](Self::distance_at).
    pub fn time_at(&self, distance: f64) -> f64 {
        let left = self.length - distance;
        let while_ramp = 0.5 * self.acceleration * self.ramp * self.ramp;
        if distance <= while_ramp {
            (2.0 * distance.max(0.0) / self.acceleration).sqrt()
        } else if left <= while_ramp {
            self.duration - (2.0 * left.max(0.0) / self.acceleration).sqrt()
        } else {
            0.5 * self.ramp + distance / (self.acceleration * self.ramp)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// The slow twin steps through time and takes differences.
        #[test]
        fn limits_hold_and_cannot_be_used_better(
            length in prop_oneof![Just(0.0), 1e-6..1e-3, 1e-3..10.0], speed in 0.01..2.0, acceleration in 0.05..5.0
        ) {
            let profile = SpeedProfile::new(length, speed, acceleration);
            let n = 2000;
            let dt = profile.duration() / n as f64;
            let at: Vec<f64> = (0..=n).map(|i| profile.distance_at(i as f64 * dt)).collect();
            prop_assert!(at[0] == 0.0 && (at[n] - length).abs() <= 1e-12 * (1.0 + length));
            if length == 0.0 {
                return Ok(());
            }
            let speeds: Vec<f64> = at.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect();
            let rounding = 1e-13 * (1.0 + length) / dt;
            prop_assert!(speeds.iter().all(|v| (-rounding..=speed * (1.0 + 1e-9) + rounding).contains(v)));
            let changes = speeds.windows(2).map(|pair| (pair[1] - pair[0]).abs() / dt);
            prop_assert!(changes.fold(0.0, f64::max) <= acceleration * (1.0 + 1e-9) + 2.0 * rounding / dt);
            let ends = speeds[0].max(speeds[n - 1]);
            prop_assert!(ends <= 0.5 * acceleration * dt * (1.0 + 1e-6) + rounding, "at rest at both ends");
            // No motion within the limits is faster: it is never ahead of full acceleration from the start
            // and to the end.
            let ahead = |t: f64| (0.5 * acceleration * t * t).min(speed * t);
            let bound = 2.0 * (0.5 * length / speed).max((length / acceleration).sqrt());
            prop_assert!(profile.duration() >= bound * (1.0 - 1e-12) && ahead(profile.duration()) >= length);
            for share in [0.01, 0.3, 0.5, 0.77, 0.999] {
                let there = profile.distance_at(profile.time_at(share * length));
                prop_assert!((there - share * length).abs() <= 1e-9 * length, "{there} at {share}");
            }
        }
    }

    #[test]
    fn known_durations() {
        assert_eq!(SpeedProfile::new(0.0, 0.25, 0.5).duration(), 0.0);
        assert_eq!(SpeedProfile::new(0.125, 0.25, 0.5).duration(), 1.0, "just full speed");
        assert_eq!(SpeedProfile::new(0.02, 0.25, 0.5).duration(), 0.4, "a triangle");
        assert_eq!(SpeedProfile::new(0.5, 0.25, 0.5).duration(), 2.5);
    }
}
