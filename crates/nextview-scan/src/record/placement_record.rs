use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::placement::{NextPlacement, Turn, TurnRefusal};
use serde::{Deserialize, Serialize};

/// How an object was turned since the scan before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TurnRecord {
    /// Why that is not known; none if it is. The model then holds this scan alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refusal: Option<TurnRefusal>,
    /// Where the origin of the scan before is now; this and all else none if it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_m: Option<[f64; 3]>,
    /// The rotation from then to now.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quaternion_xyzw: Option<[f64; 4]>,
    /// Share, 0..=1, of the surface shown now that was known before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlap: Option<f64>,
    /// Root mean square distance of that from the surface known before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual_mm: Option<f64>,
    /// Mean distance by which it misplaces the true surface; none where that is not known. Of a symmetric
    /// object, every pose is right that puts it onto itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_mm: Option<f64>,
}

/// How to lay an object down, so that what cannot be seen now can be seen then.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PlacementRecord {
    /// The side to lay it on: a direction of unit length in the world of now, from the middle of the object.
    pub down: [f64; 3],
    /// Share, 0..=1, of the unseen surface that it frees.
    pub freed_share: f64,
    /// Share, 0..=1, of the surface that is unseen now.
    pub unseen_share: f64,
}

impl From<Result<Turn, TurnRefusal>> for TurnRecord {
    fn from(turn: Result<Turn, TurnRefusal>) -> Self {
        let known = turn.ok();
        let pose = |turn: Turn| -> Pose { turn.now_from_before };
        Self {
            refusal: turn.err(),
            position_m: known.map(|turn| pose(turn).translation().to_array()),
            quaternion_xyzw: known.map(|turn| pose(turn).rotation().to_array()),
            overlap: known.map(|turn| turn.overlap),
            residual_mm: known.map(|turn| 1e3 * turn.residual),
            error_mm: None,
        }
    }
}

impl TurnRecord {
    /// Whether it is known.
    pub fn is_known(&self) -> bool {
        self.refusal.is_none()
    }

    /// Takes points of the scan before to where they are now; none if it is not known.
    pub fn now_from_before(&self) -> Option<Pose> {
        let rotation = DQuat::from_array(self.quaternion_xyzw?);
        Pose::new(rotation, DVec3::from_array(self.position_m?)).ok()
    }
}

impl From<NextPlacement> for PlacementRecord {
    fn from(next: NextPlacement) -> Self {
        let NextPlacement { rest, freed_share, unseen_share } = next;
        Self { down: rest.down.to_array(), freed_share, unseen_share }
    }
}
