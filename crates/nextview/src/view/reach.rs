use crate::Error;
use crate::geometry::{Aabb, Pose};
use glam::DVec3;
use std::fmt::Debug;

/// Where a robot can hold the camera.
pub trait Reachability: Debug + Send + Sync {
    /// Returns the pose in which the camera can be held: this one, or if necessary one turned about the
    /// optical axis, which shows the same. `None` if the robot cannot reach it.
    fn held(&self, world_from_camera: &Pose) -> Option<Pose>;

    /// Fails on the first value out of range.
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }
}

/// The positions at which a robot can hold the camera. By default, all.
///
/// ```
/// use glam::DVec3;
/// use nextview::view::{Reach, ReachSphere, generate};
///
/// let arm = ReachSphere { base: DVec3::new(0.0, -0.5, 0.0), min_radius: 0.2, max_radius: 0.7 };
/// let reach = Reach { sphere: Some(arm), ..Reach::default() };
/// let views = generate::hemisphere(DVec3::ZERO, 0.3, 100).unwrap().restricted(|position| reach.contains(position));
/// assert!((0..100).any(|view| views.is_within_reach(view)));
/// assert!(!reach.contains(DVec3::new(0.0, 0.3, 0.0)));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reach {
    /// The reach of the robot's arm; `None` for no limit.
    pub sphere: Option<ReachSphere>,
    /// Boxes, metres: the camera must be in one of them. If there are none, it may be anywhere.
    pub allowed: Vec<Aabb>,
    /// Boxes that the camera must stay out of, metres.
    pub forbidden: Vec<Aabb>,
}

/// The space between two spheres around the base of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachSphere {
    /// Position of the arm's base, metres.
    pub base: DVec3,
    /// Minimum distance of the camera from the base, metres, at least 0.
    pub min_radius: f64,
    /// Maximum distance of the camera from the base, metres, above `min_radius`.
    pub max_radius: f64,
}

impl Reachability for Reach {
    fn held(&self, world_from_camera: &Pose) -> Option<Pose> {
        self.contains(world_from_camera.translation()).then_some(*world_from_camera)
    }

    fn check(&self) -> Result<(), Error> {
        if let Some(ReachSphere { base, min_radius, max_radius }) = self.sphere {
            if !base.is_finite() {
                return Err(Error::invalid("base", base, "a finite position"));
            }
            if !(min_radius >= 0.0 && min_radius < max_radius && max_radius.is_finite()) {
                let radii = format!("{min_radius} to {max_radius} m");
                return Err(Error::invalid(
                    "reach",
                    radii,
                    "finite and at least 0, the first below the second",
                ));
            }
        }
        let is_box = |Aabb { min, max }: &Aabb| min.is_finite() && max.is_finite() && min.cmple(*max).all();
        match self.allowed.iter().chain(&self.forbidden).find(|bounds| !is_box(bounds)) {
            Some(Aabb { min, max }) => {
                let corners = format!("{min} to {max}");
                Err(Error::invalid("box", corners, "finite corners, the lowest first"))
            }
            None => Ok(()),
        }
    }
}

impl Reach {
    /// Restricts the positions to this box.
    pub fn within(mut self, bounds: Aabb) -> Self {
        if self.allowed.is_empty() {
            self.allowed.push(bounds);
        }
        for Aabb { min, max } in &mut self.allowed {
            // A box entirely outside becomes a part of the border.
            (*min, *max) = (min.clamp(bounds.min, bounds.max), max.clamp(bounds.min, bounds.max));
        }
        self
    }

    /// Whether the camera can be at this position.
    pub fn contains(&self, position: DVec3) -> bool {
        let is_in = |bounds: &Aabb| bounds.contains(position);
        let is_allowed = self.allowed.is_empty() || self.allowed.iter().any(is_in);
        let is_reached = self.sphere.is_none_or(|sphere| {
            let distance = position.distance(sphere.base);
            distance >= sphere.min_radius && distance <= sphere.max_radius
        });
        is_allowed && is_reached && !self.forbidden.iter().any(is_in)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn within_a_box_is_where_both_are() {
        let cube = |x: f64| Aabb::cube(DVec3::X * x, 1.0);
        let of = |allowed: &[Aabb], x: f64| {
            let reach = Reach { allowed: allowed.to_vec(), ..arm(0.0, 10.0) }.within(cube(0.0));
            reach.check().unwrap();
            reach.contains(DVec3::X * x)
        };
        assert!(of(&[], 0.5) && !of(&[], 1.5));
        assert!(of(&[cube(0.7)], 0.5) && !of(&[cube(0.7)], -0.5) && !of(&[cube(0.7)], 1.5));
        assert!(!of(&[cube(5.0)], 0.5) && !of(&[cube(5.0)], 5.0));
    }

    fn arm(min_radius: f64, max_radius: f64) -> Reach {
        let sphere = ReachSphere { base: DVec3::X, min_radius, max_radius };
        Reach { sphere: Some(sphere), ..Reach::default() }
    }

    #[test]
    fn all_conditions_must_hold() {
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        assert!(Reach::default().contains(at(1e9)));
        let reach = Reach {
            allowed: vec![Aabb::cube(at(1.0), 0.5), Aabb::cube(at(3.0), 0.5)],
            forbidden: vec![Aabb::cube(at(3.4), 0.2)],
            ..arm(0.25, 2.3)
        };
        let reached = [0.6, 1.0, 1.4, 2.0, 2.9, 3.25, 3.4].map(|x| reach.contains(at(x)));
        assert_eq!(reached, [true, false, true, false, true, false, false]);
    }

    #[test]
    fn refuses_what_is_no_sphere_and_no_box() {
        assert!(arm(0.0, 1.0).check().is_ok() && Reach::default().check().is_ok());
        for reach in [arm(1.0, 1.0), arm(-1.0, 1.0), arm(0.0, f64::INFINITY), arm(f64::NAN, 1.0)] {
            assert!(reach.check().unwrap_err().to_string().starts_with("reach is "));
        }
        let turned = Aabb { min: DVec3::ONE, max: DVec3::ZERO };
        assert!(Reach { allowed: vec![turned], ..Reach::default() }.check().is_err());
        let endless = Aabb::EVERYWHERE;
        assert!(Reach { forbidden: vec![endless], ..Reach::default() }.check().is_err());
    }
}
