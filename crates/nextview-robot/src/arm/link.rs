use glam::DVec3;
use nextview::geometry::Pose;

/// A rigid part of an arm and its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name, unique within the arm.
    pub name: String,
    /// The shapes of the link in its own frame; empty if irrelevant.
    pub shapes: Vec<Shape>,
}

/// A convex solid on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The frame of the solid in the frame of its link.
    pub link_from_shape: Pose,
    /// Its kind and size.
    pub kind: ShapeKind,
}

/// The kind and size of a solid around the origin of its frame; all lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeKind {
    /// A box given by half its sides.
    Box(DVec3),
    /// A ball given by its radius.
    Sphere(f64),
    /// A cylinder along z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length along z, half of it on either side.
        length: f64,
    },
    /// The convex hull of these points: at least four, not all in a plane.
    Hull(Vec<DVec3>),
}
