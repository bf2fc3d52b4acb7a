//! Pose of the camera in the world.

use crate::messages::{PoseStamped, TfMessage};
use crate::notes::Notes;
use nextview::geometry::Pose;
use nextview_recording::ros::{TransformError, TransformTree};

/// How long transforms are kept in seconds, as in tf2.
const HISTORY: f64 = 10.0;

/// Name of the camera's frame if poses come from the topic of poses.
const CAMERA: &str = "the camera";

pub struct PoseHistory {
    tree: TransformTree,
    world: String,
    /// Whether poses come from transforms to the images' frame, not from the topic of poses.
    from_transforms: bool,
}

impl PoseHistory {
    pub fn new(world: &str, from_transforms: bool) -> Self {
        Self { tree: TransformTree::new(HISTORY), world: world.to_owned(), from_transforms }
    }

    pub fn transforms(&mut self, message: &TfMessage, is_static: bool, notes: &mut Notes) {
        for transform in &message.transforms {
            let (parent, child) = (&transform.header.frame_id, &transform.child_frame_id);
            let time = (!is_static).then(|| transform.header.stamp.seconds());
            match Pose::try_from(&transform.transform) {
                Ok(pose) => self.insert(parent, child, time, pose, notes),
                Err(error) => notes.add("/tf", format!("'{child}' in '{parent}': {error}")),
            }
        }
    }

    pub fn pose(&mut self, message: &PoseStamped, notes: &mut Notes) {
        match Pose::try_from(&message.pose) {
            Ok(pose) => {
                let time = message.header.stamp.seconds();
                self.insert(&message.header.frame_id, CAMERA, Some(time), pose, notes);
            }
            Err(error) => notes.add("pose", error.to_string()),
        }
    }

    /// The pose of the frame at a time in seconds.
    pub fn at(&self, frame: &str, time: f64) -> Result<Pose, TransformError> {
        let frame = if self.from_transforms { frame } else { CAMERA };
        self.tree.lookup(&self.world, frame, time)
    }

    /// Adds a transform; static if it has no time.
    fn insert(&mut self, parent: &str, child: &str, time: Option<f64>, pose: Pose, notes: &mut Notes) {
        let about = if self.from_transforms { "/tf" } else { "pose" };
        let inserted = match time {
            None => self.tree.insert_static(parent, child, pose),
            Some(time) => self.tree.insert(parent, child, time, pose),
        };
        match (inserted, time) {
            (Ok(()), _) => (),
            (Err(error @ TransformError::ClockBackwards { .. }), Some(time)) => {
                notes.add(about, format!("{error}; all transforms of moving frames are discarded"));
                self.tree.forget_motion();
                // Any time is valid in an empty history.
                let _ = self.tree.insert(parent, child, time, pose);
            }
            (Err(error), _) => notes.add(about, error.to_string()),
        }
    }
}
