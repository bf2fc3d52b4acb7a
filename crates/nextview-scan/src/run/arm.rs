use crate::{Fault, RobotConfig};
use glam::{DQuat, DVec3, IVec3, UVec3};
use nextview::geometry::{Aabb, Plane, Pose};
use nextview::map::{LogOdds, Occupancy};
use nextview::motion::{Trajectory, Waypoint};
use nextview::session::{NextView, Session};
use nextview_robot::collision::{Attachment, BlockedVoxels, Checker, Obstacle, ObstacleKind};
use nextview_robot::path::{JointTrajectory, NoPath, motion_time, plan_path_to_any};
use nextview_robot::{Mount, RobotCell, Shape, ShapeKind};

/// Maximum number of samples in a path search.
const EFFORT: usize = 2000;

/// Maximum number of sets of joint values per pose that serve as goals of a path search.
const MOST_GOALS: usize = 16;

/// Maximum error of a robot's stated pose, in metres, to count as the pose it was sent to.
const SAME_PLACE: f64 = 0.05;

/// Minimum size, in metres, of the cells for surface outside the planning box: a robot needs no finer ones,
/// and they keep a room small.
const COARSE: f64 = 0.02;

/// The arm during a scan: its position and its possible moves.
pub(super) struct ScanArm {
    cell: RobotCell,
    /// The current joint values; `None` if unknown.
    values: Option<Vec<f64>>,
    /// For each candidate, whether the arm can reach it in the map after the last frame.
    survey: Option<ArmSurvey>,
}

struct ArmSurvey {
    checker: Checker,
    solutions: Vec<Vec<Vec<f64>>>,
    times: Vec<Option<f64>>,
}

/// The motion to a view.
pub(super) struct ArmMove {
    pub trajectory: Trajectory,
    /// Motion of a robot.
    pub joints: Option<JointTrajectory>,
}

impl ScanArm {
    /// The arm before the first view.
    pub fn of_config(config: &RobotConfig) -> Result<Self, Fault> {
        let values = (!config.home.is_empty()).then(|| config.home.clone());
        Ok(Self { cell: config.cell()?, values, survey: None })
    }

    /// The current joint values; `None` if unknown.
    pub fn values(&self) -> Option<&[f64]> {
        self.values.as_deref()
    }

    /// The arm's travel time to each candidate in seconds; `None` if it cannot be reached.
    pub fn times(&mut self, session: &Session) -> Result<Vec<Option<f64>>, Fault> {
        let survey = match self.survey.take() {
            Some(survey) => survey,
            None => self.look_around(session)?,
        };
        Ok(self.survey.insert(survey).times.clone())
    }

    fn look_around(&self, session: &Session) -> Result<ArmSurvey, Fault> {
        let checker = checker(&self.cell, session)?;
        let views = session.views();
        let free = |view: usize| match views.is_within_reach(view) && !session.visited().contains(&view) {
            true => self.cell.free_solutions(&views.pose(view), &checker),
            false => Vec::new(),
        };
        let solutions: Vec<_> = (0..views.len()).map(free).collect();
        let times = solutions.iter().map(|values| self.time_to(values)).collect();
        Ok(ArmSurvey { checker, solutions, times })
    }

    /// Time in seconds to move to the nearest of these sets of joint values; 0 if the current ones are
    /// unknown, `None` if there is no set.
    fn time_to(&self, solutions: &[Vec<f64>]) -> Option<f64> {
        let time = |values: &Vec<f64>| {
            self.values.as_ref().map_or(0.0, |from| motion_time(self.cell.arm(), from, values))
        };
        solutions.iter().map(time).min_by(f64::total_cmp)
    }

