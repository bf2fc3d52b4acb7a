use crate::Fault;
use glam::DVec3;
use nextview::geometry::Aabb;
use nextview::view::{Reach, ReachSphere, Reachability, ViewSpace};
use serde::{Deserialize, Serialize};

/// Where a robot can hold the camera. Other candidates are dropped, and the rest are renumbered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ReachConfig {
    /// Position of the robot's base; enables the radii.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_m: Option<[f64; 3]>,
    /// Minimum distance of the camera from the base.
    pub min_radius_m: f64,
    /// Maximum distance of the camera from the base.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_radius_m: Option<f64>,
    /// Boxes that may contain the camera, given by their lowest and highest corners. Anywhere if empty.
    pub allowed_boxes_m: Vec<[f64; 6]>,
    /// Boxes that must not contain the camera.
    pub forbidden_boxes_m: Vec<[f64; 6]>,
}

impl ReachConfig {
    /// Whether every candidate is within reach.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Sets an arm at x, y, z with this radius.
    pub fn set_sphere(&mut self, [x, y, z, radius]: [f64; 4]) {
        (self.base_m, self.min_radius_m, self.max_radius_m) = (Some([x, y, z]), 0.0, Some(radius));
    }

    /// Converts to the library's type.
    pub fn rule(&self) -> Reach {
        let boxes = |boxes: &[[f64; 6]]| boxes.iter().map(bounds).collect();
        let sphere = self.base_m.zip(self.max_radius_m).map(|(base, max_radius)| ReachSphere {
            base: DVec3::from_array(base),
            min_radius: self.min_radius_m,
            max_radius,
        });
        Reach { sphere, allowed: boxes(&self.allowed_boxes_m), forbidden: boxes(&self.forbidden_boxes_m) }
    }

    /// All values out of range and all values that lack their counterpart.
    pub(crate) fn faults(&self) -> Vec<Fault> {
        if self.base_m.is_some() != self.max_radius_m.is_some() {
            return vec![Fault::request("`reach.base_m` and `reach.max_radius_m` must be given together")];
        }
        if self.base_m.is_none() && self.min_radius_m != 0.0 {
            return vec![Fault::request(
                "`reach.min_radius_m` needs `reach.base_m` and `reach.max_radius_m`",
            )];
        }
        let fault = |error: nextview::Error| Fault::from(error).within("reach");
        self.rule().check().err().map(fault).into_iter().collect()
    }

    /// Keeps the candidates within reach. Fails if no candidate is left.
    pub fn filter<T>(&self, candidates: Vec<T>, position: impl Fn(&T) -> DVec3) -> Result<Vec<T>, Fault> {
        let (reach, n) = (self.rule(), candidates.len());
        let around = Aabb::around(candidates.iter().map(&position));
        let left: Vec<T> =
            candidates.into_iter().filter(|candidate| reach.contains(position(candidate))).collect();
        match around.filter(|_| left.is_empty()) {
            Some(Aabb { min, max }) => {
                let place = format!("they are between {min:.3} and {max:.3} m");
                let fault =
                    Fault::request(format!("none of the {n} view candidates is within reach: {place}"));
                Err(fault.with_remedy("`reach` is in metres, in the coordinates of the object"))
            }
            None => Ok(left),
        }
    }

    /// Keeps the view candidates within reach. Unless reach is unlimited, a note states how many are left.
    pub fn views(&self, views: ViewSpace) -> Result<(ViewSpace, Option<String>), Fault> {
        if self.is_default() {
            return Ok((views, None));
        }
        let left = self.filter(views.poses().to_vec(), |pose| pose.translation())?;
        let note = self.note(left.len(), views.len());
        Ok((ViewSpace::new(left)?, note))
    }

    /// A note on the number of candidates left.
    pub fn note(&self, n_left: usize, n: usize) -> Option<String> {
        (!self.is_default()).then(|| format!("within reach: {n_left} of {n} candidates"))
    }
}

fn bounds([x0, y0, z0, x1, y1, z1]: &[f64; 6]) -> Aabb {
    Aabb { min: DVec3::new(*x0, *y0, *z0), max: DVec3::new(*x1, *y1, *z1) }
}
