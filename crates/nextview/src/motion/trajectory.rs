use super::route::Detour;
use super::track::Track;
use super::waypoint::Waypoint;
use super::{KeepOut, MotionConfig};
use crate::Error;
use crate::geometry::{Aabb, Plane, Pose, check_position};

/// The surroundings of the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surroundings {
    /// The box around the object, metres. The camera goes around the ball through its corners, enlarged by
    /// the clearance.
    pub object: Option<Aabb>,
    /// The floor; the camera stays above it.
    pub floor: Option<Plane>,
}

/// A trajectory from one view to another: timed poses, from rest to rest.
///
/// It goes straight, or around the ball that encloses the object: tangent, arc, tangent. If that would dip
/// below the floor, it goes around level with its ends. Straight lines between waypoints also stay outside
/// the ball and above the floor. It leaves and reaches an end inside the ball straight outwards, or level
/// above a floor; an end below the floor is the lowest point.
///
/// The camera turns with the direction towards the middle of the object, by no more than necessary. The
/// remaining rotation to the final pose is spread evenly along the path. Between poses that look at the
/// middle, it looks there all the time.
///
/// Along the path, speed over time is a [`SpeedProfile`](super::SpeedProfile). Where the path bends by more
/// than 5 degrees at once (at the border of the ball, if an end is inside) the camera stops. On an arc,
/// speed^2 / radius is no more than the acceleration. Turning takes time, too: as long as a path of 0.25 m
/// for each radian, if that is longer than the path itself.
///
/// ```
/// use glam::DVec3;
/// use nextview::geometry::Aabb;
/// use nextview::motion::{MotionConfig, Surroundings, Trajectory};
/// use nextview::view::look_at;
///
/// let around = Surroundings { object: Some(Aabb::cube(DVec3::ZERO, 0.1)), floor: None };
/// let [from, to] = [DVec3::X * 0.4, -DVec3::X * 0.4].map(|position| look_at(position, DVec3::ZERO).unwrap());
/// let trajectory = Trajectory::new(&from, &to, &around, &MotionConfig::default()).unwrap();
/// assert!(trajectory.length() > 0.8 && trajectory.length() < 1.0 && trajectory.duration() > trajectory.length() / 0.25);
/// assert!(trajectory.waypoints().iter().all(|point| point.world_from_camera.translation().length() > 0.19));
/// assert_eq!(trajectory.waypoints().last().unwrap().world_from_camera, to);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    waypoints: Vec<Waypoint>,
    length: f64,
}

impl Trajectory {
    /// Plans the trajectory between two poses (`world_from_camera`). Fails on a configuration or a box out of
    /// range, or if it would leave [`Pose::REACH`].
    pub fn new(
        from: &Pose,
        to: &Pose,
        surroundings: &Surroundings,
        config: &MotionConfig,
    ) -> Result<Self, Error> {
        config.check()?;
        let Surroundings { object, floor } = surroundings;
        let ball = object.map(|bounds| KeepOut::around(&bounds, config.clearance)).transpose()?;
        let (start, end) = (from.translation(), to.translation());
        let straight = || Detour { corners: vec![start, end], radius: 0.0 };
        let route = ball.map_or_else(straight, |ball| ball.route(start, end, floor.as_ref()));
        route.corners.iter().try_for_each(|corner| check_position("trajectory", *corner))?;
        let track = Track::new(from, to, &route, ball.map(|ball| ball.center()));
        let mut waypoints = vec![Waypoint { time: 0.0, world_from_camera: *from }];
        track.add_waypoints(config, &mut waypoints);
        if let Some(last) = waypoints.last_mut() {
            last.world_from_camera = *to; // without the rounding on the way
        }
        Ok(Self { waypoints, length: track.length() })
    }

    /// Creates a trajectory from poses in the order of their times, such as those of a camera on an arm.
    ///
    /// Fails unless there is at least one, the first at 0 s, with times that increase.
    pub fn through(waypoints: Vec<Waypoint>) -> Result<Self, Error> {
        let starts = waypoints.first().map(|first| first.time);
        let increase = waypoints.windows(2).all(|pair| pair[0].time < pair[1].time);
        if starts != Some(0.0) || !increase || !waypoints.iter().all(|point| point.time.is_finite()) {
            let times: Vec<f64> = waypoints.iter().map(|point| point.time).collect();
            return Err(Error::invalid("times", format!("{times:?}"), "0 first, then increasing"));
        }
        let position = |point: &Waypoint| point.world_from_camera.translation();
        let length = waypoints.windows(2).map(|pair| position(&pair[0]).distance(position(&pair[1]))).sum();
        Ok(Self { waypoints, length })
    }

