use glam::DVec3;
use nextview::geometry::Pose;

/// A rigid part of an arm and the space that it takes up.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name, unique within the arm.
    pub name: String,
    /// The space that the link takes up, in its own frame; empty if that does not matter.
    pub shapes: Vec<Shape>,
}

/// A convex solid on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The frame of the solid in the frame of its link.
    pub link_from_shape: Pose,
    /// Its form and size.
    pub kind: ShapeKind,
}

/// The form of a solid around the origin of its frame; all lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeKind {
    /// A box by half of its sides.
    Box(DVec3),
    /// A ball by its radius.
    Sphere(f64),
    /// A cylinder along z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length along z, half of it to either side.
        length: f64,
    },
    /// The convex hull of these points, at least four that are not in a plane.
    Hull(Vec<DVec3>),
}
