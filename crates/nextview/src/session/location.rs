use super::scan_map::Place;
use glam::DVec3;

/// Where the object is, as far as the frames show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Location {
    pub place: Place,
    /// Where the object is and half its longest side, metres: view candidates follow both.
    pub object: Option<(DVec3, f64)>,
    /// By how much the object may turn out to be larger: a factor of its size, at least 1.
    pub may_grow: f64,
}
