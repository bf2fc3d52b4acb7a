use super::capture::{CaptureRequest, PosedImage, Shot};
use super::pose_history::PoseHistory;
use super::rest::{RecentPoses, is_near};
use crate::connections::Message;
use crate::messages::{CompressedImage, Header, Image};
use crate::notes::Notes;
use crate::parameters::Parameters;
use nextview::geometry::Pose;
use nextview::sensor::{DepthImage, Intrinsics};
use nextview_recording::RecordingError;
use std::time::Instant;

/// The camera as described by its messages. At most one image is kept, and only while one is requested.
pub struct Camera {
    poses: PoseHistory,
    /// From the last camera_info.
    pub intrinsics: Option<Intrinsics>,
    /// Header of the last image: its frame and its time.
    last: Option<Header>,
    /// Number of images received.
    pub n_images: u64,
    rest: RecentPoses,
    capture: Option<CaptureRequest>,
}

impl Camera {
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            poses: PoseHistory::new(&parameters.global_frame, parameters.use_tf_transforms),
            intrinsics: None,
            last: None,
            n_images: 0,
            rest: RecentPoses::default(),
            capture: None,
        }
    }

    /// Processes a message.
    pub fn take(&mut self, message: Message, notes: &mut Notes) {
        match message {
            Message::Info(info) => match info.content().intrinsics() {
                Ok(intrinsics) => {
                    self.intrinsics = Some(intrinsics);
                    notes.clear("depth/camera_info");
                }
                Err(error) => notes.add("depth/camera_info", error.to_string()),
            },
            Message::Transforms { message, is_static } => {
                self.poses.transforms(&message, is_static, notes);
            }
            Message::Pose(pose) => self.poses.pose(&pose, notes),
            Message::Image(image) => self.image(&image, notes),
            Message::Compressed(image) => self.image(&image, notes),
            Message::Unreadable(topic, problem) => notes.add(topic, problem),
        }
    }

    fn image(&mut self, image: &impl IncomingImage, notes: &mut Notes) {
        self.n_images += 1;
        let header = image.header();
        let is_backwards =
            self.last.as_ref().is_some_and(|last| header.stamp.seconds() < last.stamp.seconds());
        self.last = Some(header.clone());
        let is_wanted = self.capture.as_ref().is_some_and(CaptureRequest::wants_image);
        let shot = match (is_backwards, self.intrinsics) {
            (true, _) => {
                Err("the stamp is earlier than that of the previous image, expected a later one".to_owned())
            }
            (_, None) => Err("there is no camera_info yet, expected it on depth/camera_info".to_owned()),
            // Not requested: report what is known without decoding it.
            _ if !is_wanted => image.check().map(|()| None),
            (_, Some(intrinsics)) => match image.depth(&intrinsics) {
                Ok(depth) => {
                    Ok(Some(Shot { header: header.clone(), depth, intrinsics, came: Instant::now() }))
                }
                Err(error) => Err(error.to_string()),
            },
        };
        match &shot {
            Ok(_) => notes.clear("depth/image"),
            Err(problem) => notes.add("depth/image", problem.clone()),
        }
        if let (Some(capture), true, Some(shot)) = (&mut self.capture, is_wanted, shot.transpose()) {
            capture.saw(shot);
        }
    }

    /// Requests the next image.
    pub fn capture(&mut self, timeout: f64) {
        self.capture = Some(CaptureRequest::begin(timeout));
    }

    pub fn is_capturing(&self) -> bool {
        self.capture.is_some()
    }

    /// Returns the requested image once, or the reason why there is none.
    pub fn taken(&mut self) -> Option<Result<PosedImage, String>> {
        let done = self.capture.as_mut()?.done(&self.poses)?;
        self.capture = None;
        Some(done)
    }

    /// Whether the camera rests near a pose, if its pose is known. Must be called regularly.
    pub fn rests_near(&mut self, wanted: &Pose, distance: f64, angle: f64) -> bool {
        let Some(Header { stamp, frame_id }) = &self.last else { return false };
        if let Ok(pose) = self.poses.at(frame_id, stamp.seconds()) {
            self.rest.saw(stamp.seconds(), pose);
        }
        self.rest.place().is_some_and(|place| is_near(&place, wanted, distance, angle))
    }
}

/// An image of either kind.
trait IncomingImage {
    fn header(&self) -> &Header;
    fn depth(&self, intrinsics: &Intrinsics) -> Result<DepthImage, RecordingError>;
    /// Fails if it is not a depth image.
    fn check(&self) -> Result<(), String>;
}

impl IncomingImage for Image {
    fn header(&self) -> &Header {
        &self.header
    }

    fn depth(&self, intrinsics: &Intrinsics) -> Result<DepthImage, RecordingError> {
        self.content().depth(intrinsics)
    }

    fn check(&self) -> Result<(), String> {
        let expected = "16UC1 (millimetres) or 32FC1 (metres)";
        let refused = || format!("the encoding is '{}', expected {expected}", self.encoding);
        self.content().is_depth().then_some(()).ok_or_else(refused)
    }
}

impl IncomingImage for CompressedImage {
    fn header(&self) -> &Header {
        &self.header
    }

    fn depth(&self, intrinsics: &Intrinsics) -> Result<DepthImage, RecordingError> {
        self.content().depth(intrinsics)
    }

    fn check(&self) -> Result<(), String> {
        let refused = || format!("the format is '{}', expected compressedDepth png", self.format);
        self.content().is_depth().then_some(()).ok_or_else(refused)
    }
}
