use super::Reading;
use super::samples::{PixelSample, fit};
use crate::geometry::{Aabb, Pose};
use crate::sensor::{DepthRange, Frame};
use glam::DVec3;
use std::fmt;

/// Maximum number of frames that are compared, the oldest.
const FRAMES: usize = 8;

/// A reading is suspected if the frames fit at least this well under it, this many times better than as
/// given, and by this lead better than under any other. With one frame in a box, several often fit equally
/// well.
const LEAST_FIT: f64 = 0.08;
const TIMES_BETTER: f64 = 3.0;
const LEAST_LEAD: f64 = 0.005;

/// Minimum share of measured pixels; a frame with less measures nothing.
const LEAST_MEASURED: f64 = 0.01;

/// Minimum number of poses: with fewer, it is no surprise if few show the object. Wrong poses show it in at
/// most the first share, right ones in at least the second.
const LEAST_POSES: usize = 4;
const MOST_SHOWN_IF_WRONG: f64 = 0.5;
const LEAST_SHOWN_IF_RIGHT: f64 = 0.9;

/// Minimum distance between poses around an object, as a share of their distance from it.
const LEAST_MOVED: f64 = 0.5;

/// Why frames probably show nothing, or do not fit together.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Suspicion {
    /// The data fit if they are read in another way.
    Misread(Reading),
    /// All frames claim the same pose, although their images differ.
    SamePose,
    /// Hardly a pixel was measured: the camera is nearer to the object's box than its least depth.
    TooNear {
        /// Distance of the camera from the box, metres.
        distance: f64,
        /// The least depth that the camera measures, metres.
        least: f64,
    },
    /// Hardly a pixel was measured: the object's box is beyond the largest depth of the camera.
    TooFar {
        /// Distance of the camera from the box, metres.
        distance: f64,
        /// The largest depth that the camera measures, metres.
        largest: f64,
    },
    /// Hardly a pixel was measured, and the known range of the camera does not explain it.
    NothingMeasured {
        /// Share, 0..=1, of the last frame's pixels that were measured.
        measured: f64,
    },
    /// The frames fit together, but not in their given poses.
    Apart {
        /// Distance between the surfaces of different frames, metres.
        distance: f64,
    },
    /// The surface connected to the object exceeds the allowed memory: a table, floor or wall is part of it.
    Boundless,
    /// The camera looks past the object's box: no frame shows a point inside.
    Elsewhere {
        /// The box around the last frame's points, metres.
        points: Aabb,
        /// The object's box, metres.
        bounds: Aabb,
    },
}

/// Returns the likely reason why frames, oldest first, show nothing in the object's box or do not fit
/// together; `None` if they do fit, or without a likely reason. `bounds` is the known box of the object,
/// metres.
///
/// The frames' points are recomputed for other axes, inverted poses, other units and so on. A reading is
/// named if only under it the points of different frames meet, or lie in the box, and as given they do not.
pub fn suspect(frames: &[Frame], bounds: Option<Aabb>, range: DepthRange) -> Option<Suspicion> {
    let last = frames.last()?;
    if has_same_pose(frames) {
        return Some(Suspicion::SamePose);
    }
    let samples: Vec<PixelSample> = frames.iter().take(FRAMES).map(PixelSample::new).collect();
    match misread(&samples, bounds) {
        Some(reading) => Some(Suspicion::Misread(reading)),
        None => match bounds {
            Some(bounds) => nothing_shown(last, &bounds, range),
            None => samples.last().and_then(nothing_measured),
        },
    }
}

/// Returns the likely reason why few of the possible poses of frames, such as those of a recording, show the
/// middle of a frame; `None` if most of them do, or without a likely reason. It suits objects that are in
/// view from most poses.
///
/// The reason is that all poses are equal, or that exactly one convention (other axes, inverted poses, or the
/// quaternion's w first) makes almost all of them show that place, from different positions.
pub fn suspect_poses(frame: &Frame, poses: &[Pose]) -> Option<Suspicion> {
    if poses.len() < LEAST_POSES {
        return None;
    }
    if poses.iter().all(|pose| is_near(pose, &poses[0])) {
        return Some(Suspicion::SamePose);
    }
    let from_axis = |point: &DVec3| point.truncate().length_squared() / (point.z * point.z);
    let points = PixelSample::new(frame).points;
    let in_camera = points.into_iter().min_by(|a, b| from_axis(a).total_cmp(&from_axis(b)))?;
    let share = |reading: Option<Reading>| {
        let read = |pose: &Pose| reading.map_or(*pose, |reading| reading.pose(pose));
        let frame_pose = read(&frame.world_from_camera());
        let place = frame_pose.transform_point(in_camera);
        let shows = |pose: &Pose| {
            let pixel = frame.intrinsics().project(read(pose).inverse().transform_point(place));
            pixel.is_some_and(|pixel| frame.intrinsics().contains(pixel))
        };
        let moved = |pose: &Pose| read(pose).translation().distance(frame_pose.translation());
        // For cameras at one position, inverted poses are as likely.
        let farthest = poses.iter().map(moved).fold(0.0, f64::max);
        let is_still = reading.is_some() && farthest < LEAST_MOVED * in_camera.length();
        if is_still {
            0.0
        } else {
            poses.iter().filter(|pose| shows(pose)).count() as f64 / poses.len() as f64
        }
    };
    if share(None) > MOST_SHOWN_IF_WRONG {
        return None;
    }
    let is_likely =
        |reading: &&Reading| reading.is_convention() && share(Some(**reading)) >= LEAST_SHOWN_IF_RIGHT;
    let mut likely = Reading::ALL.iter().filter(is_likely);
    let reading = likely.next()?;
    likely.next().is_none().then_some(Suspicion::Misread(*reading))
}

