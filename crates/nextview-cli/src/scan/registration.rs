use crate::Failure;
use nextview::registration::{Registration, RegistrationConfig as Config, Verdict};
use serde::{Deserialize, Serialize};

/// Whether images are aligned to what was measured, and how.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct RegistrationConfig {
    pub enabled: bool,
    /// Edge of the cells in which points are pooled.
    pub spacing_mm: f64,
    /// How far given poses may be wrong: an alignment that corrects more is refused.
    pub position_uncertainty_mm: f64,
    pub rotation_uncertainty_deg: f64,
    /// Least share of the image's points that must lie on the known surface.
    pub min_overlap: f64,
    /// How well the surface must hold the image in place.
    pub min_stiffness: f64,
}

impl Default for RegistrationConfig {
    fn default() -> Self {
        // Rounded, so that 10 degrees do not read 9.999999999999998.
        let tidy = |value: f64| (value * 1e9).round() / 1e9;
        let config = Config::default();
        Self {
            enabled: false,
            spacing_mm: tidy(config.spacing * 1e3),
            position_uncertainty_mm: tidy(config.position_uncertainty * 1e3),
            rotation_uncertainty_deg: tidy(config.rotation_uncertainty.to_degrees()),
            min_overlap: config.min_overlap,
            min_stiffness: config.min_stiffness,
        }
    }
}

impl RegistrationConfig {
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// What the session is told.
    pub fn rule(&self) -> Option<Config> {
        self.enabled.then_some(Config {
            spacing: self.spacing_mm / 1e3,
            position_uncertainty: self.position_uncertainty_mm / 1e3,
            rotation_uncertainty: self.rotation_uncertainty_deg.to_radians(),
            min_overlap: self.min_overlap,
            min_stiffness: self.min_stiffness,
        })
    }

    /// Fails on the first value out of its range, of a registration that is off as well.
    pub fn check(&self) -> Result<(), Failure> {
        let positive = f64::MIN_POSITIVE..=f64::MAX;
        let ranges = [
            ("spacing_mm", self.spacing_mm, 0.1..=f64::MAX, "at least 0.1"),
            ("position_uncertainty_mm", self.position_uncertainty_mm, positive, "a positive number"),
            (
                "rotation_uncertainty_deg",
                self.rotation_uncertainty_deg,
                f64::MIN_POSITIVE..=180.0,
                "above 0 and up to 180",
            ),
            ("min_overlap", self.min_overlap, 0.0..=1.0, "0 to 1"),
            ("min_stiffness", self.min_stiffness, 0.0..=1.0, "0 to 1"),
        ];
        match ranges.iter().find(|(_, value, range, _)| !range.contains(value)) {
            Some((name, value, _, expected)) => {
                Err(Failure::data(format!("registration.{name} is {value}, expected {expected}")))
            }
            None => Ok(()),
        }
    }
}

/// What came of aligning an image, as files tell it.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct RegistrationLine {
    accepted: bool,
    /// "aligned", or why the given pose stayed.
    verdict: Verdict,
    residual_before_mm: f64,
    residual_after_mm: f64,
    overlap: f64,
    moved_mm: f64,
    turned_deg: f64,
    stiffness: f64,
    n_iterations: usize,
}

impl From<Registration> for RegistrationLine {
    fn from(found: Registration) -> Self {
        Self {
            accepted: found.is_accepted(),
            verdict: found.verdict,
            residual_before_mm: 1e3 * found.residual_before,
            residual_after_mm: 1e3 * found.residual_after,
            overlap: found.overlap,
            moved_mm: 1e3 * found.moved,
            turned_deg: found.turned.to_degrees(),
            stiffness: found.stiffness,
            n_iterations: found.n_iterations,
        }
    }
}
