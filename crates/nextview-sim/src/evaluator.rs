//! Evaluates a simulated scan against ground truth.

use crate::SimError;
use crate::scene::Scene;
use crate::surface::SurfaceCoverage;
use crate::truth::{ObjectVoxels, VoxelScore};
use fixedbitset::FixedBitSet;
use glam::DVec3;
use nextview::geometry::Pose;
use nextview::sensor::Frame;
use nextview::session::Session;
use std::collections::BTreeMap;

/// The current state of a scan, compared with the true object.
#[derive(Clone, Copy, Debug)]
pub struct Measures {
    /// The map in the finest voxels against the object voxels, in the block of the latter. Object voxels
    /// outside the session's box count as not covered; occupied voxels outside the block do not count.
    /// Includes the reachable object voxels if the evaluator knows them.
    pub voxels: VoxelScore,
    /// Number of object voxels truly seen: those with a point of the true surface measured by a pixel of a
    /// mapped frame, wherever noise and a wrong pose put that point. All other measures use what the frames
    /// claim. Frames that the session set aside do not count until they are in the map.
    pub n_seen: usize,
    /// Share, 0..=1, of the true surface with a measured point of the object within 1, 2 and 5 mm.
    pub surface_coverage: [f64; 3],
    /// Displacement of the object's points by the pose error of the mapped frame: root mean square over
    /// measured points, metres; 0 if there are none. It excludes the depth error. `None` if the true poses
    /// are not known.
    pub misplacement: Option<f64>,
}

/// The truth about a frame.
#[derive(Clone, Debug)]
pub struct FrameTruth {
    /// The frame without noise, from the true camera pose.
    exact: Frame,
    /// The object pixels that remain after noise.
    of_object: Frame,
}

/// Evaluates a scan frame by frame.
pub struct Evaluator<'a> {
    object: &'a ObjectVoxels,
    reachable: Option<&'a FixedBitSet>,
    surface: SurfaceCoverage,
    seen: FixedBitSet,
    /// The points of the object that each observed frame shows, in its camera frame.
    shown: Vec<Vec<DVec3>>,
    /// Numbers and poses of the mapped frames whose points `surface` has.
    counted: Vec<(usize, Pose)>,
    /// Exact frames that have not been in the map, by number.
    waiting: BTreeMap<usize, Frame>,
}

/// Captures a frame from a true pose. `is_first` marks the first frame of a scan, whose pose may be right
/// where all others are wrong.
pub fn capture(
    scene: &Scene,
    world_from_camera: &Pose,
    is_first: bool,
) -> Result<(Frame, FrameTruth), SimError> {
    let camera = scene.camera();
    let capture = camera.capture_with_truth(world_from_camera)?;
    let claims_right_pose = is_first && camera.noise().first_pose_is_right;
    let frame = if claims_right_pose { capture.frame.with_pose(*world_from_camera) } else { capture.frame };
    Ok((frame, FrameTruth { exact: capture.truth, of_object: capture.of_object }))
}

impl<'a> Evaluator<'a> {
    /// Creates an evaluator before the first frame.
    pub fn new(scene: &Scene, object: &'a ObjectVoxels) -> Self {
        let surface = SurfaceCoverage::new(scene.camera().mesh());
        Self {
            object,
            reachable: None,
            surface,
            seen: FixedBitSet::with_capacity(object.len()),
            shown: Vec::new(),
            counted: Vec::new(),
            waiting: BTreeMap::new(),
        }
    }

    /// Sets the reachable object voxels, with which the map is compared, too.
    pub fn with_reachable(self, reachable: &'a FixedBitSet) -> Self {
        Self { reachable: Some(reachable), ..self }
    }

    /// Evaluates the session after this frame. The frame has its mapped pose, or the given one if it was set
    /// aside.
    pub fn measure(&mut self, session: &Session, frame: &Frame, truth: FrameTruth) -> Measures {
        let misplacement = misplacement(&truth.exact, &frame.world_from_camera());
        self.waiting.insert(self.shown.len(), truth.exact);
        self.shown.push(truth.of_object.with_pose(Pose::IDENTITY).points().collect());
        let poses = session.frames().iter().map(Frame::world_from_camera);
        let mapped: Vec<_> = session.frame_numbers().iter().copied().zip(poses).collect();
        // Registration may have moved earlier frames, or taken them out of the map.
        if !mapped.starts_with(&self.counted) {
            self.surface.clear();
            self.counted.clear();
        }
        for (number, pose) in &mapped[self.counted.len()..] {
            if let Some(exact) = self.waiting.remove(number) {
                self.seen.union_with(&self.object.seen_in(&exact));
            }
            let shown = self.shown.get(*number).into_iter().flatten();
            self.surface.add_points(shown.map(|point| pose.transform_point(*point)));
        }
        self.counted = mapped;
        Measures {
            voxels: self.object.compare(&session.map().snapshot(self.object.block()), self.reachable),
            n_seen: self.seen.count_ones(..),
            surface_coverage: self.surface.shares(),
            misplacement: Some(misplacement),
        }
    }
}

/// Root mean square distance between the points of a frame in its own pose and in another, metres.
fn misplacement(exact: &Frame, mapped_from: &Pose) -> f64 {
    let motion = *mapped_from * exact.world_from_camera().inverse();
    let (mut n, mut sum) = (0, 0.0);
    for point in exact.points() {
        (n, sum) = (n + 1, sum + motion.transform_point(point).distance_squared(point));
    }
    if n > 0 { (sum / n as f64).sqrt() } else { 0.0 }
}
