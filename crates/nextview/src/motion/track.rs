use super::path::MAX_TURN;
use super::route::Detour;
use super::waypoint::Waypoint;
use super::{MotionConfig, SpeedProfile};
use crate::geometry::Pose;
use glam::{DQuat, DVec3};
use std::iter::once;

/// Path length that takes as long as turning by a radian, metres: at this distance around the object, moving
/// and turning take equally long. At the default speed it is 57 degrees a second.
const LEVER: f64 = 0.25;

/// Maximum time between waypoints, seconds, unless a straight line has [`MOST_POINTS`] of them.
const INTERVAL: f64 = 0.1;
const MOST_POINTS: f64 = 100.0;

/// Distance below which corners are merged, metres: the direction between them would be rounding.
const SAME: f64 = 1e-9;

/// The course of a path and the rotation of the camera along it.
pub(super) struct Track {
    /// At least two.
    corners: Vec<TrackCorner>,
    /// Middle of the ball that the camera looks at.
    middle: Option<DVec3>,
    /// Radius of the arc, metres.
    radius: f64,
    /// The rotation that remains at the end, and its angle.
    rest: DQuat,
    rest_angle: f64,
}

struct TrackCorner {
    position: DVec3,
    /// Length of the path so far, metres.
    length: f64,
    /// The camera's rotation if it only followed the middle, and its turn so far, radians.
    rotation: DQuat,
    turn: f64,
}

impl Track {
    pub fn new(from: &Pose, to: &Pose, route: &Detour, middle: Option<DVec3>) -> Self {
        let (start, end) = (from.translation(), to.translation());
        let first = TrackCorner { position: start, length: 0.0, rotation: from.rotation(), turn: 0.0 };
        let mut track = Self {
            corners: vec![first],
            middle,
            radius: route.radius,
            rest: DQuat::IDENTITY,
            rest_angle: 0.0,
        };
        let between = route.corners.iter().copied().filter(|corner| corner.distance(end) > SAME);
        for position in between.chain(once(end)) {
            track.go_on(position, position == end);
        }
        track.rest = track.end().rotation.conjugate() * to.rotation();
        track.rest_angle = angle(track.rest);
        track
    }

    /// Length of the whole path, metres.
    pub fn length(&self) -> f64 {
        self.end().length
    }

    /// Adds timed poses to that of the start.
    pub fn add_waypoints(&self, config: &MotionConfig, waypoints: &mut Vec<Waypoint>) {
        let stops: Vec<usize> = (1..self.corners.len() - 1).filter(|&i| self.is_stop(i)).collect();
        let last = self.corners.len() - 1;
        let starts = once(0).chain(stops.iter().copied());
        for (start, end) in starts.zip(stops.iter().copied().chain(once(last))) {
            let time = waypoints.last().map_or(0.0, |last| last.time);
            self.add_piece(&self.corners[start..=end], time, config, waypoints);
        }
    }

    fn end(&self) -> &TrackCorner {
        self.corners.last().expect("a track has a first corner")
    }

    fn go_on(&mut self, position: DVec3, is_end: bool) {
        let last = self.end();
        let distance = last.position.distance(position);
        if distance <= SAME && !is_end {
            return;
        }
        let following = self.following(last.position, position);
        let rotation = (following * last.rotation).normalize();
        let (length, turn) = (last.length + distance, last.turn + angle(following));
        self.corners.push(TrackCorner { position, length, rotation, turn });
    }

    /// The smallest turn that takes the direction of the middle as seen from one position to that from
    /// another.
    fn following(&self, before: DVec3, now: DVec3) -> DQuat {
        let direction = |from: DVec3| self.middle.and_then(|middle| (middle - from).try_normalize());
        match (direction(before), direction(now)) {
            (Some(before), Some(now)) => DQuat::from_rotation_arc(before, now),
            _ => DQuat::IDENTITY,
        }
    }

    /// Whether the path bends so much at an inner corner that the camera must stop.
    fn is_stop(&self, corner: usize) -> bool {
        let [before, here, after] = [corner - 1, corner, corner + 1].map(|i| self.corners[i].position);
        (here - before).angle_between(after - here) > MAX_TURN + 1e-6
    }

    /// Adds the waypoints of a part of the path, from rest to rest, except its first.
    fn add_piece(&self, corners: &[TrackCorner], start: f64, config: &MotionConfig, to: &mut Vec<Waypoint>) {
        let (first, last) = (&corners[0], &corners[corners.len() - 1]);
        let length = last.length - first.length;
        let share = if self.length() > 0.0 { length / self.length() } else { 1.0 };
        // Longer than the path itself if turning takes longer.
        let effort = length.max(LEVER * (last.turn - first.turn + share * self.rest_angle));
        if effort == 0.0 {
            return;
        }
        let on_arc = (config.acceleration * self.radius).sqrt();
        let speed = if corners.len() > 2 { config.speed.min(on_arc) } else { config.speed };
        let profile = SpeedProfile::new(effort, speed, config.acceleration);
        let mut begin = 0.0;
        for leg in corners.windows(2) {
            let share = if length > 0.0 { (leg[1].length - first.length) / length } else { 1.0 };
            let end = profile.time_at(share * effort);
            let n = ((end - begin) / INTERVAL).ceil().clamp(1.0, MOST_POINTS);
            for i in 1..=n as usize {
                let time = begin + (end - begin) * i as f64 / n;
                let share = profile.distance_at(time) / effort;
                let of_all =
                    if self.length() > 0.0 { (first.length + share * length) / self.length() } else { share };
                to.push(self.waypoint(start + time, leg, of_all));
            }
            begin = end;
        }
    }

    /// The pose on a straight leg after this share of the whole path.
    fn waypoint(&self, time: f64, leg: &[TrackCorner], share: f64) -> Waypoint {
        let (from, to) = (&leg[0], &leg[1]);
        let distance = share * self.length() - from.length;
        let t = if to.length > from.length { distance / (to.length - from.length) } else { 1.0 };
        let position = from.position.lerp(to.position, t.clamp(0.0, 1.0));
        let rotation = self.following(from.position, position) * from.rotation;
        let turned = (rotation * DQuat::IDENTITY.slerp(self.rest, share)).normalize();
        let world_from_camera = Pose::from_unit(turned, position);
        Waypoint { time, world_from_camera }
    }
}

/// Angle of a rotation, radians, 0 to pi.
fn angle(rotation: DQuat) -> f64 {
    2.0 * rotation.xyz().length().atan2(rotation.w.abs())
}
