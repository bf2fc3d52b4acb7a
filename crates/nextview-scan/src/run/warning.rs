use super::scan_facts::ScanFacts;
use nextview::diagnosis::{Reading, Suspicion};
use nextview::sensor::CameraAxes;
use nextview_recording::{PoseDirection, ReadOptions};

/// The suspicion and its remedy; for recorded frames, by configuration keys.
pub(super) fn warning(suspicion: &Suspicion, facts: &ScanFacts) -> String {
    let remedy = match suspicion {
        Suspicion::Misread(reading) => match facts.read.as_ref().and_then(|read| of_key(*reading, read)) {
            Some(Advice::Try(value)) => format!("try {value}"),
            Some(Advice::LeaveOut(what, key)) => {
                return format!("the poses look like {what}: leave out `{key}`");
            }
            None => right(*reading).to_owned(),
        },
        Suspicion::SamePose => {
            "each pose must belong to its frame, and all poses to one world frame".to_owned()
        }
        Suspicion::TooNear { .. } | Suspicion::TooFar { .. } => {
            "choose views within the camera's range".to_owned()
        }
        Suspicion::Apart { .. } => "`registration.enabled` = true aligns frames to each other".to_owned(),
        Suspicion::Boundless if facts.has_table => {
            "check the poses and the table that was found, or state the object's box".to_owned()
        }
        Suspicion::Boundless => {
            "with correct poses, `object_box.table` = fit finds a table or floor; or state the object's box"
                .to_owned()
        }
        Suspicion::Elsewhere { .. } if facts.read.is_some() => {
            "`recording.box_m` is in the coordinates of the poses, in metres".to_owned()
        }
        Suspicion::Elsewhere { .. } => "the box is in the coordinates of the poses, in metres".to_owned(),
        _ => return suspicion.to_string(),
    };
    format!("{suspicion}; {remedy}")
}

/// States that the poses are wrong, with the distance in metres between surfaces, and the consequences.
pub(super) fn poses_are_wrong(distance: f64) -> String {
    format!("{}; from now on, all frames are aligned to each other", Suspicion::Apart { distance })
}

/// States that alignment was given up.
pub(super) const POSES_AS_GIVEN: &str =
    "most frames cannot be aligned to each other: all poses are used as given";

/// A remedy for how recorded poses are read.
enum Advice {
    /// Set a key to a value.
    Try(&'static str),
    /// Leave out a key that converts the poses wrongly: what they look like in the files, and the key.
    LeaveOut(&'static str, &'static str),
}

/// The key that reads the poses correctly; `None` if no value does. `reading` was found for poses that had
/// already been read as `read` states.
fn of_key(reading: Reading, read: &ReadOptions) -> Option<Advice> {
    const AXES: &str = "recording.read.camera_axes";
    match (reading, read.camera_axes) {
        (Reading::Axes(CameraAxes::OpenGl), CameraAxes::OpenCv) => {
            Some(Advice::Try("`recording.read.camera_axes` = opengl"))
        }
        (Reading::Axes(CameraAxes::Ros), CameraAxes::OpenCv) => {
            Some(Advice::Try("`recording.read.camera_axes` = ros"))
        }
        // Two half turns cancel out.
        (Reading::Axes(CameraAxes::OpenGl), CameraAxes::OpenGl)
        | (Reading::TurnedFromRos, CameraAxes::Ros) => {
            Some(Advice::LeaveOut("those of cameras with OpenCV axes", AXES))
        }
        (Reading::Inverted, CameraAxes::OpenCv) => Some(match read.poses {
            PoseDirection::WorldFromCamera => Advice::Try("`recording.read.poses` = camera-from-world"),
            PoseDirection::CameraFromWorld => Advice::LeaveOut("world_from_camera", "recording.read.poses"),
        }),
        _ => None,
    }
}

/// The correct meaning.
fn right(reading: Reading) -> &'static str {
    match reading {
        Reading::Axes(_) | Reading::TurnedFromRos => "turn them to OpenCV axes: x right, y down, z forward",
        Reading::Inverted => "world_from_camera is expected",
        Reading::WFirst => "x, y, z, w is expected",
        Reading::Positions(_) => "metres are expected",
        Reading::Depths(_) => "state the unit of the depth images",
        _ => "metres, OpenCV axes and world_from_camera are expected",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(suspicion: Suspicion, read: Option<ReadOptions>, has_table: bool) -> String {
        warning(&suspicion, &ScanFacts { read, section: Some("recording"), has_table })
    }

    #[test]
    fn what_was_stated_wrongly_is_to_be_left_out() {
        let read = |camera_axes, poses| Some(ReadOptions { camera_axes, poses, ..ReadOptions::default() });
        let axes = |axes| Suspicion::Misread(Reading::Axes(axes));
        let (forward, back) = (PoseDirection::WorldFromCamera, PoseDirection::CameraFromWorld);
        for (suspicion, read, expected) in [
            (
                axes(CameraAxes::OpenGl),
                read(CameraAxes::OpenCv, back),
                "; try `recording.read.camera_axes` = opengl",
            ),
            (
                axes(CameraAxes::OpenGl),
                read(CameraAxes::OpenGl, forward),
                "the poses look like those of cameras with OpenCV axes: leave out `recording.read.camera_axes`",
            ),
            (
                Suspicion::Misread(Reading::TurnedFromRos),
                read(CameraAxes::Ros, forward),
                "the poses look like those of cameras with OpenCV axes: leave out `recording.read.camera_axes`",
            ),
            (
                axes(CameraAxes::Ros),
                read(CameraAxes::OpenGl, forward),
                "; turn them to OpenCV axes: x right, y down, z forward",
            ),
            (
                Suspicion::Misread(Reading::Inverted),
                read(CameraAxes::OpenCv, forward),
                "; try `recording.read.poses` = camera-from-world",
            ),
            (
                Suspicion::Misread(Reading::Inverted),
                read(CameraAxes::OpenCv, back),
                "the poses look like world_from_camera: leave out `recording.read.poses`",
            ),
            (Suspicion::Misread(Reading::Inverted), None, "; world_from_camera is expected"),
        ] {
            let warning = of(suspicion, read, false);
            assert!(warning.ends_with(expected), "{warning}, expected {expected}");
        }
    }

    #[test]
    fn a_table_that_is_looked_for_is_no_advice() {
        assert!(of(Suspicion::Boundless, None, false).contains("`object_box.table` = fit"));
        let warning = of(Suspicion::Boundless, None, true);
        assert!(
            !warning.contains("`object_box.table`") && warning.contains("state the object's box"),
            "{warning}"
        );
    }
}
