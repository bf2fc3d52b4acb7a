use super::known_situation::surroundings;
use super::{Session, SetAside, Views};
use crate::diagnosis::{Suspicion, suspect, suspect_poses};
use crate::geometry::{Aabb, Plane, Pose};
use crate::map::{OccupancyMap, Snapshot};
use crate::motion::Trajectory;
use crate::object::{ObjectBox, OtherBody, TableTops};
use crate::placement::{NextPlacement, Turn, TurnRefusal, next_placement};
use crate::registration::{PoseFit, Registration, RegistrationMode};
use crate::sensor::{DepthRange, Frame, SurfaceNoise};
use crate::view::ViewSpace;
use crate::{Cancel, Cancelled, Error};

/// What is known so far.
impl Session {
    /// Aligns a frame to the surface known so far, without adding it. `None` if
    /// [registration](crate::registration) is off, and while no surface is known.
    pub fn locate(&self, frame: &Frame) -> Result<Option<Registration>, Cancelled> {
        self.scene.register(frame, &self.cancel)
    }

    /// Returns the trajectory from the pose of the last frame to a view, such as the next one. It avoids the
    /// bounding sphere of the known part of the object and stays above its table. Before the first frame, the
    /// camera is assumed to be there already.
    ///
    /// Fails if it leaves [`Pose::REACH`].
    pub fn trajectory_to(&self, world_from_camera: &Pose) -> Result<Trajectory, Error> {
        let Some(last) = self.scene.frames.places.last() else {
            return Ok(Trajectory::at(*world_from_camera));
        };
        self.trajectory(last, world_from_camera)
    }

    /// Returns the trajectory from one view to another.
    pub fn trajectory(&self, from: &Pose, to: &Pose) -> Result<Trajectory, Error> {
        Trajectory::new(from, to, &surroundings(&self.scene), &self.config.motion)
    }

    /// Returns the map so far, in the finest voxels.
    pub fn map(&self) -> &OccupancyMap {
        self.scene.map.finest()
    }

    /// Returns the known state of the object's box, in the finest voxels; `None` before an object is found.
    pub fn snapshot(&self) -> Option<Snapshot> {
        self.scene.map.finest_snapshot(&Cancel::default()).expect("nobody cancels")
    }

    /// Returns the object's box, metres, without the part below its table; `None` before an object is found.
    pub fn bounds(&self) -> Option<Aabb> {
        self.scene.map.place().bounds
    }

    /// Returns the table under the object; `None` if there is none, or before it is found.
    pub fn table(&self) -> Option<Plane> {
        self.scene.map.place().table.map(|table| table.plane)
    }

    /// Returns the top of the table in each frame; `None` if there is no table, or before table and object
    /// are found.
    pub fn table_tops(&self) -> Option<TableTops> {
        self.scene.map.place().table_tops()
    }

    /// Returns the other bodies within a metre of an object whose box grows, nearest first; empty if the box
    /// is known. A body is at least 20 connected points with free space around most of their outline: walls
    /// and floors are not bodies.
    pub fn other_bodies(&self) -> Result<Vec<OtherBody>, Cancelled> {
        self.scene.locator.other_bodies(&self.scene.frames.mapped, &self.cancel)
    }

    /// Returns the likely reason why the frames show nothing of the object, or do not fit together; `None` if
    /// all is well, or no reason is likely. See [`suspect`], and, for an object whose box grows among fixed
    /// views, [`suspect_poses`].
    pub fn suspicion(&self) -> Option<Suspicion> {
        let known = match self.config.object_box {
            ObjectBox::Known(bounds) => Some(bounds),
            ObjectBox::Growing => None,
        };
        let boundless = self.scene.is_box_too_large.then_some(Suspicion::Boundless);
        let frames = self.scene.frames.of_now();
        let poses = || match (&self.views, known, frames.first()) {
            (Views::Fixed(views), None, Some(first)) => suspect_poses(first, views.poses()),
            _ => None,
        };
        // Aligned frames need not agree in the given poses.
        let apart = || match self.bounds() {
            Some(bounds) if self.config.registration.mode() == RegistrationMode::Off => {
                let voxel_size = self.config.voxel_size;
                let distance =
                    crate::registration::apart(frames, bounds, voxel_size, &self.cancel).ok()??;
                Some(Suspicion::Apart { distance })
            }
            _ => None,
        };
        suspect(frames, known, self.config.depth_range).or_else(poses).or(boundless).or_else(apart)
    }

