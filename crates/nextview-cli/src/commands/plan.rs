use super::batch;
use super::values::{self, some_named};
use crate::{Failure, stdout};
use clap::Args;
use nextview::geometry::Aabb;
use nextview::sensor::Intrinsics;
use nextview_scan::{BatchRecord, PlannerName, SavedMap, ScanConfig};
use serde::Serialize;
use std::path::PathBuf;

/// Print the next best view for a saved map, or several with --batch.
///
/// The camera is the D435i of the paper. Planners that remember earlier decisions start without them: a map
/// does not store them.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct PlanArgs {
    /// The map, .ot or .bt
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    /// The view candidates, CSV with x_m,y_m,z_m or x_m,y_m,z_m,qx,qy,qz,qw; positions alone look at the
    /// box's centre
    #[arg(long, value_name = "FILE")]
    views: PathBuf,
    /// Views already taken, by number from 0
    #[arg(long, value_name = "I,J,...", value_delimiter = ',', value_parser = values::count, allow_negative_numbers = true)]
    visited: Vec<usize>,
    /// The cube around the object [default: around the map's occupied voxels, a tenth and two voxels wider]
    #[arg(long = "box", value_name = "CX,CY,CZ,HALF", value_parser = values::cube, allow_hyphen_values = true)]
    cube: Option<Aabb>,
    /// Planner that chooses the view
    #[arg(long, value_parser = some_named(|planner: PlannerName| planner.properties().plans_from_map()), default_value = "most-surface")]
    planner: PlannerName,
    /// Print up to N views that together show the most, the shortest tour through them around the object's
    /// sphere, and a guaranteed lower bound on their share of what the best N views would show
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with_all = ["planner", "seed"])]
    batch: Option<u32>,
    /// Penalty on long moves, 0 to 1: the weight of the movement cost, the paper's theta, or of the length of
    /// a batch's tour; moves begin at the last of --visited
    #[arg(long, value_name = "T", default_value = "0", value_parser = values::share, allow_negative_numbers = true)]
    theta: f64,
    /// Seed of the planners random and receding-horizon
    #[arg(long, value_name = "S", default_value = "0", value_parser = values::seed, allow_negative_numbers = true)]
    seed: u64,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  nextview plan --map map.ot --views views.csv --visited 0,17 --json
  nextview plan --map map.ot --views views.csv --visited 0,17 --batch 8
  nextview plan --map map.ot --views views.csv --visited 0,17 --batch 8 --theta 0.2";

/// The answer; `view` is `None` if no candidate gains anything.
#[derive(Debug, Serialize)]
struct Answer {
    planner: PlannerName,
    view: Option<usize>,
    position_m: Option<[f64; 3]>,
    quaternion_xyzw: Option<[f64; 4]>,
    score: Option<f64>,
    runner_up: Option<usize>,
}

impl PlanArgs {
    pub fn run(self) -> Result<(), Failure> {
        let visited = self.visited.clone();
        let map = SavedMap::open(&self.map, &self.views, self.cube, Intrinsics::d435i(), visited)?;
        stdout::print(if self.batch.is_some() { self.batch(&map)? } else { self.next(&map)? })
    }

    /// The planner and its parameters, as set by options.
    fn config(&self) -> ScanConfig {
        let (planner, seed) = (self.planner.into(), self.seed);
        let mut config = ScanConfig { planner, seed, ..ScanConfig::default() };
        config.set_theta(self.theta);
        config.batch.n_views = self.batch.map_or(config.batch.n_views, |n| n as usize);
        config
    }

    fn batch(&self, map: &SavedMap) -> Result<String, Failure> {
        let batch = BatchRecord::new(&map.next_views(self.config().batch)?, map.views());
        if !self.json {
            return Ok(batch::to_text(&batch));
        }
        Ok(serde_json::to_string(&batch).map_err(Failure::data)? + "\n")
    }

    fn next(&self, map: &SavedMap) -> Result<String, Failure> {
        let choice = map.next_view(&self.config())?;
        let pose = choice.as_ref().map(|choice| map.views().pose(choice.view));
        let answer = Answer {
            planner: self.planner,
            view: choice.as_ref().map(|choice| choice.view),
            position_m: pose.map(|pose| pose.translation().to_array()),
            quaternion_xyzw: pose.map(|pose| pose.rotation().to_array()),
            score: choice.as_ref().map(|choice| choice.score),
            runner_up: choice.as_ref().and_then(|choice| choice.runner_up),
        };
        if self.json { answer.to_json() } else { Ok(answer.to_text()) }
    }
}

impl Answer {
    fn to_json(&self) -> Result<String, Failure> {
        Ok(serde_json::to_string(self).map_err(Failure::data)? + "\n")
    }

    fn to_text(&self) -> String {
        match (self.view, self.position_m, self.quaternion_xyzw) {
            (Some(view), Some([x, y, z]), Some([qx, qy, qz, qw])) => format!(
                "next view   {view}\n\
                 position    {x:.4} {y:.4} {z:.4} m\n\
                 quaternion  {qx:.6} {qy:.6} {qz:.6} {qw:.6} (x y z w)\n"
            ),
            _ => "next view   none: no candidate gains anything\n".to_owned(),
        }
    }
}
