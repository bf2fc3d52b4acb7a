//! A requested image, until its pose is known.

use super::pose_history::PoseHistory;
use crate::messages::Header;
use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Intrinsics};
use nextview_recording::ros::TransformError;
use std::time::{Duration, Instant};

/// An image with its pose.
pub struct PosedImage {
    pub header: Header,
    pub depth: DepthImage,
    pub intrinsics: Intrinsics,
    pub world_from_camera: Pose,
}

/// An image without a known pose yet.
pub struct Shot {
    pub header: Header,
    pub depth: DepthImage,
    pub intrinsics: Intrinsics,
    pub came: Instant,
}

/// Maximum wait for missing transforms when later ones are already known: they hardly ever arrive then.
const PATIENCE: Duration = Duration::from_millis(500);

/// A request for an image.
pub struct CaptureRequest {
    until: Instant,
    shot: Option<Shot>,
    /// The reason why there is no image yet.
    why: String,
}

impl CaptureRequest {
    pub fn begin(timeout: f64) -> Self {
        // Longer than any program runs.
        let timeout = Duration::from_secs_f64(timeout.min(1e9));
        let why = "no image arrived on depth/image or depth/image/compressedDepth".to_owned();
        Self { until: Instant::now() + timeout, shot: None, why }
    }

    /// Whether an image would be useful.
    pub fn wants_image(&self) -> bool {
        self.shot.is_none()
    }

    /// Records an image, or why one cannot be used.
    pub fn saw(&mut self, shot: Result<Shot, String>) {
        match shot {
            Ok(shot) => self.shot = Some(shot),
            Err(why) => self.why = why,
        }
    }

    /// The image, once its pose is known; after the timeout, the reason why there is none.
    pub fn done(&mut self, poses: &PoseHistory) -> Option<Result<PosedImage, String>> {
        if let Some(Shot { header, depth, intrinsics, came }) = self.shot.take() {
            match poses.at(&header.frame_id, header.stamp.seconds()) {
                Ok(world_from_camera) => {
                    return Some(Ok(PosedImage { header, depth, intrinsics, world_from_camera }));
                }
                Err(error) => {
                    self.why = format!("the pose of the image is not known: {error}");
                    // Only a later image can help then; otherwise the missing transform may still arrive.
                    let is_past = matches!(error, TransformError::Before { .. } | TransformError::Gap { .. });
                    let is_lost = is_past && came.elapsed() > PATIENCE;
                    self.shot = (!is_lost).then_some(Shot { header, depth, intrinsics, came });
                }
            }
        }
        (Instant::now() >= self.until).then(|| Err(std::mem::take(&mut self.why)))
    }
}
