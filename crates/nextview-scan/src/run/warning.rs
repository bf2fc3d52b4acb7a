use nextview::diagnosis::{Reading, Suspicion};
use nextview::sensor::CameraAxes;

/// The suspicion and its remedy; where the frames are recorded, by keys of the configuration.
pub(super) fn warning(suspicion: &Suspicion, is_recorded: bool) -> String {
    let remedy = match suspicion {
        Suspicion::Misread(Reading::Axes(CameraAxes::OpenGl)) if is_recorded => {
            "try `recording.read.camera_axes` = opengl"
        }
        Suspicion::Misread(Reading::Axes(CameraAxes::Ros)) if is_recorded => {
            "try `recording.read.camera_axes` = ros"
        }
        Suspicion::Misread(Reading::Axes(_)) => "turn them to OpenCV axes: x right, y down, z forward",
        Suspicion::Misread(Reading::Inverted) if is_recorded => {
            "try `recording.read.poses` = camera-from-world"
        }
        Suspicion::Misread(Reading::Inverted) => "world_from_camera is expected",
        Suspicion::Misread(Reading::WFirst) => "x, y, z, w is expected",
        Suspicion::Misread(Reading::Positions(_)) => "metres are expected",
        Suspicion::Misread(Reading::Depths(_)) => "state the unit of the depth images",
        Suspicion::SamePose => "the poses must be those of the frames, in one world",
        Suspicion::TooNear { .. } | Suspicion::TooFar { .. } => "choose views within the camera's range",
        Suspicion::Apart { .. } => "`registration.enabled` = true aligns frames to each other",
        Suspicion::Boundless => {
            "with right poses, `object_box.table` = fit finds a table or floor; or state the object's box"
        }
        Suspicion::Elsewhere { .. } if is_recorded => {
            "`recording.box_m` is in the coordinates of the poses, in metres"
        }
        Suspicion::Elsewhere { .. } => "the box is in the coordinates of the poses, in metres",
        _ => return suspicion.to_string(),
    };
    format!("{suspicion}; {remedy}")
}
