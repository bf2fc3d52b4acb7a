//! Planning from a saved map, without the frames behind it.

use crate::{Fault, Faults, ScanConfig, files};
use glam::{DVec3, IVec3};
use nextview::geometry::{Aabb, Lattice, VoxelBlock};
use nextview::map::{LogOdds, Occupancy, Snapshot};
use nextview::object::planning_box;
use nextview::planner::{Batch, BatchConfig, BatchPlan, Choice, Situation};
use nextview::sensor::Intrinsics;
use nextview::session::SessionConfig;
use nextview::view::ViewSpace;
use nextview::{Cancel, Error};
use nextview_octomap::{Leaf, Octree};
use std::path::Path;

/// A map from a file, the object's box, and the view candidates.
///
/// Planners that remember earlier decisions start without them: a map does not contain them.
#[derive(Debug)]
pub struct SavedMap {
    snapshot: Snapshot,
    views: ViewSpace,
    intrinsics: Intrinsics,
    visited: Vec<usize>,
}

/// Range of the camera in metres: the specification of the D435i. Views farther from the box show nothing of
/// it.
const RANGE: f64 = 10.0;

/// Planning memory per voxel of the box in bytes: 35 with max-flow, 8 with the default planner.
const BYTES_PER_VOXEL: u64 = 40;

/// Memory allowed for a box around the occupied voxels, however small the file, in bytes.
const FREE_MEMORY: u64 = 180_000_000;

impl SavedMap {
    /// Reads an OctoMap file.
    pub fn read_octree(path: &Path) -> Result<Octree, Fault> {
        Octree::read(files::open(path)?).map_err(|e| Fault::from(e).in_file(path))
    }

    /// Reads a map and view candidates. The camera has these optics and has already taken the `visited`
    /// views.
    ///
    /// Without bounds, the planning box encloses the map's occupied voxels; its memory must be in proportion
    /// to the size of the file. Fails if all views are too far from the box to show any of it.
    pub fn open(
        map: &Path,
        views: &Path,
        bounds: Option<Aabb>,
        intrinsics: Intrinsics,
        visited: Vec<usize>,
    ) -> Result<Self, Faults> {
        let octree = Self::read_octree(map)?;
        let lattice = Lattice::new(octree.voxel_size()).map_err(|e| Fault::from(e).in_file(map))?;
        let is_given = bounds.is_some();
        let bounds = match bounds {
            Some(bounds) => bounds,
            None => suitable_box(&octree, &lattice, map).map_err(|fault| fault.in_file(map))?,
        };
        let block = block(&lattice, &bounds)?;
        if is_given {
            check_holds_map(&octree, &lattice, &block)?;
        }
        let path = views;
        let views = ViewSpace::read_csv(files::open(path)?, bounds.center())
            .map_err(|e| Fault::from(e).in_file(path))?;
        check_near(&views, &bounds).map_err(|fault| fault.in_file(path))?;
        if let Some(view) = visited.iter().find(|view| **view >= views.len()) {
            return Err(Fault::of_value("visited", view, format!("0 to {}", views.len() - 1)).into());
        }
        Ok(Self { snapshot: snapshot(&octree, lattice, block), views, intrinsics, visited })
    }

    /// The view candidates.
    pub fn views(&self) -> &ViewSpace {
        &self.views
    }

    /// Returns the view that the configuration's planner chooses; `None` if no candidate gains anything.
    pub fn next_view(&self, config: &ScanConfig) -> Result<Option<Choice>, Fault> {
        let planner = &config.planner;
        if planner.properties().needs_frames {
            let message = format!(
                "the planner {planner} needs the depth images behind the map, which a map does not hold"
            );
            return Err(Fault::request(message).with_remedy("use it in a scan"));
        }
        if planner.properties().is_network {
            check_shows_object(&self.snapshot)?;
        }
        let mut planner = config.planner(None)?;
        let plan = planner.plan(&self.situation(&Cancel::default()))?;
        Ok(plan.choice)
    }

    /// Plans several views at once, a tour through them, and a bound on the best choice of this number.
    pub fn next_views(&self, config: BatchConfig) -> Result<BatchPlan, Fault> {
        let batch = Batch::new(config)?;
        Ok(batch.plan_batch(&self.situation(&Cancel::default()))?)
    }

    fn situation<'a>(&'a self, cancel: &'a Cancel) -> Situation<'a> {
        let situation = Situation::new(&self.snapshot, &self.views, &self.intrinsics, cancel);
        situation.with_visited(&self.visited).expect("the numbers were checked")
    }
}

/// The known voxels of a block. Only these are visited: a leaf may stand for 2^48. Log-odds of exactly 0 are
/// unknown, as in [`Octree::to_map`].
fn snapshot(octree: &Octree, lattice: Lattice, block: VoxelBlock) -> Snapshot {
    let mut values = vec![f32::NAN; block.n_voxels()];
    for (leaf, min, max) in known_inside(octree, &block) {
        for z in min.z..=max.z {
            for y in min.y..=max.y {
                let row = |x| block.index(IVec3::new(x, y, z)).expect("the leaf was cut to the block");
                values[row(min.x)..=row(max.x)].fill(leaf.log_odds);
            }
        }
    }
    Snapshot::from_fn(lattice, block, |key| {
        let value = values[block.index(key)?];
        (!value.is_nan()).then_some(LogOdds(value))
    })
}

