use crate::geometry::Aabb;
use serde::{Deserialize, Serialize};

/// How the object's box is determined.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ObjectBox {
    /// A known box, metres.
    Known(Aabb),
    /// A box that grows with the object. The first frame must show part of it: the object is the nearest
    /// thing there (a thing outside the middle half of the image counts as twice as far), and everything
    /// connected to it in later frames. The box is the cube around the centre of the points seen so far, a
    /// tenth wider than their longest side plus two voxels on each side, rounded to whole voxels (the dynamic
    /// box of Daudelin & Campbell 2017). Everything that touches the object or is within
    /// [`max_gap`](crate::session::SessionConfig::max_gap) belongs to it, except a [`Table`](super::Table),
    /// which may be 25 mm and 3 degrees off in a frame with a wrong pose.
    Growing,
}
