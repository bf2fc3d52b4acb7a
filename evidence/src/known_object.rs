//! An object with known truth, used to compare planners that the settings do not offer.

use nextview::geometry::Lattice;
use nextview::planner::ViewPlanner;
use nextview::sensor::Intrinsics;
use nextview::session::{Decision, Session, SessionConfig};
use nextview::view::{ViewSpace, generate};
use nextview_sim::baseline::{RandomCurve, clairvoyant_curve, extended, skill};
use nextview_sim::evaluator::{Evaluator, capture};
use nextview_sim::mesh::{self, Unit};
use nextview_sim::scene::Scene;
use nextview_sim::truth::{ObjectVoxels, TrueVisibility};
use std::error::Error;
use std::path::Path;

const N_VIEWS: usize = 10;

/// A mesh with a longest side of 0.2 m, with candidates all around it.
pub struct KnownObject {
    /// The object in front of a D435i without noise.
    pub scene: Scene,
    /// The candidates.
    pub views: ViewSpace,
    /// The true surface, in voxels of [`VOXEL_SIZE`](Self::VOXEL_SIZE).
    pub voxels: ObjectVoxels,
    /// The true visibility from each candidate.
    pub truth: TrueVisibility,
}

impl KnownObject {
    /// Number of candidates.
    pub const N_CANDIDATES: usize = 1000;

    /// Edge of voxels, metres.
    pub const VOXEL_SIZE: f64 = 0.005;

    /// Loads a mesh.
    pub fn load(path: &Path) -> Result<Self, Box<dyn Error>> {
        let (mesh, _) = mesh::load(path)?.to_metres(Unit::LongestSide(0.2))?;
        let scene = Scene::new(mesh, Intrinsics::d435i())?;
        let views = generate::shell(scene.center(), scene.size(), Self::N_CANDIDATES, 0)?;
        let lattice = Lattice::new(Self::VOXEL_SIZE)?;
        let block = lattice.block_inside(&scene.planning_box(Self::VOXEL_SIZE)).ok_or("no voxels")?;
        let voxels = ObjectVoxels::new(scene.camera().mesh(), lattice, block);
        let truth = TrueVisibility::new(scene.camera(), &voxels, &views, || {})?;
        Ok(Self { scene, views, voxels, truth })
    }

    /// Returns the skill of ten views starting with this one; `None` if random views are the best possible.
    pub fn skill(
        &self,
        planner: Box<dyn ViewPlanner>,
        first_view: usize,
    ) -> Result<Option<f64>, Box<dyn Error>> {
        let steps = self.scan(planner, first_view, |steps| steps.len() == N_VIEWS)?;
        let seen = steps.iter().map(|step| step.coverage).collect();
        let random = RandomCurve::new(&self.truth, first_view, N_VIEWS, 0).mean;
        Ok(skill(&extended(seen, N_VIEWS), &random, &clairvoyant_curve(&self.truth, first_view, N_VIEWS)))
    }

    /// Scans from this view on, until the steps suffice or the planner has no more views.
    pub fn scan(
        &self,
        planner: Box<dyn ViewPlanner>,
        first_view: usize,
        is_enough: impl Fn(&[KnownStep]) -> bool,
    ) -> Result<Vec<KnownStep>, Box<dyn Error>> {
        let bounds = self.scene.planning_box(Self::VOXEL_SIZE);
        let max_views = self.views.len();
        let config = SessionConfig { first_view, max_views, ..SessionConfig::new(Self::VOXEL_SIZE, bounds) };
        let sensing_time = config.motion.sensing_time;
        let mut session = Session::new(config, Intrinsics::d435i(), self.views.clone(), planner)?;
        let mut evaluator = Evaluator::new(&self.scene, &self.voxels);
        let (mut steps, mut seconds) = (Vec::new(), 0.0);
        while !is_enough(&steps)
            && let Decision::Move(next) = session.decide()?
        {
            seconds += session.trajectory_to(&next.world_from_camera)?.duration() + sensing_time;
            let (frame, truth) = capture(&self.scene, &next.world_from_camera, steps.is_empty())?;
            let report = session.observe(&frame)?;
            let measures = evaluator.measure(&session, &frame.with_pose(report.world_from_camera), truth);
            let coverage = measures.n_seen as f64 / self.truth.n_reachable() as f64;
            steps.push(KnownStep { seconds, coverage });
        }
        Ok(steps)
    }
}

/// The state of a scan after a view.
pub struct KnownStep {
    /// Seconds since the camera was at the first view: all moves, and the sensing time of each view.
    pub seconds: f64,
    /// Reachable coverage, 0..=1.
    pub coverage: f64,
}
