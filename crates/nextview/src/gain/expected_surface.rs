use crate::Error;
use crate::geometry::Pose;
use crate::map::{Occupancy, Snapshot};
use crate::prior::{SurfaceEstimate, ViewingClass};
use crate::sensor::{DepthRange, Intrinsics};
use crate::visibility::{MeasuredParts, Paths, RayCaster, ValueCaster};
use glam::{DVec3, Vec3};

/// The expected number of newly seen surface voxels of a view, under a
/// [`SurfacePrior`](crate::prior::SurfacePrior).
///
/// Rays end at the measured [parts](MeasuredParts) of occupied voxels, and continue through unknown voxels as
/// far as the prior allows. Each voxel counts once per view, with the probability that the view newly sees
/// it, taken from the ray that reaches it with the largest visibility. Voxels in which surface was measured
/// do not count, even if later rays made them free.
#[derive(Debug)]
pub struct ExpectedSurface<'a> {
    estimate: &'a SurfaceEstimate,
    caster: ValueCaster<'a>,
    /// The voxels of the estimate.
    items: Vec<SurveyVoxel>,
    /// An origin near the block, metres, so that single precision is enough; the world's if that is near.
    origin: DVec3,
}

/// The data of a voxel for a survey, in one cache line.
#[derive(Debug)]
#[repr(align(32))]
struct SurveyVoxel {
    /// The middle of the voxel, metres from [`ExpectedSurface::origin`].
    center: Vec3,
    /// As [`SurfaceEstimate::normal`].
    normal: Vec3,
    is_measured: bool,
}

/// The visibility behind an occupied voxel with surface at an unknown position: the surface may leave a part
/// of it open.
const PASSES_OCCUPIED: f32 = 0.25;

/// The visibility past the measured surface of an occupied voxel, where the rest of it may lie, and behind a
/// free voxel at the border of the unknown.
const PASSES_BORDER: f32 = 0.995;

/// Visibility below which a ray ends.
const FADED: f32 = 0.03;

impl<'a> ExpectedSurface<'a> {
    /// Creates the gain under an estimate for this snapshot, for a camera with these optics and depths.
    /// `measured` holds the parts of the snapshot's voxels where surface was measured. `ray_spacing` is the
    /// distance between neighbouring rays at the far side of the box, in voxels of the snapshot, positive.
    ///
    /// # Panics
    /// If `measured` is of another block.
    pub fn new(
        snapshot: &'a Snapshot,
        intrinsics: &Intrinsics,
        depth_range: DepthRange,
        measured: &'a MeasuredParts,
        estimate: &'a SurfaceEstimate,
        ray_spacing: f64,
    ) -> Result<Self, Error> {
        assert_eq!(measured.block(), snapshot.block(), "parts of the snapshot's voxels");
        let passes = passes(snapshot, measured, estimate);
        let caster =
            RayCaster::through(snapshot, intrinsics, ray_spacing, &passes, FADED)?.within(depth_range);
        let caster = caster.behind(measured);
        // Every voxel of the estimate weakens rays, so the caster numbers all of them in the order of the
        // estimate.
        let mut is_item = vec![0.0; passes.len()];
        estimate.voxels().iter().for_each(|&voxel| is_item[voxel as usize] = 1.0);
        let (lattice, block) = (snapshot.lattice(), snapshot.block());
        let (local, origin) = (block.localized(), block.local_origin().as_dvec3() * lattice.voxel_size());
        let item = |(i, &voxel): (usize, &u32)| SurveyVoxel {
            center: lattice.center(local.key(voxel as usize)).as_vec3(),
            normal: estimate.normal(i),
            is_measured: measured.is_measured(voxel as usize),
        };
        let items = estimate.voxels().iter().enumerate().map(item).collect();
        let caster = ValueCaster::new(caster, snapshot, &is_item);
        Ok(Self { estimate, caster, items, origin })
    }

    /// Returns an evaluator of view candidates.
    pub fn evaluator(&self) -> ViewEvaluator<'_> {
        ViewEvaluator {
            gain: self,
            paths: self.caster.paths(),
            visibility: vec![0.0; self.estimate.len()],
            seen: Vec::new(),
            classes: Vec::new(),
        }
    }
}

/// Evaluates view candidates one by one.
#[derive(Debug)]
pub struct ViewEvaluator<'a> {
    gain: &'a ExpectedSurface<'a>,
    paths: Paths,
    /// By voxel of the estimate, the largest visibility in the view; all zero between views.
    visibility: Vec<f32>,
    /// The voxels reached by rays of the view.
    seen: Vec<u32>,
    /// Voxels with their class in the view; empty between views.
    classes: Vec<(u32, ViewingClass)>,
}

impl ViewEvaluator<'_> {
    /// Visits each voxel of the estimate that rays of the view reach once, in a fixed order: with its index
    /// in the estimate and the class of the view for it.
    pub fn survey(&mut self, world_from_camera: &Pose, mut visit: impl FnMut(usize, ViewingClass)) {
        let Self { gain, paths, visibility, seen, .. } = self;
        gain.caster.cast(world_from_camera, paths, |item, value| {
            let (best, value) = (&mut visibility[item], value as f32);
            if value > *best {
                if *best == 0.0 {
                    seen.push(item as u32);
                }
                *best = value;
            }
        });
        let camera = (world_from_camera.translation() - gain.origin).as_vec3();
        for item in seen.drain(..).map(|item| item as usize) {
            let SurveyVoxel { center, normal, is_measured } = gain.items[item];
            let facing = (camera - center).normalize().dot(normal);
            let visibility = std::mem::take(&mut visibility[item]);
            if !is_measured {
                visit(item, ViewingClass::new(visibility, facing));
            }
        }
    }

    /// As [`survey`](Self::survey), but with the probability that the view shows new surface in the voxel.
    pub fn shown(&mut self, world_from_camera: &Pose, mut visit: impl FnMut(usize, f32)) {
        let mut classes = std::mem::take(&mut self.classes);
        self.survey(world_from_camera, |item, class| classes.push((item as u32, class)));
        // In a separate loop, so that the CPU fetches many entries of the table, which is larger than its
        // caches, at a time.
        for (item, class) in classes.drain(..) {
            visit(item as usize, self.gain.estimate.shows(item as usize, class));
        }
        self.classes = classes;
    }

    /// Returns the number of voxels of new surface that the view is expected to show.
    pub fn gain(&mut self, world_from_camera: &Pose) -> f64 {
        let mut sum = 0.0;
        self.shown(world_from_camera, |_, p| sum += p as f64);
        sum
    }
}

/// The share of visibility that each voxel of the snapshot passes on.
fn passes(snapshot: &Snapshot, measured: &MeasuredParts, estimate: &SurfaceEstimate) -> Vec<f32> {
    let occupancy = snapshot.occupancy();
    let pass_known = |(voxel, state): (usize, &Occupancy)| match state {
        Occupancy::Occupied if measured.is_measured(voxel) => PASSES_BORDER,
        Occupancy::Occupied => PASSES_OCCUPIED,
        _ => 1.0,
    };
    let mut passes: Vec<f32> = occupancy.iter().enumerate().map(pass_known).collect();
    for (i, &voxel) in estimate.voxels().iter().enumerate() {
        let is_free = occupancy[voxel as usize] == Occupancy::Free;
        passes[voxel as usize] =
            if is_free { PASSES_BORDER } else { (1.0 - estimate.stops(i)).clamp(1e-3, 0.999) };
    }
    passes
}
