//! Poses of the camera: from a topic of poses, or from transforms.

use super::messages::Transform;
use crate::ros::TransformTree;
use crate::trajectory::CameraTrajectory;
use crate::{RecordingError, rigid};
use nextview::geometry::Pose;
use std::collections::BTreeMap;

/// The source of the camera's poses.
pub(super) enum PoseSource {
    Topic(CameraTrajectory),
    Transforms { tree: TransformTree, world: String, camera: String },
}

impl PoseSource {
    /// Uses transforms: the camera's frame in the world's, by default the root of its tree.
    pub fn of_transforms(
        tree: TransformTree,
        camera: &str,
        world: Option<&str>,
    ) -> Result<Self, RecordingError> {
        let of_camera =
            |problem: String| format!("the pose of '{camera}', the frame of the images: {problem}");
        let world = match world {
            Some(world) => world.to_owned(),
            None => tree
                .root_of(camera)
                .map_err(|error| RecordingError::Content(of_camera(error.to_string())))?
                .to_owned(),
        };
        // At any time: a missing pose at some times is a fault of single images.
        if let Err(error) = tree.check_connected(&world, camera) {
            let problem = of_camera(format!("{error}; choose the world frame"));
            return Err(RecordingError::Option { key: "world_frame", problem });
        }
        Ok(Self::Transforms { tree, world, camera: camera.to_owned() })
    }

    /// The pose at a time in seconds; or why there is none.
    pub fn at(&self, time: f64) -> Result<Pose, String> {
        match self {
            Self::Topic(trajectory) => trajectory.at(time),
            Self::Transforms { tree, world, camera } => {
                let pose = tree.lookup(world, camera, time).map_err(|error| error.to_string())?;
                rigid::from_quaternion(pose.translation(), pose.rotation())
            }
        }
    }
}

/// The transforms of a file, and notes on those left out.
pub(super) struct Transforms {
    pub tree: TransformTree,
    pub n_transforms: usize,
    /// By frame, the first fault and the number of faulty transforms.
    faults: BTreeMap<String, (String, usize)>,
}

impl Default for Transforms {
    fn default() -> Self {
        Self { tree: TransformTree::new(f64::INFINITY), n_transforms: 0, faults: BTreeMap::new() }
    }
}

impl Transforms {
    /// Adds a transform. Invalid ones are skipped: those of unneeded joints are often wrong.
    pub fn add(&mut self, transform: Transform<'_>, is_static: bool) {
        let Transform { header, child, parent_from_child } = transform;
        let added = parent_from_child.map_err(|error| error.to_string()).and_then(|pose| {
            let added = match is_static {
                true => self.tree.insert_static(header.frame, child, pose),
                false => self.tree.insert(header.frame, child, header.time, pose),
            };
            added.map_err(|error| error.to_string())
        });
        match added {
            Ok(()) => self.n_transforms += 1,
            Err(error) => self.faults.entry(child.to_owned()).or_insert((error, 0)).1 += 1,
        }
    }

    /// The skipped transforms, one sentence per frame.
    pub fn notes(&self) -> Vec<String> {
        let note = |(frame, (error, n)): (&String, &(String, usize))| {
            format!("{n} transforms of '{frame}' are left out, the first because {error}")
        };
        self.faults.iter().map(note).collect()
    }
}
