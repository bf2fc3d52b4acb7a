use crate::Error;
use crate::geometry::Pose;
use crate::object::Location;
use crate::sensor::DepthRange;
use crate::view::{Reachability, ViewSpace};
use std::sync::Arc;

/// The view candidates of a session.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Views {
    /// Fixed poses. The first view is [one of them](super::SessionConfig::first_view).
    Fixed(ViewSpace),
    /// Poses that follow the known part of the object.
    Following {
        /// The first view, which is not a candidate.
        first: Pose,
        /// The candidates for an object at the origin whose longest side is 2 m ("size 1"), such as
        /// `generate::shell(DVec3::ZERO, 1.0, 1000, 0)`. They are placed [around](ViewSpace::around) the
        /// centre of the known part of the object, at distances proportional to half its longest side,
        /// clamped to the [range](ViewSpace::within_range) of the camera. For the range, an object shown by
        /// few frames is assumed to be larger than seen, by 50 % after one frame, half of that after two and
        /// so on: unseen parts must not be nearer than the camera measures. A candidate's number always means
        /// the same direction and relative distance. It stays taken once it was, even if the candidate has
        /// moved a little since.
        unit: ViewSpace,
        /// The reachability check for moved candidates. For fixed poses, use [`held`](ViewSpace::held).
        reach: Arc<dyn Reachability>,
    },
}

impl From<ViewSpace> for Views {
    fn from(views: ViewSpace) -> Self {
        Self::Fixed(views)
    }
}

impl Views {
    pub(super) fn check(&self) -> Result<(), Error> {
        match self {
            Self::Fixed(_) => Ok(()),
            Self::Following { reach, .. } => reach.check(),
        }
    }

    /// Returns the candidates of a camera of this range for an object at this location; the unit candidates
    /// while the location is unknown.
    pub(super) fn candidates(&self, location: &Location, range: DepthRange) -> ViewSpace {
        let views = match (self, location.object) {
            (Self::Fixed(views), _) => views.clone(),
            (Self::Following { unit, reach, .. }, Some((center, size))) => {
                // A view too far away loses a little accuracy, one too near everything.
                let extent = size * location.may_grow;
                unit.following(center, size).within_range(center, extent, range).held(&**reach)
            }
            (Self::Following { unit, .. }, None) => unit.clone(),
        };
        let is_clear = |position| location.place.table.is_none_or(|table| table.is_clear(position));
        views.restricted(is_clear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::Place;
    use crate::view::{Reach, generate};
    use glam::DVec3;

    #[test]
    fn candidates_keep_clear_of_what_was_not_seen_yet() {
        let unit = generate::shell(DVec3::ZERO, 1.0, 50, 0).unwrap();
        let views = Views::Following { first: unit.pose(0), unit, reach: Arc::new(Reach::default()) };
        let range = DepthRange { min: 0.17, max: 3.0 };
        let center = DVec3::new(0.1, 0.2, 0.3);
        let nearest = |may_grow| {
            let location = Location { place: Place::default(), object: Some((center, 0.02)), may_grow };
            let candidates = views.candidates(&location, range);
            candidates.poses().iter().map(|pose| pose.translation().distance(center)).fold(f64::MAX, f64::min)
        };
        assert!((nearest(1.0) - 0.19).abs() < 1e-12);
        assert!((nearest(1.75) - 0.205).abs() < 1e-12);
    }
}
