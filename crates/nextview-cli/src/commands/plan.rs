use super::batch::BatchAnswer;
use super::{map, values};
use crate::scan::{NbvNetConfig, PlannerConfigs, PlannerName};
use crate::{Failure, files, stdout};
use clap::Args;
use nextview::geometry::Aabb;
use nextview::map::{Occupancy, OccupancyMap, SensorModel, Snapshot};
use nextview::planner::{Batch, BatchConfig, GreedyConfig, MaxFlowConfig, MostSurfaceConfig, Situation};
use nextview::sensor::Intrinsics;
use nextview::session::SessionConfig;
use nextview::view::ViewSpace;
use serde::Serialize;
use std::path::PathBuf;

/// Give the next best view for a saved map, or with --batch several.
///
/// The camera is the D435i of the paper. The history of the flow is empty: a map does not tell how it came about.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct PlanArgs {
    /// The map, .ot or .bt
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    /// The view candidates, CSV with x_m,y_m,z_m or x_m,y_m,z_m,qx,qy,qz,qw; positions alone look at the box's centre
    #[arg(long, value_name = "FILE")]
    views: PathBuf,
    /// Views already taken, by number from 0
    #[arg(long, value_name = "I,J,...", value_delimiter = ',', value_parser = values::count, allow_negative_numbers = true)]
    visited: Vec<usize>,
    /// The cube the object lies in [default: around the map's occupied voxels, a tenth and two voxels wider]
    #[arg(long = "box", value_name = "CX,CY,CZ,HALF", value_parser = values::cube, allow_hyphen_values = true)]
    cube: Option<Aabb>,
    /// How to choose
    #[arg(long, value_enum, default_value = "most-surface")]
    planner: PlannerName,
    /// Give up to N views that together show as much as possible of what is worth seeing, the shortest tour through them around
    /// the object's sphere, and a bound: how much of what the best N views would show is sure
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with_all = ["planner", "seed"])]
    batch: Option<u32>,
    /// Weight of the movement cost against the gain, 0 to 1: the paper's theta, and of the length of the tour against what a batch
    /// shows; the way begins at the last of --visited
    #[arg(long, value_name = "T", default_value = "0", value_parser = values::share, allow_negative_numbers = true)]
    theta: f64,
    /// Seed of the random planner
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

/// Most voxels that a map may have, about 4 GB.
const MAX_VOXELS: usize = 200_000_000;

/// The answer; `view` is none if no candidate gains anything.
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
        let octree = map::read(&self.map)?;
        let map = OccupancyMap::from_octree(&octree, SensorModel::default(), MAX_VOXELS)
            .map_err(|e| Failure::from(e).in_file(&self.map))?;
        let bounds = self.cube.map_or_else(|| self.box_around(&map), Ok)?;
        let views = ViewSpace::read_csv(files::open(&self.views)?, bounds.center())
            .map_err(|e| Failure::from(e).in_file(&self.views))?;
        let voxel_size = map.lattice().voxel_size();
        let block = SessionConfig::new(voxel_size, bounds).block(&bounds);
        let block = block.map_err(|e| Failure::from(e).with_hint("pass another cube as --box"))?;
        if let Some(view) = self.visited.iter().find(|view| **view >= views.len()) {
            return Err(Failure::usage(format!(
                "--visited names view {view}, expected 0 to {}",
                views.len() - 1
            )));
        }
        let situation = Situation {
            snapshot: &map.snapshot(block),
            frames: &[],
            views: &views,
            intrinsics: &Intrinsics::d435i(),
            visited: &self.visited,
            history: &[],
            finest_voxel_size: voxel_size,
        };
        stdout::print(if self.batch.is_some() { self.batch(&situation)? } else { self.next(&situation)? })
    }

    /// The parameters of all planners, as far as they are told.
    fn configs(&self) -> PlannerConfigs {
        let (theta, default) = (self.theta, BatchConfig::default());
        PlannerConfigs {
            most_surface: MostSurfaceConfig { theta, ..MostSurfaceConfig::default() },
            max_flow: MaxFlowConfig { theta, ..MaxFlowConfig::default() },
            greedy: GreedyConfig { theta, ..GreedyConfig::default() },
            batch: BatchConfig {
                theta,
                n_views: self.batch.map_or(default.n_views, |n| n as usize),
                ..default
            },
            nbv_net: NbvNetConfig::default(),
        }
    }

    fn batch(&self, situation: &Situation<'_>) -> Result<String, Failure> {
        let plan = Batch::new(self.configs().batch)?.plan_batch(situation);
        let answer = BatchAnswer::new(&plan, situation.views);
        if self.json { answer.to_json() } else { Ok(answer.to_text()) }
    }

    fn next(&self, situation: &Situation<'_>) -> Result<String, Failure> {
        if self.planner == PlannerName::NbvNet {
            check_shows_object(situation.snapshot)?;
        }
        let plan = self.planner.without_truth(self.configs(), self.seed)?.plan(situation);
        let views = situation.views;
        let pose = plan.choice.map(|choice| views.pose(choice.view));
        let answer = Answer {
            planner: self.planner,
            view: plan.choice.map(|choice| choice.view),
            position_m: pose.map(|pose| pose.translation().to_array()),
            quaternion_xyzw: pose.map(|pose| pose.rotation().to_array()),
            score: plan.choice.map(|choice| choice.score),
            runner_up: plan.choice.and_then(|choice| choice.runner_up),
        };
        if self.json { answer.to_json() } else { Ok(answer.to_text()) }
    }

    fn box_around(&self, map: &OccupancyMap) -> Result<Aabb, Failure> {
        let lattice = map.lattice();
        let occupied = map.voxels().into_iter().filter(|(_, value)| value.0 > 0.0);
        let bounds = Aabb::around(occupied.map(|(key, _)| lattice.center(key))).ok_or_else(|| {
            Failure::data("no occupied voxel, so the object's place is unknown")
                .in_file(&self.map)
                .with_hint("pass the cube it lies in as --box cx,cy,cz,half")
        })?;
        Ok(Aabb::cube(bounds.center(), 0.55 * bounds.longest_side() + 2.0 * lattice.voxel_size()))
    }
}

/// Fails if the box, which is NBV-Net's grid, shows nothing of an object: the network would name a view all the same.
fn check_shows_object(snapshot: &Snapshot) -> Result<(), Failure> {
    if snapshot.count(Occupancy::Occupied) > 0 {
        return Ok(());
    }
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    let place = format!("from {:.3} to {:.3} m", bounds.min, bounds.max);
    let failure =
        Failure::data(format!("the object is outside NBV-Net's grid: no occupied voxel in the box {place}"));
    Err(failure.with_hint("pass the cube it lies in as --box cx,cy,cz,half"))
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
