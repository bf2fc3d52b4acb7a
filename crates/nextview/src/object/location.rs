use super::place::Place;
use glam::DVec3;

/// The object's location according to the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Location {
    pub place: Place,
    /// The object's centre and half its longest side, metres: view candidates follow both.
    pub object: Option<(DVec3, f64)>,
    /// Factor by which the object may turn out to be larger, at least 1.
    pub may_grow: f64,
}
