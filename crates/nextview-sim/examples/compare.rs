//! Compares planners on meshes: coverage after each view and skill, at equal candidates, start view and sensor.
//!
//!     cargo run --release -p nextview-sim --example compare -- VOXEL_SIZE_M MESH...
//!
//! Voxel size in metres, meshes in any format that `nextview scan` reads. Every mesh is looked at from 1000 candidates of the
//! paper's shell (seed 0), 10 views each from candidate 0; random views are the mean of 20 seeds.

#![allow(clippy::unwrap_used, reason = "an example stops at the first fault")]

use nextview::gain::{
    Apora, AreaFactor, AverageEntropy, Krainin, OcclusionAware, ProximityCount, RearSideEntropy,
    RearSideVoxel, UnobservedVoxel,
};
use nextview::geometry::Lattice;
use nextview::map::Background;
use nextview::planner::{Greedy, GreedyConfig, MaxFlow, MaxFlowConfig, RandomViews, ViewPlanner};
use nextview::sensor::Intrinsics;
use nextview::session::{Session, SessionConfig};
use nextview::view::{ViewSpace, generate};
use nextview::visibility::{FreeSpace, NO_VOXEL_MISSED};
use nextview_sim::baseline::{Clairvoyant, RandomCurve, clairvoyant_curve, extended, skill};
use nextview_sim::mesh::{self, Unit};
use nextview_sim::run::{self, Step};
use nextview_sim::scene::Scene;
use nextview_sim::truth::{ObjectVoxels, TrueVisibility};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

const N_VIEWS: usize = 10;
const N_CANDIDATES: usize = 1000;

struct Setup {
    scene: Scene,
    views: ViewSpace,
    voxel_size: f64,
    object: ObjectVoxels,
    truth: Arc<TrueVisibility>,
}

fn main() {
    let mut args = std::env::args().skip(1);
    let voxel_size: f64 =
        args.next().and_then(|size| size.parse().ok()).expect("usage: compare VOXEL_SIZE_M MESH...");
    println!(
        "{:<16} {:<22} {:>6}  seen of the reachable after views 1 to {N_VIEWS}, %",
        "object", "planner", "skill"
    );
    let mut skills: Vec<(&str, Vec<f64>)> = Vec::new();
    for path in args {
        let setup = Setup::new(Path::new(&path), voxel_size);
        let name = Path::new(&path).file_stem().unwrap().to_string_lossy().into_owned();
        for (planner, curve, time_ms) in setup.curves() {
            let value = setup.skill(&curve);
            let percents: Vec<String> = curve.iter().map(|share| format!("{:5.1}", 100.0 * share)).collect();
            println!("{name:<16} {planner:<22} {value:>6.2}  {}  {time_ms:>6.1} ms", percents.join(" "));
            match skills.iter_mut().find(|(known, _)| *known == planner) {
                Some((_, values)) => values.push(value),
                None => skills.push((planner, vec![value])),
            }
        }
    }
    println!("\nskill, mean over objects (lowest)");
    for (planner, values) in skills {
        let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
        println!("{planner:<22} {:>6.2} ({lowest:.2})", values.iter().sum::<f64>() / values.len() as f64);
    }
}

