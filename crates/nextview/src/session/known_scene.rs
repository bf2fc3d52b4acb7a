use super::SessionConfig;
use super::alignment::Alignment;
use super::location::Location;
use super::locator::Locator;
use super::report::MapReport;
use super::scan_map::{MapRules, Place, ScanMap};
use crate::map::MapUpdate;
use crate::registration::{KnownSurface, Registration};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled, Error};

/// All that the frames have shown: where the object is, its surface, and the map.
///
/// A session adds a frame to a copy, so that a cancelled observation leaves no trace.
#[derive(Clone, Debug)]
pub(super) struct KnownScene {
    pub locator: Locator,
    pub map: ScanMap,
    pub alignment: Alignment,
    /// The box that was found has too many voxels and was not adopted.
    pub is_box_too_large: bool,
}

/// What a frame changed.
pub(super) struct Added {
    pub update: MapUpdate,
    pub report: MapReport,
    /// Where the object is; none if that is as before.
    pub moved: Option<Location>,
}

impl KnownScene {
    /// Before the first frame, and where the object then is known to be. For a checked configuration.
    pub fn new(config: &SessionConfig) -> Result<(Self, Option<Location>), Error> {
        let &SessionConfig { voxel_size, sensor_model, rays, background, registration, .. } = config;
        let known = registration.enabled.then(|| KnownSurface::new(registration)).transpose()?;
        let rules = MapRules { voxel_size, sensor_model, rays, background };
        let mut scene = Self {
            locator: Locator::new(config.object_box, config.table, voxel_size, config.max_gap),
            map: ScanMap::new(rules, Place::default()),
            alignment: Alignment::new(known),
            is_box_too_large: false,
        };
        let location = scene.locate(config, &[], &Cancel::default())?;
        Ok((scene, location))
    }

    /// Adds the last of these frames, in its final pose.
    pub fn add(
        &mut self,
        config: &SessionConfig,
        frames: &[Frame],
        registration: Option<Registration>,
        cancel: &Cancel,
    ) -> Result<Added, Cancelled> {
        let moved = self.locate(config, frames, cancel)?;
        let frame = frames.last().expect("a frame was added");
        self.alignment.remember(frame, self.map.place().bounds, registration, cancel)?;
        let update = self.map.integrate(frame, cancel)?;
        self.refine_what_is_known(config, frames, cancel)?;
        let snapshot = self.map.finest_snapshot(cancel)?;
        let report = snapshot.map(|snapshot| MapReport::unless(&snapshot, cancel)).transpose()?;
        Ok(Added { update, report: report.unwrap_or_default(), moved })
    }

    /// Adopts the box found from all frames, the last of which is not mapped yet, unless it is too large.
    fn locate(
        &mut self,
        config: &SessionConfig,
        frames: &[Frame],
        cancel: &Cancel,
    ) -> Result<Option<Location>, Cancelled> {
        let location = self.locator.locate(frames, cancel)?;
        let bounds = location.place.bounds;
        self.is_box_too_large = bounds.is_some_and(|bounds| config.check_size(&bounds).is_err());
        if location.place == self.map.place() || self.is_box_too_large {
            return Ok(None);
        }
        let known = &frames[..frames.len().saturating_sub(1)];
        let is_first_box = self.map.place().bounds.is_none();
        self.map.move_to(location.place, known, cancel)?;
        let rule = config.multi_resolution;
        if let (true, Some(bounds)) = (is_first_box && rule.enabled, location.place.bounds) {
            let n_halvings = rule.n_halvings(config.voxel_size, bounds.longest_side());
            self.map.plan_in(n_halvings, known, cancel)?;
        }
        Ok(Some(location))
    }

    /// Halves the voxels that planning uses as long as the map in them is known well enough: algorithm 1, eq.
    /// (9).
    fn refine_what_is_known(
        &mut self,
        config: &SessionConfig,
        frames: &[Frame],
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let rule = config.multi_resolution;
        while rule.enabled && !self.map.is_finest() {
            let Some(snapshot) = self.map.planning_snapshot(cancel)? else { break };
            if snapshot.entropy_share_unless(cancel)? >= rule.q_thresh {
                break;
            }
            self.map.refine(frames, cancel)?;
        }
        Ok(())
    }
}
