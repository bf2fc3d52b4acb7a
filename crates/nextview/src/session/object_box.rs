use crate::geometry::Aabb;
use serde::{Deserialize, Serialize};

/// What is known of the object's place and size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ObjectBox {
    /// It lies in this box, metres.
    Known(Aabb),
    /// Nothing. The first frame must show some of it: the object is the nearest thing there (a thing that
    /// does not reach into the middle half of the image counts as twice as far), and whatever later frames
    /// show that hangs together with it. The box is the cube around the middle of the points seen so far, a
    /// tenth wider than their longest side and two voxels more on each side, rounded to whole voxels; so it
    /// grows as more is seen (the dynamic box of Daudelin & Campbell 2017). What the object touches belongs
    /// to it, and so does what is no farther away than [`max_gap`](super::SessionConfig::max_gap), unless it
    /// is a [`Table`](super::Table), which may be 25 mm and 3 degrees off in a frame whose pose is wrong.
    Growing,
}