fn greedy_planners() -> [(&'static str, Box<dyn ViewPlanner>); 9] {
    let config = GreedyConfig::default();
    [
        ("apora", Box::new(Greedy::<Apora>::new(config).unwrap())),
        ("rse", Box::new(Greedy::<RearSideEntropy>::new(config).unwrap())),
        ("rear-side-voxel", Box::new(Greedy::<RearSideVoxel>::new(config).unwrap())),
        ("occlusion-aware", Box::new(Greedy::<OcclusionAware>::new(config).unwrap())),
        ("unobserved-voxel", Box::new(Greedy::<UnobservedVoxel>::new(config).unwrap())),
        ("proximity-count", Box::new(Greedy::<ProximityCount>::new(config).unwrap())),
        ("average-entropy", Box::new(Greedy::<AverageEntropy>::new(config).unwrap())),
        ("krainin", Box::new(Greedy::<Krainin>::new(config).unwrap())),
        ("area-factor", Box::new(Greedy::<AreaFactor>::new(config).unwrap())),
    ]
}

impl Setup {
    fn new(path: &Path, voxel_size: f64) -> Self {
        let (mesh, _) = mesh::load(path).unwrap().to_metres(Unit::LongestSide(0.2)).unwrap();
        let scene = Scene::new(mesh, Intrinsics::d435i()).unwrap();
        let views = generate::shell(scene.center(), scene.size(), N_CANDIDATES, 0).unwrap();
        let lattice = Lattice::new(voxel_size).unwrap();
        let block = lattice.block_inside(&scene.planning_box(voxel_size)).unwrap();
        let object = ObjectVoxels::new(scene.camera(), lattice, block);
        let truth = Arc::new(TrueVisibility::new(scene.camera(), &object, &views, || {}).unwrap());
        Self { scene, views, voxel_size, object, truth }
    }

    /// Name, coverage after each view, and median planning time of every planner: with the defaults, and with the
    /// paper's thin rays that fade in free space on maps without background; the literature's gains with the defaults.
    fn curves(&self) -> Vec<(&'static str, Vec<f64>, f64)> {
        let default = MaxFlowConfig::default();
        let paper = MaxFlowConfig { ray_spacing: 10.0, free_space: FreeSpace::Fades, ..default };
        let mut curves = Vec::new();
        for (name, config, background) in [
            ("max-flow", default, Background::Carve),
            ("local", MaxFlowConfig { gamma: 0.0, ..default }, Background::Carve),
            ("max-flow, dense", MaxFlowConfig { ray_spacing: NO_VOXEL_MISSED, ..default }, Background::Carve),
            ("max-flow, as paper", paper, Background::Ignore),
            ("local, as paper", MaxFlowConfig { gamma: 0.0, ..paper }, Background::Ignore),
        ] {
            let planner = MaxFlow::new(config).unwrap();
            let (curve, time) = self.run(Box::new(planner), background);
            curves.push((name, curve, time));
        }
        for (name, planner) in greedy_planners() {
            let (curve, time) = self.run(planner, Background::Carve);
            curves.push((name, curve, time));
        }
        let random: Vec<Vec<f64>> =
            (0..20).map(|seed| self.run(Box::new(RandomViews { seed }), Background::Carve).0).collect();
        let mean = |i: usize| random.iter().map(|curve| curve[i]).sum::<f64>() / random.len() as f64;
        curves.push(("random (20 seeds)", (0..N_VIEWS).map(mean).collect(), 0.0));
        let clairvoyant = Clairvoyant::new(self.truth.clone());
        curves.push(("clairvoyant", self.run(Box::new(clairvoyant), Background::Carve).0, 0.0));
        curves
    }

    fn run(&self, planner: Box<dyn ViewPlanner>, background: Background) -> (Vec<f64>, f64) {
        let bounds = self.scene.planning_box(self.voxel_size);
        let config = SessionConfig { background, ..SessionConfig::new(self.voxel_size, bounds) };
        let mut session = Session::new(config, Intrinsics::d435i(), self.views.clone(), planner).unwrap();
        let mut steps: Vec<Step> = Vec::new();
        run::run(&mut session, &self.scene, &self.object, |step| {
            steps.push(step);
            ControlFlow::Continue(())
        })
        .unwrap();
        let mut times: Vec<f64> =
            steps.iter().skip(1).map(|step| step.plan_time.as_secs_f64() * 1e3).collect();
        times.sort_by(f64::total_cmp);
        let time = times.get(times.len() / 2).copied().unwrap_or(0.0);
        let curve = steps.iter().map(|step| step.n_seen as f64 / self.truth.n_reachable() as f64).collect();
        (extended(curve, N_VIEWS), time)
    }

    fn skill(&self, curve: &[f64]) -> f64 {
        let random = RandomCurve::new(&self.truth, 0, N_VIEWS).mean;
        skill(curve, &random, &clairvoyant_curve(&self.truth, 0, N_VIEWS)).unwrap_or(f64::NAN)
    }
}
