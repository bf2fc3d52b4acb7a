//! Tracking: the pose of a camera that does not know it, from the known surface.

use super::known_poses::KnownPoses;
use super::{Guidance, LiveScan};
use crate::Fault;
use nextview::geometry::Pose;
use nextview::registration::{GivenPoses, Registration, RegistrationMode, Verdict};
use nextview::sensor::DepthImage;

/// The usual viewing distance of depth cameras in metres, until the object's place is known.
const USUAL_DISTANCE: f64 = 0.5;

impl LiveScan {
    /// The motion from this pose to the next view; `None` if the scan is over. Plans if no view was requested
    /// yet.
    pub fn guidance(&mut self, world_from_camera: &Pose) -> Result<Option<Guidance>, Fault> {
        let Some(next) = self.next()? else { return Ok(None) };
        let wanted = next.world_from_camera;
        let middle = self.scan().session.bounds().map(|bounds| bounds.center());
        let distance = middle.map_or(USUAL_DISTANCE, |middle| middle.distance(wanted.translation()));
        Ok(Some(Guidance::to(&wanted, world_from_camera, distance)))
    }

    /// Returns the pose of a depth image, without observing it: where it fits the known surface, near the
    /// last located image, the last frame, or the requested view.
    ///
    /// Requires registration with [tracked](GivenPoses::Tracked) poses. Fails if the camera is lost: if the
    /// image fits nowhere near these poses, or the surface does not constrain it.
    pub fn locate(&mut self, depth: &DepthImage) -> Result<Pose, Fault> {
        let registration = self.config().registration;
        if registration.mode() != RegistrationMode::On || registration.given_poses != GivenPoses::Tracked {
            let fault = Fault::request("a frame without a pose cannot be placed");
            let remedy = "state its pose, or set `registration.enabled` = true and \
                          `registration.given_poses` = tracked";
            return Err(Fault {
                key: Some("registration.given_poses".to_owned()),
                ..fault.with_remedy(remedy)
            });
        }
        let Some(last) = self.scan().steps.last() else { return self.first_pose() };
        let last = last.world_from_camera();
        let KnownPoses { asked, located } = self.poses;
        let mut best: Option<Registration> = None;
        let mut refused = None;
        for guess in [located, last, asked].into_iter().flatten() {
            let frame = self.camera().frame(depth.clone(), guess)?;
            let Some(found) = self.scan().session.locate(&frame)? else { continue };
            if !found.is_accepted() {
                refused.get_or_insert(found.verdict);
            } else if best.is_none_or(|best| found.misfit < best.misfit) {
                best = Some(found);
            }
        }
        match best {
            Some(found) => {
                self.poses.located = Some(found.world_from_camera);
                Ok(found.world_from_camera)
            }
            None => Err(lost(refused)),
        }
    }

    fn first_pose(&self) -> Result<Pose, Fault> {
        let live = self.config().source.live();
        live.and_then(|live| live.first_pose).ok_or_else(|| {
            let fault = Fault::request("the first frame defines the world and needs a pose");
            let fault = fault.with_remedy("state its pose, or `live.first_pose`");
            Fault { key: Some("live.first_pose".to_owned()), ..fault }
        })
    }
}

fn lost(refused: Option<Verdict>) -> Fault {
    let why = match refused {
        Some(Verdict::LittleOverlap) => "the image shows too little of the known surface",
        Some(Verdict::Sliding) => "the surface in view is too flat or too round to fix the pose",
        Some(_) => "the image fits the known surface only far from where the camera was",
        None => "no surface is known yet",
    };
    let fault = Fault::request(format!("the camera is lost: {why}"));
    fault.with_remedy("move back to where the last frame was taken, and continue from there in small steps")
}