    /// Plans the motion to a view. `None` if there is none to a candidate, which is then given up until the
    /// next frame.
    ///
    /// Fails if the arm is in collision now, if it cannot reach a first view that is no candidate, or if
    /// cancelled.
    pub fn way_to(&mut self, next: &NextView, session: &Session) -> Result<Option<ArmMove>, Fault> {
        self.times(session)?;
        let survey = self.survey.as_ref().expect("times makes a survey");
        let pose = &next.world_from_camera;
        let solutions = match next.view {
            Some(view) => survey.solutions[view].clone(),
            None => self.cell.free_solutions(pose, &survey.checker),
        };
        let start = self.values.clone().or_else(|| most_central(&self.cell, &solutions));
        let found = match start.filter(|_| !solutions.is_empty()) {
            None => Err(why_not(&self.cell, &survey.checker, pose)),
            Some(from) => {
                let goals = self.nearest(&from, solutions);
                match plan_path_to_any(&survey.checker, &from, &goals, 0, EFFORT, session.cancel()) {
                    Ok((_, path)) => Ok(path),
                    Err(NoPath::Cancelled(cancelled)) => return Err(cancelled.into()),
                    Err(NoPath::StartTouches(contact)) => {
                        let fault = Fault::data(format!("at the arm's current position, {contact}"));
                        return Err(
                            fault.with_remedy("move it away, and set `robot.home` to its new position")
                        );
                    }
                    Err(no_path) => Err(no_path.to_string()),
                }
            }
        };
        match (found, next.view) {
            (Ok(path), _) => Ok(Some(self.way(JointTrajectory::along(&path, self.cell.arm()))?)),
            (Err(_), Some(view)) => {
                self.survey.iter_mut().for_each(|survey| survey.times[view] = None);
                Ok(None)
            }
            (Err(why), None) => {
                let fault = Fault::request(format!("the robot cannot go to the first view: {why}"));
                Err(Fault { key: Some("live.first_pose".to_owned()), ..fault })
            }
        }
    }

    /// The solutions that take the least time to reach; more than a few do not help a search.
    fn nearest(&self, from: &[f64], solutions: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let time = |values: Vec<f64>| (motion_time(self.cell.arm(), from, &values), values);
        let mut timed: Vec<_> = solutions.into_iter().map(time).collect();
        timed.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        timed.into_iter().map(|(_, values)| values).take(MOST_GOALS).collect()
    }

    fn way(&self, joints: JointTrajectory) -> Result<ArmMove, Fault> {
        let waypoint = |(time, values): &(f64, Vec<f64>)| Waypoint {
            time: *time,
            world_from_camera: self.cell.world_from_camera(values),
        };
        let trajectory = Trajectory::through(joints.points.iter().map(waypoint).collect())?;
        Ok(ArmMove { trajectory, joints: Some(joints) })
    }

    /// Records that a frame was taken at this stated pose. The arm is at the end of this motion or, if the
    /// pose is elsewhere, at the nearest joint values that hold the camera there. If there are none, its
    /// position is unknown.
    pub fn arrive(&mut self, joints: Option<&JointTrajectory>, world_from_camera: &Pose) {
        let is_there = |values: &Vec<f64>| {
            let place = self.cell.world_from_camera(values).translation();
            place.distance(world_from_camera.translation()) <= SAME_PLACE
        };
        let end = joints.and_then(|joints| joints.points.last()).map(|(_, values)| values);
        self.values = end.filter(|values| is_there(values)).cloned().or_else(|| {
            let solutions = self.cell.solutions(world_from_camera);
            match &self.values {
                Some(from) => self.nearest(from, solutions).into_iter().next(),
                None => most_central(&self.cell, &solutions),
            }
        });
        self.survey = None;
    }
}

/// The solution whose joint values are farthest from their limits; `None` if there are no solutions.
fn most_central(cell: &RobotCell, solutions: &[Vec<f64>]) -> Option<Vec<f64>> {
    let off = |values: &Vec<f64>| {
        let joints = cell.arm().joints.iter().zip(values);
        let share = joints.map(|(joint, value)| {
            let (lower, upper) = (joint.limits.lower, joint.limits.upper);
            ((value - 0.5 * (lower + upper)) / (0.5 * (upper - lower)).max(f64::MIN_POSITIVE)).abs()
        });
        share.fold(0.0, f64::max)
    };
    solutions.iter().min_by(|a, b| off(a).total_cmp(&off(b))).cloned()
}

fn why_not(cell: &RobotCell, checker: &Checker, pose: &Pose) -> String {
    let solutions = cell.arm().inverse(&cell.mount().base_from_flange(pose));
    match solutions.iter().find_map(|values| checker.contact(values)) {
        Some(contact) => contact.to_string(),
        None => "the pose is out of its reach".to_owned(),
    }
}

