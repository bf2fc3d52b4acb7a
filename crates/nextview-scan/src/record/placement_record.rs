use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::placement::{NextPlacement, Turn, TurnRefusal};
use serde::{Deserialize, Serialize};

/// How an object was turned since the previous scan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TurnRecord {
    /// Why the turn is unknown; `None` if it is known. If unknown, the model contains only this scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refusal: Option<TurnRefusal>,
    /// Current position of the previous scan's origin; this and all following keys are `None` if the turn is
    /// unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_m: Option<[f64; 3]>,
    /// The rotation from the previous scan to this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quaternion_xyzw: Option<[f64; 4]>,
    /// Share, 0..=1, of the surface shown in this scan that was known before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlap: Option<f64>,
    /// Root mean square distance of that share from the surface known before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual_mm: Option<f64>,
    /// Mean distance by which the turn misplaces the true surface; `None` if that is unknown. For a symmetric
    /// object, every pose that maps it onto itself counts as right.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_mm: Option<f64>,
}

/// The placement that exposes most of the hidden surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PlacementRecord {
    /// The side to lay the object on: a unit vector in the current world, from the object's middle.
    pub down: [f64; 3],
    /// Share, 0..=1, of the unseen surface that it exposes.
    pub freed_share: f64,
    /// Share, 0..=1, of the surface that is unseen so far.
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
    /// Whether the turn is known.
    pub fn is_known(&self) -> bool {
        self.refusal.is_none()
    }

    /// Takes points of the previous scan to their current position; `None` if the turn is unknown.
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
