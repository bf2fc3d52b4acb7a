use crate::Failure;
use nextview::motion::MotionConfig as Config;
use nextview_sim::run::Step;
use serde::{Deserialize, Serialize};

/// How a robot would take the camera from view to view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct MotionConfig {
    pub speed_m_per_s: f64,
    pub acceleration_m_per_s2: f64,
    /// Distance from the ball around the object's box.
    pub clearance_m: f64,
    /// Time that the robot stands at each view until nothing sways any longer and an image is taken.
    pub sensing_time_s: f64,
}

impl Default for MotionConfig {
    fn default() -> Self {
        let Config { speed, acceleration, clearance } = Config::default();
        Self {
            speed_m_per_s: speed,
            acceleration_m_per_s2: acceleration,
            clearance_m: clearance,
            // A second in which the arm stops swaying, and one for an image, or the mean of thirty.
            sensing_time_s: 2.0,
        }
    }
}

impl MotionConfig {
    /// What the session is told.
    pub fn rule(&self) -> Config {
        let Self {
            speed_m_per_s: speed, acceleration_m_per_s2: acceleration, clearance_m: clearance, ..
        } = *self;
        Config { speed, acceleration, clearance }
    }

    /// Fails on the first value out of its range.
    pub fn check(&self) -> Result<(), Failure> {
        let (limit, length) = (0.001..=100.0, 0.0..=f64::MAX);
        let ranges = [
            ("speed_m_per_s", self.speed_m_per_s, &limit, "0.001 to 100"),
            ("acceleration_m_per_s2", self.acceleration_m_per_s2, &limit, "0.001 to 100"),
            ("clearance_m", self.clearance_m, &length, "a number from 0 on"),
            ("sensing_time_s", self.sensing_time_s, &length, "a number from 0 on"),
        ];
        match ranges.into_iter().find(|(_, value, range, _)| !range.contains(value)) {
            Some((name, value, _, expected)) => {
                Err(Failure::data(format!("motion.{name} is {value}, expected {expected}")))
            }
            None => Ok(()),
        }
    }
}

/// Length of the ways up to each step, metres, and the time that they take, seconds.
pub(crate) fn ways_so_far<'a, M: 'a>(
    steps: impl IntoIterator<Item = &'a Step<M>>,
) -> impl Iterator<Item = [f64; 2]> {
    steps.into_iter().scan([0.0; 2], |[length, time], step| {
        *length += step.way.length();
        *time += step.way.duration();
        Some([*length, *time])
    })
}
