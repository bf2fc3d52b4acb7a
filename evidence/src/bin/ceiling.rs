//! Upper bounds on evaluating views: planners with the truth in place of the prior.
//!
//!     cargo run --release -p nextview-evidence --bin ceiling -- N_STARTS all|default MESH ...
//!
//! Each planner, or the default planner alone, takes ten views of each mesh (longest side 0.2 m, 5 mm voxels,
//! 1000 candidates all around, no noise) from each of `N_STARTS` first views, and gets a line with its mean
//! skill and that of the worst object. `default` is the default planner. `truth` knows the share of the rays
//! through a voxel that end in it, and the voxels that hold surface. It evaluates views as the default
//! planner does, with the given number of rays across the box. `rendered` renders the true surface in images
//! of the given width in pixels and counts the voxels that show unmeasured surface.

use fixedbitset::FixedBitSet;
use glam::{DVec2, DVec3};
use nextview::gain::ExpectedSurface;
use nextview::geometry::{Lattice, Pose, SegmentWalk};
use nextview::map::Occupancy;
use nextview::planner::{Choice, MostSurface, MostSurfaceConfig, Plan, Situation, ViewPlanner};
use nextview::prior::{SurfaceEstimate, SurfacePrior, ViewingClass};
use nextview::sensor::{DepthRange, Intrinsics};
use nextview::visibility::MeasuredParts;
use nextview_benchmarks::Outcome;
use nextview_evidence::known_object::KnownObject;
use nextview_sim::scene::Scene;
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;

/// Number of candidates between first views: a prime, which spreads them all around.
const APART: usize = 137;

/// Width in pixels of the images in which the shares of ending rays are counted, and the step between the
/// candidates of these images.
const COUNTED_PIXELS: u32 = 216;
const COUNTED_VIEWS: usize = 4;

/// Number of views evaluated with all rays, after all views with a quarter as many side by side.
const N_SHORT: usize = 100;

const PLANNERS: [Kind; 7] = [
    Kind::Default,
    Kind::Truth { rays_across: 32.0 },
    Kind::Truth { rays_across: 96.0 },
    Kind::Truth { rays_across: 192.0 },
    Kind::Rendered { width: 216 },
    Kind::Rendered { width: 432 },
    Kind::Rendered { width: 640 },
];

#[derive(Clone, Copy, Debug)]
enum Kind {
    Default,
    Truth { rays_across: f64 },
    Rendered { width: u32 },
}

fn main() -> Outcome<()> {
    let mut arguments = std::env::args().skip(1);
    let n_starts: usize = arguments.next().ok_or("the number of first views is missing")?.parse()?;
    let kinds = match arguments.next().as_deref() {
        Some("all") => &PLANNERS[..],
        Some("default") => &PLANNERS[..1],
        _ => return Err("the second argument must be 'all' or 'default'".into()),
    };
    let mut skills = vec![Vec::new(); kinds.len()];
    for path in arguments {
        let object = Arc::new(Object::load(Path::new(&path))?);
        for (&kind, skills) in kinds.iter().zip(&mut skills) {
            let all =
                (0..n_starts).map(|start| object.skill(kind, start * APART % KnownObject::N_CANDIDATES));
            let all: Vec<f64> = all.collect::<Outcome<_>>()?;
            skills.push(all.iter().sum::<f64>() / n_starts as f64);
        }
        eprintln!("{path}: {:.2?}", skills.iter().filter_map(|skills| skills.last()).collect::<Vec<_>>());
    }
    for (kind, skills) in kinds.iter().zip(&skills) {
        let mean = skills.iter().sum::<f64>() / skills.len() as f64;
        let lowest = skills.iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "{:<32} mean {mean:6.3}, lowest {lowest:5.2}, {} objects",
            format!("{kind:?}"),
            skills.len()
        );
    }
    Ok(())
}

struct Object {
    known: KnownObject,
    /// By voxel, the share of the rays through it that end in it.
    stops: Vec<f32>,
}

impl Object {
    fn load(path: &Path) -> Outcome<Self> {
        let known = KnownObject::load(path)?;
        let stops = true_stops(&known)?;
        Ok(Self { known, stops })
    }

    fn skill(self: &Arc<Self>, kind: Kind, first_view: usize) -> Outcome<f64> {
        let planner: Box<dyn ViewPlanner> = match kind {
            Kind::Default => Box::new(MostSurface::new(MostSurfaceConfig::default())?),
            Kind::Truth { rays_across } => Box::new(WithTruth { object: self.clone(), rays_across }),
            Kind::Rendered { width } => Box::new(Rendered::new(self, width)?),
        };
        Ok(self.known.skill(planner, first_view)?.ok_or("random views are the best")?)
    }
}

/// The object in front of a camera with the same field of view and `width` pixels across.
fn small_camera(object: &KnownObject, width: u32) -> Outcome<Scene> {
    let full = Intrinsics::d435i();
    let scale = f64::from(width) / f64::from(full.width());
    let height = (f64::from(full.height()) * scale).round() as u32;
    let center = DVec2::new(f64::from(width) - 1.0, f64::from(height) - 1.0) * 0.5;
    let small = Intrinsics::pinhole(width, height, full.focal() * scale, center)?;
    Ok(Scene::new((**object.scene.camera().mesh()).clone(), small)?)
}

