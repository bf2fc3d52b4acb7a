/// A planning ray through the snapshot: its crossings before it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray<'a> {
    /// The free and unknown voxels on the ray, in order.
    pub crossings: &'a [Crossing],
    /// How the ray ends.
    pub end: RayEnd,
}

/// A voxel on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Index in the snapshot.
    pub voxel: u32,
    /// P(vis) of the paper's eq. (2): the product of 1 - P(occupied) over the voxels before this one.
    pub visibility: f32,
}

/// How a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayEnd {
    /// At this occupied voxel.
    Occupied(Crossing),
    /// At the border of the box.
    LeftBox,
    /// Where its visibility fell below the caster's limit.
    Faded,
}
