//! One image that was asked for, until its pose is known.

use super::whereabouts::Whereabouts;
use crate::messages::Header;
use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Intrinsics};
use nextview_recording::ros::TransformError;
use std::time::{Duration, Instant};

/// An image with its pose.
pub struct Taken {
    pub header: Header,
    pub depth: DepthImage,
    pub intrinsics: Intrinsics,
    pub world_from_camera: Pose,
}

/// An image that waits for its pose.
pub struct Shot {
    pub header: Header,
    pub depth: DepthImage,
    pub intrinsics: Intrinsics,
    pub came: Instant,
}

/// How long an image waits for transforms of a time before its own, which hardly come after those of later
/// times.
const PATIENCE: Duration = Duration::from_millis(500);

/// An image that is wanted.
pub struct Capture {
    until: Instant,
    shot: Option<Shot>,
    /// The reason why there is none yet.
    why: String,
}

impl Capture {
    pub fn begin(timeout: f64) -> Self {
        // Longer than any program runs.
        let timeout = Duration::from_secs_f64(timeout.min(1e9));
        let why = "no image came on depth/image or depth/image/compressedDepth".to_owned();
        Self { until: Instant::now() + timeout, shot: None, why }
    }

    /// Whether an image would be of use.
    pub fn wants_image(&self) -> bool {
        self.shot.is_none()
    }

    /// An image came; or one that cannot be used, and why.
    pub fn saw(&mut self, shot: Result<Shot, String>) {
        match shot {
            Ok(shot) => self.shot = Some(shot),
            Err(why) => self.why = why,
        }
    }

    /// The image, once its pose is known; or, when time is up, the reason why there is none.
    pub fn done(&mut self, whereabouts: &Whereabouts) -> Option<Result<Taken, String>> {
        if let Some(Shot { header, depth, intrinsics, came }) = self.shot.take() {
            match whereabouts.at(&header.frame_id, header.stamp.seconds()) {
                Ok(world_from_camera) => {
                    return Some(Ok(Taken { header, depth, intrinsics, world_from_camera }));
                }
                Err(error) => {
                    self.why = format!("the pose of the image is not known: {error}");
                    // Then only the next image can help; else what lacks may come.
                    let is_past = matches!(error, TransformError::Before { .. } | TransformError::Gap { .. });
                    let is_lost = is_past && came.elapsed() > PATIENCE;
                    self.shot = (!is_lost).then_some(Shot { header, depth, intrinsics, came });
                }
            }
        }
        (Instant::now() >= self.until).then(|| Err(std::mem::take(&mut self.why)))
    }
}
