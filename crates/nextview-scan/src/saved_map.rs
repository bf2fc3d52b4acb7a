//! Planning from a saved map, without the frames behind it.

use crate::{Fault, Faults, PlannerConfigs, PlannerName, files};
use nextview::geometry::{Aabb, VoxelBlock};
use nextview::map::{Occupancy, OccupancyMap, Octree, SensorModel, Snapshot};
use nextview::planner::{Batch, BatchPlan, Choice, Situation};
use nextview::sensor::Intrinsics;
use nextview::session::{SessionConfig, planning_box};
use nextview::view::ViewSpace;
use nextview::{Cancel, Error};
use std::path::Path;

/// A map from a file, the box that the object lies in, and the views to choose from.
///
/// Planners that remember earlier decisions begin anew: a map does not hold them.
#[derive(Debug)]
pub struct SavedMap {
    snapshot: Snapshot,
    views: ViewSpace,
    intrinsics: Intrinsics,
    visited: Vec<usize>,
}

/// Maximum number of voxels of a map, about 4 GB.
const MAX_VOXELS: usize = 200_000_000;

impl SavedMap {
    /// Reads an OctoMap file.
    pub fn read_octree(path: &Path) -> Result<Octree, Fault> {
        Octree::read(files::open(path)?).map_err(|e| Fault::from(e).in_file(path))
    }

    /// Reads a map and view candidates for a camera with these optics, after these views were taken.
    ///
    /// Without bounds, the object lies in the planning box around the map's occupied voxels.
    pub fn open(
        map: &Path,
        views: &Path,
        bounds: Option<Aabb>,
        intrinsics: Intrinsics,
        visited: Vec<usize>,
    ) -> Result<Self, Faults> {
        let octree = Self::read_octree(map)?;
        let occupancy = OccupancyMap::from_octree(&octree, SensorModel::default(), MAX_VOXELS)
            .map_err(|e| Fault::from(e).in_file(map))?;
        let is_given = bounds.is_some();
        let bounds = match bounds {
            Some(bounds) => bounds,
            None => box_around(&occupancy).ok_or_else(|| no_object().in_file(map))?,
        };
        let views = ViewSpace::read_csv(files::open(views)?, bounds.center())
            .map_err(|e| Fault::from(e).in_file(views))?;
        let block = block(&occupancy, &bounds)?;
        if is_given {
            check_holds_map(&occupancy, &block)?;
        }
        if let Some(view) = visited.iter().find(|view| **view >= views.len()) {
            return Err(Fault::of_value("visited", view, format!("0 to {}", views.len() - 1)).into());
        }
        Ok(Self { snapshot: occupancy.snapshot(block), views, intrinsics, visited })
    }

    /// The view candidates.
    pub fn views(&self) -> &ViewSpace {
        &self.views
    }

    /// The next best view; none if no candidate gains anything.
    pub fn next_view(
        &self,
        planner: PlannerName,
        configs: PlannerConfigs,
        seed: u64,
    ) -> Result<Option<Choice>, Fault> {
        if planner.needs_frames() {
            let message = format!(
                "the planner {planner} needs the depth images behind the map, which a map does not hold"
            );
            return Err(Fault::request(message).with_remedy("use it in a scan"));
        }
        if planner == PlannerName::NbvNet {
            check_shows_object(&self.snapshot)?;
        }
        let mut planner = planner.build(configs, seed, None)?;
        let plan = planner.plan(&self.situation(&Cancel::default()))?;
        Ok(plan.choice)
    }

    /// Several views at once, the tour through them, and a bound on what as many could show.
    pub fn next_views(&self, configs: &PlannerConfigs) -> Result<BatchPlan, Fault> {
        let batch = Batch::new(configs.batch)?;
        Ok(batch.plan_batch(&self.situation(&Cancel::default()))?)
    }

    fn situation<'a>(&'a self, cancel: &'a Cancel) -> Situation<'a> {
        let situation = Situation::new(&self.snapshot, &self.views, &self.intrinsics, cancel);
        situation.with_visited(&self.visited).expect("the numbers were checked")
    }
}

fn block(map: &OccupancyMap, bounds: &Aabb) -> Result<VoxelBlock, Fault> {
    let config = SessionConfig::new(map.lattice().voxel_size(), *bounds);
    config.block(bounds).map_err(|error| match error {
        Error::TooLarge { needed_mb, limit_mb, .. } => {
            let share = (limit_mb as f64 / needed_mb as f64).cbrt();
            let half = 0.5 * bounds.longest_side() * share;
            let remedy =
                format!("state a smaller cube as `box`: with half its edge up to {half:.2} m, it fits");
            Fault::from(error).with_remedy(remedy)
        }
        error => Fault::from(error).with_remedy("state another cube as `box`"),
    })
}

/// Fails if the map measured something, but nothing in the box: all views would gain the same.
fn check_holds_map(map: &OccupancyMap, block: &VoxelBlock) -> Result<(), Fault> {
    let (voxels, lattice) = (map.voxels(), map.lattice());
    if voxels.is_empty() || voxels.iter().any(|(key, _)| block.index(*key).is_some()) {
        return Ok(());
    }
    let Some(Aabb { min, max }) = Aabb::around(voxels.iter().map(|(key, _)| lattice.center(*key))) else {
        return Ok(());
    };
    let message = format!("`box` holds none of the map's voxels, which lie from {min:.3} to {max:.3} m");
    Err(Fault::request(message).with_remedy("state the cube that the object lies in"))
}

/// The planning box around the occupied voxels; none if there are none.
fn box_around(map: &OccupancyMap) -> Option<Aabb> {
    let lattice = map.lattice();
    let occupied = map.voxels().into_iter().filter(|(_, value)| value.0 > 0.0);
    let bounds = Aabb::around(occupied.map(|(key, _)| lattice.center(key)))?;
    Some(planning_box(&bounds, lattice.voxel_size()))
}

fn no_object() -> Fault {
    let fault = Fault::data("no occupied voxel, so the object's place is unknown");
    fault.with_remedy("state the cube that it lies in as `box`")
}

/// Fails if the box, which is NBV-Net's grid, shows nothing of an object: the network would name a view all
/// the same.
fn check_shows_object(snapshot: &Snapshot) -> Result<(), Fault> {
    if snapshot.count(Occupancy::Occupied) > 0 {
        return Ok(());
    }
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    let place = format!("from {:.3} to {:.3} m", bounds.min, bounds.max);
    let message = format!("the object is outside NBV-Net's grid: no occupied voxel in the box {place}");
    Err(Fault::data(message).with_remedy("state the cube that it lies in as `box`"))
}
