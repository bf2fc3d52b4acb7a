use super::ScanConfig;
use crate::Fault;
use nextview::geometry::Pose;
use nextview::view::{Reach, Reachability, ViewSpace};
use nextview_robot::RobotCell;

/// Possible camera positions: those of `reach`, limited by the robot if there is one.
#[derive(Debug)]
pub(crate) struct Held {
    reach: Reach,
    robot: Option<RobotCell>,
}

impl Reachability for Held {
    fn held(&self, world_from_camera: &Pose) -> Option<Pose> {
        let held = self.reach.held(world_from_camera)?;
        self.robot.as_ref().map_or(Some(held), |robot| robot.held(&held))
    }

    fn check(&self) -> Result<(), nextview::Error> {
        self.reach.check()
    }
}

impl ScanConfig {
    /// Where the camera can be.
    pub(crate) fn held(&self, change: impl FnOnce(Reach) -> Reach) -> Result<Held, Fault> {
        let robot = self.robot.as_ref().map(|robot| robot.cell()).transpose()?;
        Ok(Held { reach: change(self.reach.rule()), robot })
    }

    /// Keeps the candidates within reach, renumbered. Unless reach is unlimited, a note states how many are
    /// left. Fails if no candidate is left.
    pub(crate) fn within_reach(&self, views: ViewSpace) -> Result<(ViewSpace, Option<String>), Fault> {
        let (views, note) = self.reach.views(views)?;
        let Some(robot) = &self.robot else { return Ok((views, note)) };
        let n = views.len();
        let held = views.held(&robot.cell()?);
        let left: Vec<Pose> =
            (0..n).filter(|&view| held.is_within_reach(view)).map(|view| held.pose(view)).collect();
        if left.is_empty() {
            let name = &robot.arm;
            let fault =
                Fault::request(format!("{name} cannot hold the camera at any of the {n} view candidates"));
            return Err(fault.with_remedy(
                "`robot.world_from_base` states where its base stands, in metres in the coordinates of the object",
            ));
        }
        let note = format!("the robot can hold the camera at {} of {n} candidates", left.len());
        Ok((ViewSpace::new(left)?, Some(note)))
    }
}