/// The known leaves, each with the lowest and highest of its voxels in the block.
fn known_inside<'a>(
    octree: &'a Octree,
    block: &VoxelBlock,
) -> impl Iterator<Item = (Leaf, IVec3, IVec3)> + 'a {
    let (low, high) = (block.min(), block.max());
    known(octree).filter_map(move |leaf| {
        let (min, max) = leaf.part_between(low, high)?;
        Some((leaf, min, max))
    })
}

fn known(octree: &Octree) -> impl Iterator<Item = Leaf> {
    octree.leaves().filter(|leaf| leaf.log_odds != 0.0)
}

/// Fails if the map has measurements, but none in the box: all views would gain the same.
fn check_holds_map(octree: &Octree, lattice: &Lattice, block: &VoxelBlock) -> Result<(), Fault> {
    if known_inside(octree, block).next().is_some() {
        return Ok(());
    }
    let centers = known(octree).flat_map(|leaf| [leaf.min, leaf.max()]).map(|key| lattice.center(key));
    let Some(Aabb { min, max }) = Aabb::around(centers) else { return Ok(()) };
    let message = format!("`box` holds none of the map's voxels, which lie from {min:.3} to {max:.3} m");
    Err(Fault::request(message).with_remedy("set `box` to a cube around the object"))
}

/// Fails if no view is near enough to show any of the box.
fn check_near(views: &ViewSpace, bounds: &Aabb) -> Result<(), Fault> {
    let distance =
        |position: DVec3| (bounds.min - position).max(position - bounds.max).max(DVec3::ZERO).length();
    let distances = views.poses().iter().map(|pose| distance(pose.translation()));
    let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((view, distance)) = nearest.filter(|(_, distance)| *distance > RANGE) else { return Ok(()) };
    let Aabb { min, max } = bounds;
    let fault = Fault::data(format!(
        "no view is within {RANGE} m, the camera's range, of the box from {min:.3} to {max:.3} m: the \
         nearest, view {view} (counted from 0), is {distance:.1} m away"
    ));
    Err(fault.with_remedy(match distance / 1000.0 <= RANGE {
        true => "positions are in metres; these may be in millimetres",
        false => "positions are in metres, in the coordinates of the map",
    }))
}

fn block(lattice: &Lattice, bounds: &Aabb) -> Result<VoxelBlock, Fault> {
    let config = SessionConfig::new(lattice.voxel_size(), *bounds);
    config.block(bounds).map_err(|error| match error {
        Error::TooLarge { needed_mb, limit_mb, .. } => {
            let share = (limit_mb as f64 / needed_mb as f64).cbrt();
            let half = 0.5 * bounds.longest_side() * share;
            let remedy = format!("set `box` to a smaller cube: half its edge can be up to {half:.2} m");
            Fault::from(error).with_remedy(remedy)
        }
        error => Fault::from(error).with_remedy("set `box` to another cube"),
    })
}

/// The planning box around the occupied voxels, if in proportion to the file.
fn suitable_box(octree: &Octree, lattice: &Lattice, map: &Path) -> Result<Aabb, Fault> {
    let remedy = "set `box` to a cube around the object";
    let occupied = octree.leaves().filter(|leaf| leaf.log_odds > 0.0);
    let corners = occupied.flat_map(|leaf| [leaf.min, leaf.max()]);
    let bounds = Aabb::around(corners.map(|key| lattice.center(key))).ok_or_else(|| {
        Fault::data("no occupied voxel, so the object's place is unknown").with_remedy(remedy)
    })?;
    let bounds = planning_box(&bounds, lattice.voxel_size());
    let n_voxels = (bounds.size() / lattice.voxel_size()).ceil().element_product();
    let (n_bytes, needed) = (map.metadata()?.len(), n_voxels * BYTES_PER_VOXEL as f64);
    let limit = FREE_MEMORY.saturating_add(n_bytes.saturating_mul(20));
    if needed <= limit as f64 {
        return Ok(bounds);
    }
    let [needed_mb, limit_mb] = [needed, limit as f64].map(|bytes| (bytes / 1e6).ceil());
    let fault = Fault::data(format!(
        "planning in the box around its occupied voxels, from {:.3} to {:.3} m, would need {needed_mb} MB, more than \
         the limit of {limit_mb} MB for a map of {n_bytes} bytes",
        bounds.min, bounds.max
    ));
    Err(fault.with_remedy(remedy))
}

/// Fails if the box, the input of a network, contains no object: the network would propose a view anyway.
fn check_shows_object(snapshot: &Snapshot) -> Result<(), Fault> {
    if snapshot.count(Occupancy::Occupied) > 0 {
        return Ok(());
    }
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    let place = format!("from {:.3} to {:.3} m", bounds.min, bounds.max);
    let message = format!("the object is outside the network's box: no occupied voxel in the box {place}");
    Err(Fault::data(message).with_remedy("set `box` to a cube around the object"))
}