    /// Whether frames are aligned to the surface measured before. With [`RegistrationMode::Auto`], this
    /// begins once the given poses disagree, and ends if most frames cannot be aligned.
    pub fn aligns_frames(&self) -> bool {
        self.scene.alignment.is_active()
    }

    /// Returns how well the aligned frames fit together, in the order of those of an earlier placement and of
    /// [`frames`](Self::frames); `None` if frames are not aligned to each other.
    pub fn pose_fit(&self) -> Option<&PoseFit> {
        self.scene.alignment.fit()
    }

    /// Returns the range of depths that the camera measures, metres.
    pub fn depth_range(&self) -> DepthRange {
        self.config.depth_range
    }

    /// Returns the random error of the camera.
    pub fn surface_error(&self) -> SurfaceNoise {
        self.config.surface_error
    }

    /// Returns the flag that cancels decisions and observations.
    pub fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// Returns the edge of the voxels in which the next view is planned, metres.
    pub fn planning_voxel_size(&self) -> f64 {
        self.scene.map.planning_voxel_size()
    }

    /// Returns the frames in the map, in their final poses and in the order in which they entered it: all
    /// observed ones, oldest first, unless registration [set some aside](Self::set_aside), for a while or for
    /// good.
    pub fn frames(&self) -> &[Frame] {
        self.scene.frames.of_now()
    }

    /// Returns the frames of the placement [before](Self::after), moved with the object, once its turn is
    /// known; empty until then. They show only the object.
    pub fn earlier_frames(&self) -> &[Frame] {
        self.scene.frames.of_before()
    }

    /// Returns how the object was turned since the placement [before](Self::after), or why that is unknown;
    /// `None` if there is none, and before the first frame.
    pub fn turn(&self) -> Option<Result<Turn, TurnRefusal>> {
        self.scene.earlier.as_ref()?.turn
    }

    /// Returns the frames of both placements, the earlier ones first, moved with the object and reduced to
    /// it: a ray that ended on something else met nothing, or measured nothing if the object may be behind
    /// it. `None` unless the [turn](Self::turn) is known.
    pub fn frames_of_object(&self) -> Result<Option<Vec<Frame>>, Cancelled> {
        let earlier = self.earlier_frames();
        let now = if earlier.is_empty() { None } else { self.scene.shown_object(&self.cancel)? };
        Ok(now.map(|now| earlier.iter().chain(now.frames()).cloned().collect()))
    }

    /// Returns the placement that exposes most of the hidden surface; `None` if there is no table, before the
    /// object is found, and if hardly any surface would be exposed.
    pub fn next_placement(&self) -> Option<NextPlacement> {
        next_placement(&self.snapshot()?, self.table()?)
    }

    /// Returns, for each of [`frames`](Self::frames), its number among all observed frames, from 0.
    pub fn frame_numbers(&self) -> &[usize] {
        &self.scene.frames.numbers
    }

    /// Returns the frames that could not be aligned so far, oldest first. They are in neither map nor model;
    /// each is tried again whenever another frame fits. Empty without registration, and if the aligned frames
    /// prove that the given poses are correct.
    pub fn set_aside(&self) -> &[SetAside] {
        &self.scene.frames.set_aside
    }

    /// Returns the views taken so far, in order.
    pub fn visited(&self) -> &[usize] {
        &self.visited
    }

    /// Returns the view candidates in their current poses.
    pub fn views(&self) -> &ViewSpace {
        &self.candidates
    }
}