    /// Creates a trajectory that stays at this pose.
    pub fn at(world_from_camera: Pose) -> Self {
        Self { waypoints: vec![Waypoint { time: 0.0, world_from_camera }], length: 0.0 }
    }

    /// Waypoints in the order of their times, at most 0.1 s apart (or a hundredth of a straight line that
    /// takes more than 10 s). The first, at 0 s, is the start of the trajectory, the last its end.
    pub fn waypoints(&self) -> &[Waypoint] {
        &self.waypoints
    }

    /// Length of the path through all waypoints, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Time from rest to rest, seconds.
    pub fn duration(&self) -> f64 {
        self.waypoints.last().map_or(0.0, |last| last.time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;
    use crate::view::look_at;
    use glam::{DQuat, DVec3};

    const OBJECT: Aabb = Aabb { min: DVec3::new(-0.1, -0.08, 0.0), max: DVec3::new(0.1, 0.08, 0.15) };

    /// Ends outside the ball and above the floor; their cameras look at the middle, or any way.
    fn ends(random: &mut Random, ball: &KeepOut, is_looking: bool) -> [Pose; 2] {
        [(); 2].map(|()| {
            let position = loop {
                let position = ball.center() + 0.6 * random.in_cube();
                if position.distance(ball.center()) > ball.radius() && position.z > 0.02 {
                    break position;
                }
            };
            let pose = look_at(position, ball.center()).unwrap();
            let roll = DQuat::from_rotation_z(random.range(-3.0, 3.0));
            let tilt = DQuat::from_rotation_x(if is_looking { 0.0 } else { random.range(-1.0, 1.0) });
            Pose::new(pose.rotation() * roll * tilt, position).unwrap()
        })
    }

    fn turned(a: &Waypoint, b: &Waypoint) -> f64 {
        let [a, b] = [a, b].map(|point| point.world_from_camera.rotation());
        2.0 * (a.conjugate() * b).xyz().length().min(1.0).asin()
    }

    /// Finite differences of the waypoints that a robot receives.
    #[test]
    fn waypoints_keep_the_limits() {
        let mut random = Random::new(3, 0);
        let config = MotionConfig::default();
        let ball = KeepOut::around(&OBJECT, config.clearance).unwrap();
        let floor = Plane::horizontal(0.02).unwrap();
        let around = Surroundings { object: Some(OBJECT), floor: Some(floor) };
        for case in 0..3000 {
            let is_looking = case % 2 == 0;
            let [from, to] = ends(&mut random, &ball, is_looking);
            let trajectory = Trajectory::new(&from, &to, &around, &config).unwrap();
            let points = trajectory.waypoints();
            assert_eq!((points[0].time, points[0].world_from_camera), (0.0, from));
            assert_eq!(points.last().unwrap().world_from_camera, to);
            let position = |point: &Waypoint| point.world_from_camera.translation();
            let legs: Vec<(f64, f64)> = points
                .windows(2)
                .map(|pair| (pair[1].time - pair[0].time, position(&pair[0]).distance(position(&pair[1]))))
                .collect();
            let length: f64 = legs.iter().map(|(_, length)| length).sum();
            let shortest = ball.path_length(from.translation(), to.translation());
            assert!((length - trajectory.length()).abs() < 1e-9 && length >= shortest - 1e-9);
            let is_shortest = ball.route(from.translation(), to.translation(), Some(&floor)).corners
                == ball.path(from.translation(), to.translation());
            assert!(!is_shortest || length <= 1.0007 * shortest + 1e-9, "{length} for {shortest}");
            assert!(length <= 1.6 * from.translation().distance(to.translation()) + 1e-9);

            assert!(legs.iter().all(|&(time, _)| time > 0.0 && time <= 0.1 + 1e-12));
            let speeds: Vec<f64> = legs.iter().map(|(time, length)| length / time).collect();
            assert!(speeds.iter().all(|speed| *speed <= config.speed * (1.0 + 1e-6)), "{speeds:?}");
            for (pair, speeds) in legs.windows(2).zip(speeds.windows(2)) {
                let change = (speeds[1] - speeds[0]).abs() / (0.5 * (pair[0].0 + pair[1].0));
                assert!(change <= config.acceleration * (1.0 + 1e-6), "{change} in {legs:?}");
            }
            let ends = [(speeds[0], legs[0].0), (speeds[speeds.len() - 1], legs[legs.len() - 1].0)];
            for (speed, time) in ends {
                assert!(speed <= 0.5 * config.acceleration * time * (1.0 + 1e-6), "from rest, to rest");
            }
            for pair in points.windows(2) {
                let [a, b] = [&pair[0], &pair[1]].map(|point| position(point) - ball.center());
                let t = (-a.dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                assert!((a + t * (b - a)).length() >= ball.radius() - 1e-9);
                assert!(position(&pair[1]).z >= 0.02 - 1e-9);
                let time = pair[1].time - pair[0].time;
                // A radian for each quarter metre on average; twice that where the camera is nearest.
                assert!(
                    turned(&pair[0], &pair[1]) <= 3.0 * time,
                    "{} in {time} s",
                    turned(&pair[0], &pair[1])
                );
            }
            if is_looking {
                for point in points {
                    let axis = point.world_from_camera.rotation() * DVec3::Z;
                    let inward = (ball.center() - position(point)).normalize();
                    assert!(axis.distance(inward) < 1e-9, "looks at the middle all the time");
                }
            }
        }
    }

    #[test]
    fn known_durations() {
        let config = MotionConfig::default();
        let nothing = Surroundings::default();
        let trajectory = |from: Pose, to: Pose| Trajectory::new(&from, &to, &nothing, &config).unwrap();
        let at = |x: f64| Pose::new(DQuat::IDENTITY, DVec3::X * x).unwrap();
        assert!((trajectory(at(0.0), at(1.0)).duration() - 4.5).abs() < 1e-12);
        let turn = Pose::new(DQuat::from_rotation_z(2.0), DVec3::ZERO).unwrap();
        assert!((trajectory(at(0.0), turn).duration() - 2.5).abs() < 1e-9, "as 0.5 m");
        assert_eq!(trajectory(at(0.0), turn).length(), 0.0);
        assert!(trajectory(at(0.0), turn).waypoints().len() > 20, "a turn on the spot has waypoints");
        assert_eq!(trajectory(turn, turn), Trajectory { length: 0.0, ..Trajectory::at(turn) });
        let there = Surroundings { object: Some(OBJECT), floor: None };
        let same = Trajectory::new(&at(1.0), &at(1.0), &there, &config).unwrap();
        assert_eq!(same, Trajectory::at(at(1.0)));
    }

    #[test]
    fn stops_at_the_border_of_the_ball() {
        let config = MotionConfig { clearance: 0.0, ..MotionConfig::default() };
        let radius = 0.5 * OBJECT.size().length();
        let middle = OBJECT.center();
        let [from, to] =
            [DVec3::X, DVec3::Y].map(|up| look_at(middle + up * (radius - 0.01), middle).unwrap());
        let there = Surroundings { object: Some(OBJECT), floor: None };
        let trajectory = Trajectory::new(&from, &to, &there, &config).unwrap();
        let outward = 2.0 * (0.01_f64 / 0.5).sqrt();
        let stop =
            trajectory.waypoints().iter().find(|point| (point.time - outward).abs() < 1e-9).expect("a stop");
        assert!((stop.world_from_camera.translation().distance(middle) - radius).abs() < 1e-9);
    }

    #[test]
    fn leads_through_the_waypoints_of_others() {
        let at = |time: f64, x: f64| Waypoint {
            time,
            world_from_camera: Pose::new(DQuat::IDENTITY, DVec3::X * x).unwrap(),
        };
        let trajectory = Trajectory::through(vec![at(0.0, 1.0), at(0.5, 1.0), at(1.0, 0.0)]).unwrap();
        assert_eq!((trajectory.length(), trajectory.duration()), (1.0, 1.0));
        for wrong in [vec![], vec![at(0.1, 0.0)], vec![at(0.0, 0.0), at(0.0, 1.0)]] {
            assert!(Trajectory::through(wrong).is_err());
        }
    }

    #[test]
    fn refuses_what_is_out_of_range() {
        let pose = Pose::IDENTITY;
        let speed = MotionConfig { speed: f64::NAN, ..MotionConfig::default() };
        let error = Trajectory::new(&pose, &pose, &Surroundings::default(), &speed).unwrap_err().to_string();
        assert!(error.contains("speed_m_per_s is NaN"), "{error}");
        let endless = Surroundings { object: Some(Aabb::EVERYWHERE), floor: None };
        assert!(Trajectory::new(&pose, &pose, &endless, &MotionConfig::default()).is_err());
    }
}