/// The one reading under which the frames fit, if they do not fit as given.
fn misread(frames: &[PixelSample], bounds: Option<Aabb>) -> Option<Reading> {
    let best_possible = if bounds.is_some() { 2.0 } else { 1.0 };
    let least = LEAST_FIT.max(TIMES_BETTER * fit(frames, None, bounds));
    if least > best_possible {
        return None;
    }
    let of = |reading: &Reading| (fit(frames, Some(*reading), bounds), *reading);
    let mut fits: Vec<(f64, Reading)> = Reading::ALL.iter().map(of).collect();
    fits.sort_by(|a, b| b.0.total_cmp(&a.0));
    let ((best, reading), next) = (fits[0], fits[1].0);
    (best >= least && best >= next + LEAST_LEAD).then_some(reading)
}

fn nothing_measured(samples: &PixelSample) -> Option<Suspicion> {
    let PixelSample { measured, .. } = *samples;
    (measured < LEAST_MEASURED).then_some(Suspicion::NothingMeasured { measured })
}

/// Why the frame shows nothing in the box; `None` if it does.
fn nothing_shown(frame: &Frame, bounds: &Aabb, range: DepthRange) -> Option<Suspicion> {
    if frame.points_in(*bounds).next().is_some() {
        return None;
    }
    let camera = frame.world_from_camera().translation();
    let distance = camera.distance(camera.clamp(bounds.min, bounds.max));
    let farthest = bounds.corners().map(|corner| corner.distance(camera)).into_iter().fold(0.0, f64::max);
    let samples = PixelSample::new(frame);
    let points = Aabb::around(samples.in_world(None)).filter(|_| samples.measured >= LEAST_MEASURED);
    Some(match points {
        _ if farthest < range.min => Suspicion::TooNear { distance, least: range.min },
        _ if distance > range.max => Suspicion::TooFar { distance, largest: range.max },
        Some(points) => Suspicion::Elsewhere { points, bounds: *bounds },
        None if distance < range.min => Suspicion::TooNear { distance, least: range.min },
        None => Suspicion::NothingMeasured { measured: samples.measured },
    })
}

/// Whether three or more frames claim one pose, and at least two of them show different things.
fn has_same_pose(frames: &[Frame]) -> bool {
    let [first, rest @ ..] = frames else { return false };
    rest.len() >= 2
        && rest.iter().all(|frame| is_near(&frame.world_from_camera(), &first.world_from_camera()))
        && rest.iter().any(|frame| !shows_the_same(first, frame))
}

fn is_near(a: &Pose, b: &Pose) -> bool {
    a.translation().distance(b.translation()) < 1e-6 && a.rotation().dot(b.rotation()).abs() > 1.0 - 1e-9
}

/// Whether most pixels of two frames have about the same depth: noise differs, but another view differs more.
fn shows_the_same(a: &Frame, b: &Frame) -> bool {
    let (a, b) = (PixelSample::new(a), PixelSample::new(b));
    fit(&[a, b], None, None) > 0.9
}

impl fmt::Display for Suspicion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let corners = |Aabb { min, max }: &Aabb| {
            let corner = |at: &DVec3| format!("({:.3}, {:.3}, {:.3})", at.x, at.y, at.z);
            format!("{} to {} m", corner(min), corner(max))
        };
        match self {
            Self::Misread(reading) => write!(f, "{reading}: with that corrected, the frames would fit"),
            Self::SamePose => {
                f.write_str("all frames claim the same pose, although they show different things")
            }
            Self::TooNear { distance, least } => write!(
                f,
                "the camera is too near: {distance:.3} m from the object's box, but it measures only from {least} m"
            ),
            Self::TooFar { distance, largest } => write!(
                f,
                "the camera is too far away: {distance:.3} m from the object's box, but it measures only up \
                 to {largest} m"
            ),
            Self::Apart { distance } => write!(
                f,
                "the poses do not agree with the frames: they show the same surface about {:.1} mm apart",
                distance * 1e3
            ),
            Self::Boundless => f.write_str(
                "the surface connected to the object needs more memory than allowed: it includes a table, \
                 floor or wall",
            ),
            Self::NothingMeasured { measured } => write!(
                f,
                "only {:.1} % of the pixels have a depth: the camera may be too near or too far away, or the surface may be \
                 black, shiny or transparent",
                1e2 * measured
            ),
            Self::Elsewhere { points, bounds } => write!(
                f,
                "the frame shows nothing in the object's box: its points lie within {}, the box is {}",
                corners(points),
                corners(bounds)
            ),
        }
    }
}