fn true_stops(object: &KnownObject) -> Outcome<Vec<f32>> {
    let (scene, lattice) = (small_camera(object, COUNTED_PIXELS)?, Lattice::new(KnownObject::VOXEL_SIZE)?);
    let block = object.voxels.block();
    let mut counts = vec![(0_u32, 0_u32); block.n_voxels()];
    for pose in object.views.poses().iter().step_by(COUNTED_VIEWS) {
        for end in ray_ends(&scene, pose)? {
            let (from, to) = (lattice.to_voxels(pose.translation()), lattice.to_voxels(end));
            let mut walk = SegmentWalk::within(from, to, block.min(), block.max());
            while let Some(at) = &mut walk {
                let (n_through, n_ended) =
                    &mut counts[block.index(at.key()).expect("the walk is within the block")];
                *n_through += 1;
                *n_ended += u32::from(at.key() == lattice.key(end));
                if at.advance().is_none() {
                    break;
                }
            }
        }
    }
    Ok(counts.into_iter().map(|(n, n_ended)| n_ended as f32 / n.max(1) as f32).collect())
}

/// The true ends of all pixels' rays, in world coordinates, without those out of range.
fn ray_ends(scene: &Scene, pose: &Pose) -> Outcome<Vec<DVec3>> {
    let (depths, optics) = (scene.camera().render_depth(pose)?, scene.camera().intrinsics());
    let place = |(pixel, depth): (u32, &f32)| {
        let (u, v) = (pixel % optics.width(), pixel / optics.width());
        let ideal = optics.deproject(DVec2::new(f64::from(u), f64::from(v)))?;
        depth.is_finite().then(|| pose.transform_point(ideal.extend(1.0) * f64::from(*depth)))
    };
    Ok((0..).zip(&depths).filter_map(place).collect())
}

/// The view with the largest value, if positive.
fn best(open: &[usize], values: &[f64]) -> Plan {
    let best = (0..open.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]).then(b.cmp(&a)));
    let choice = best.filter(|&i| values[i] > 0.0).map(|i| Choice::new(open[i], values[i]));
    Plan { choice, ..Plan::default() }
}

/// Evaluates views like the default planner, but with knowledge of the object.
struct WithTruth {
    object: Arc<Object>,
    rays_across: f64,
}

impl ViewPlanner for WithTruth {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, nextview::Error> {
        let (snapshot, cancel) = (situation.snapshot(), situation.cancel());
        let block = snapshot.block();
        let learned = SurfacePrior::default().estimate(snapshot, cancel)?;
        let is_object = |voxel: u32| self.object.known.voxels.number(block.key(voxel as usize)).is_some();
        let (mut stops, mut shows) = (Vec::new(), Vec::new());
        for &voxel in learned.voxels() {
            let is_unknown = snapshot.occupancy()[voxel as usize] == Occupancy::Unknown;
            stops.push(if is_unknown { self.object.stops[voxel as usize] } else { 0.0 });
            shows.push(std::array::from_fn(|class| {
                if is_object(voxel) { MIDDLES[class * MIDDLES.len() / ViewingClass::N] } else { 0.0 }
            }));
        }
        let normals = (0..learned.len()).map(|i| learned.normal(i)).collect();
        let estimate = SurfaceEstimate::new(learned.voxels().to_vec(), normals, stops, shows);
        let measured = MeasuredParts::new(situation.frames(), snapshot, cancel)?;
        let rate = |views: &[usize], rays_across: f64| -> Result<Vec<f64>, nextview::Error> {
            let spacing = f64::from(block.dims().max_element()) / rays_across;
            let (optics, range) = (situation.intrinsics(), DepthRange::default());
            let gain = ExpectedSurface::new(snapshot, optics, range, &measured, &estimate, spacing)?;
            let one = |evaluator: &mut nextview::gain::ViewEvaluator<'_>, view: &usize| {
                evaluator.gain(&situation.views().pose(*view))
            };
            Ok(views.par_iter().map_init(|| gain.evaluator(), one).collect())
        };
        let mut open = situation.open_views();
        let coarse = rate(&open, self.rays_across / 4.0)?;
        let mut order: Vec<usize> = (0..open.len()).collect();
        order.sort_by(|&a, &b| coarse[b].total_cmp(&coarse[a]).then(a.cmp(&b)));
        open = order.into_iter().take(N_SHORT).map(|i| open[i]).collect();
        let values = rate(&open, self.rays_across)?;
        Ok(best(&open, &values))
    }
}

/// Middles of the classes of visibility.
const MIDDLES: [f32; 5] = [0.06, 0.21, 0.45, 0.75, 0.95];

/// Counts the voxels with new surface in small images of the true surface.
struct Rendered {
    object: Arc<Object>,
    /// By view, the object voxels in its image.
    shown: Vec<FixedBitSet>,
}

impl Rendered {
    fn new(object: &Arc<Object>, width: u32) -> Outcome<Self> {
        let (scene, lattice) = (small_camera(&object.known, width)?, Lattice::new(KnownObject::VOXEL_SIZE)?);
        let mut shown = Vec::new();
        for pose in object.known.views.poses() {
            let mut voxels = FixedBitSet::with_capacity(object.known.voxels.len());
            let numbers = ray_ends(&scene, pose)?.into_iter();
            numbers
                .filter_map(|end| object.known.voxels.number(lattice.key(end)))
                .for_each(|n| voxels.insert(n));
            shown.push(voxels);
        }
        Ok(Self { object: object.clone(), shown })
    }
}

impl ViewPlanner for Rendered {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, nextview::Error> {
        let mut seen = FixedBitSet::with_capacity(self.object.known.voxels.len());
        situation.frames().iter().for_each(|frame| seen.union_with(&self.object.known.voxels.seen_in(frame)));
        let open = situation.open_views();
        let values: Vec<f64> =
            open.iter().map(|&view| self.shown[view].difference_count(&seen) as f64).collect();
        Ok(best(&open, &values))
    }
}