/// The checker of the cell, including all obstacles that the scan has measured.
fn checker(cell: &RobotCell, session: &Session) -> Result<Checker, Fault> {
    let (mut attached, mut obstacles) = (Vec::new(), Vec::new());
    match cell.mount() {
        Mount::Camera { world_from_base, .. } => {
            let base_from_world = world_from_base.inverse();
            obstacles.extend(unseen_or_occupied(session, &base_from_world)?);
            obstacles.extend(surface_beside(session, &base_from_world)?);
            if let Some(table) = session.table() {
                let point = base_from_world.transform_point(table.normal() * table.offset());
                let plane = Plane::new(base_from_world.rotation() * table.normal(), point)?;
                obstacles.push(Obstacle {
                    name: "the table of the object".to_owned(),
                    kind: ObstacleKind::Below(plane),
                });
            }
        }
        // The voxels of a carried object would move with the flange.
        Mount::Object { flange_from_world, .. } => attached.extend(session.bounds().map(|bounds| {
            let middle = Pose::new(DQuat::IDENTITY, bounds.center()).expect("a box is within reach");
            let kind = ShapeKind::Box(0.5 * bounds.size());
            let shape = Shape { link_from_shape: *flange_from_world * middle, kind };
            Attachment { name: "the object".to_owned(), shapes: vec![shape] }
        })),
    }
    cell.checker_with(attached, obstacles).map_err(Fault::request)
}

/// The voxels in the object's box that are not known to be free.
fn unseen_or_occupied(session: &Session, base_from_world: &Pose) -> Result<Option<Obstacle>, Fault> {
    let Some(snapshot) = session.snapshot() else { return Ok(None) };
    let blocked: Vec<bool> = snapshot.occupancy().iter().map(|state| *state != Occupancy::Free).collect();
    let (lattice, block) = (snapshot.lattice(), snapshot.block());
    let corner = lattice.bounds(&block).min;
    voxels(
        "the object, or unseen space next to it",
        base_from_world,
        corner,
        lattice.voxel_size(),
        block.dims(),
        &blocked,
    )
    .map(Some)
}

/// The occupied voxels outside the box, in coarser cells.
fn surface_beside(session: &Session, base_from_world: &Pose) -> Result<Option<Obstacle>, Fault> {
    let (map, bounds) = (session.map(), session.bounds());
    let lattice = map.lattice();
    let is_beside = |center: &DVec3| bounds.is_none_or(|bounds| !bounds.contains(*center));
    let centers = map.voxels().into_iter().filter(|(_, log_odds)| *log_odds > LogOdds(0.0));
    let centers: Vec<DVec3> = centers.map(|(key, _)| lattice.center(key)).filter(is_beside).collect();
    let Some(Aabb { min, max }) = Aabb::around(centers.iter().copied()) else { return Ok(None) };
    let most = f64::from(BlockedVoxels::MOST_ALONG - 1);
    let size = COARSE.max(lattice.voxel_size()).max((max - min).max_element() / most);
    let corner = min - DVec3::splat(0.5 * lattice.voxel_size());
    let dims = ((max - corner + 0.5 * lattice.voxel_size()) / size).ceil().as_uvec3().max(UVec3::ONE);
    let mut blocked = vec![false; dims.element_product() as usize];
    for center in centers {
        let cell =
            ((center - corner) / size).floor().as_ivec3().clamp(IVec3::ZERO, dims.as_ivec3() - 1).as_uvec3();
        blocked[(cell.x + dims.x * (cell.y + dims.y * cell.z)) as usize] = true;
    }
    voxels("a surface next to the object", base_from_world, corner, size, dims, &blocked).map(Some)
}

fn voxels(
    name: &str,
    base_from_world: &Pose,
    corner: DVec3,
    size: f64,
    dims: UVec3,
    blocked: &[bool],
) -> Result<Obstacle, Fault> {
    let base_from_grid = *base_from_world * Pose::new(DQuat::IDENTITY, corner)?;
    let voxels = BlockedVoxels::new(base_from_grid, size, dims, blocked).map_err(Fault::request)?;
    Ok(Obstacle { name: name.to_owned(), kind: ObstacleKind::Voxels(voxels) })
}
