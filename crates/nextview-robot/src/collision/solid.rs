use crate::ShapeKind;
use glam::{DMat3, DVec3};
use nextview::geometry::Pose;

/// A convex solid around the origin of its frame: a core, expanded by `round`.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    core: SolidCore,
    round: f64,
    /// Maximum distance of a point from the origin in metres.
    radius: f64,
}

#[derive(Clone, Debug)]
enum SolidCore {
    Point,
    Box(DVec3),
    Cylinder { radius: f64, half: f64 },
    Hull { points: Vec<DVec3>, half: DVec3 },
}

/// A rigid transform with a rotation matrix, which is faster for many points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub rotation: DMat3,
    pub translation: DVec3,
}

impl From<Pose> for Placement {
    fn from(pose: Pose) -> Self {
        Self { rotation: pose.rotation_matrix(), translation: pose.translation() }
    }
}

impl Placement {
    /// Multiplies `a_from_b` by `b_from_c` to get `a_from_c`.
    pub fn times(&self, b_from_c: &Self) -> Self {
        Self { rotation: self.rotation * b_from_c.rotation, ..self.moved(b_from_c.translation) }
    }

    /// Moves the origin to this point of the frame and keeps the rotation.
    pub fn moved(&self, origin: DVec3) -> Self {
        Self { rotation: self.rotation, translation: self.rotation * origin + self.translation }
    }

    /// Multiplies the inverse of `a_from_b` by `a_from_c` to get `b_from_c`.
    pub fn inverse_times(&self, a_from_c: &Self) -> Self {
        let back = self.rotation.transpose();
        Self {
            rotation: back * a_from_c.rotation,
            translation: back * (a_from_c.translation - self.translation),
        }
    }
}

impl Solid {
    /// Returns the solid, and its origin in the frame of the shape: for a hull, the middle of its bounding
    /// box.
    pub fn new(kind: &ShapeKind) -> (Self, DVec3) {
        let mut middle = DVec3::ZERO;
        let (core, round, radius) = match kind {
            ShapeKind::Box(half) => (SolidCore::Box(*half), 0.0, half.length()),
            ShapeKind::Sphere(radius) => (SolidCore::Point, *radius, *radius),
            &ShapeKind::Cylinder { radius, length } => {
                (SolidCore::Cylinder { radius, half: 0.5 * length }, 0.0, radius.hypot(0.5 * length))
            }
            ShapeKind::Hull(points) => {
                let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
                let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
                middle = 0.5 * (low + high);
                let points: Vec<DVec3> = points.iter().map(|point| *point - middle).collect();
                let radius = points.iter().map(|point| point.length()).fold(0.0, f64::max);
                (SolidCore::Hull { points, half: 0.5 * (high - low) }, 0.0, radius)
            }
        };
        (Self { core, round, radius }, middle)
    }

    /// The cube with faces `half` metres from the origin.
    pub fn cube(half: f64) -> Self {
        let half = DVec3::splat(half);
        Self { core: SolidCore::Box(half), round: 0.0, radius: half.length() }
    }

    /// Thickness of the layer around the core in metres.
    pub fn round(&self) -> f64 {
        self.round
    }

    /// Maximum distance of a point from the origin in metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The farthest point of the core in a direction, which need not have unit length.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        match &self.core {
            SolidCore::Point => DVec3::ZERO,
            SolidCore::Box(half) => half.copysign(direction),
            SolidCore::Cylinder { radius, half } => {
                let aside = direction.truncate().try_normalize().unwrap_or_default() * *radius;
                aside.extend(half.copysign(direction.z))
            }
            SolidCore::Hull { points, .. } => {
                let (mut best, mut highest) = (DVec3::ZERO, f64::NEG_INFINITY);
                for point in points {
                    let height = point.dot(direction);
                    if height > highest {
                        (best, highest) = (*point, height);
                    }
                }
                best
            }
        }
    }

    /// Distance of a point from the solid in metres: exact or, for a hull, a lower bound from its bounding
    /// box; 0 inside.
    pub fn outside(&self, point: DVec3) -> f64 {
        match self.core {
            SolidCore::Point => (point.length() - self.round).max(0.0),
            SolidCore::Box(half) | SolidCore::Hull { half, .. } => {
                (point.abs() - half).max(DVec3::ZERO).length()
            }
            SolidCore::Cylinder { radius, half } => {
                let aside = (point.truncate().length() - radius).max(0.0);
                aside.hypot((point.z.abs() - half).max(0.0))
            }
        }
    }

    /// The corners of a box around the solid.
    pub fn corners(&self) -> [DVec3; 8] {
        let half = match self.core {
            SolidCore::Point => DVec3::splat(self.round),
            SolidCore::Box(half) | SolidCore::Hull { half, .. } => half,
            SolidCore::Cylinder { radius, half } => DVec3::new(radius, radius, half),
        };
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            half * DVec3::new(sign(0), sign(1), sign(2))
        })
    }
}

/// The fault in the size of a shape, if any.
pub(super) fn fault(kind: &ShapeKind) -> Option<String> {
    let is_size = |size: f64| size > 0.0 && size < 1e6;
    let fault = |what: &str, value: String| Some(format!("{what} is {value}, expected positive metres"));
    match kind {
        ShapeKind::Box(half) if !half.to_array().into_iter().all(is_size) => {
            fault("half of the sides of a box", half.to_string())
        }
        ShapeKind::Sphere(radius) if !is_size(*radius) => fault("radius of a sphere", radius.to_string()),
        ShapeKind::Cylinder { radius, length } if !is_size(*radius) || !is_size(*length) => {
            fault("radius and length of a cylinder", format!("{radius} and {length}"))
        }
        ShapeKind::Hull(points) if points.is_empty() => Some("a hull has no points".to_owned()),
        ShapeKind::Hull(points) => {
            let bad = points.iter().find(|point| !point.abs().cmplt(DVec3::splat(1e6)).all());
            bad.map(|point| format!("a point of a hull is {point}, expected metres"))
        }
        _ => None,
    }
}
