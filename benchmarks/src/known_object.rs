//! An object whose truth is known, on which planners that the settings do not offer are compared.

use nextview::geometry::Lattice;
use nextview::planner::ViewPlanner;
use nextview::sensor::Intrinsics;
use nextview::session::{Decision, Session, SessionConfig};
use nextview::view::{ViewSpace, generate};
use nextview_sim::baseline::{RandomCurve, clairvoyant_curve, extended, skill};
use nextview_sim::evaluator::{Evaluator, ScanCamera};
use nextview_sim::mesh::{self, Unit};
use nextview_sim::scene::Scene;
use nextview_sim::truth::{ObjectVoxels, TrueVisibility};
use std::error::Error;
use std::path::Path;

const N_VIEWS: usize = 10;

/// A mesh, its longest side 0.2 m, before candidates all around it.
pub struct KnownObject {
    /// The object before a D435i without noise.
    pub scene: Scene,
    /// The candidates.
    pub views: ViewSpace,
    /// The true surface, in voxels of [`VOXEL_SIZE`](Self::VOXEL_SIZE).
    pub voxels: ObjectVoxels,
    /// What each candidate truly sees.
    pub truth: TrueVisibility,
}

impl KnownObject {
    /// Number of candidates.
    pub const N_CANDIDATES: usize = 1000;

    /// Edge of voxels, metres.
    pub const VOXEL_SIZE: f64 = 0.005;

    /// Reads a mesh.
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

    /// The skill of ten views from this one on; none where random views are the best there are.
    pub fn skill(
        &self,
        planner: Box<dyn ViewPlanner>,
        first_view: usize,
    ) -> Result<Option<f64>, Box<dyn Error>> {
        let bounds = self.scene.planning_box(Self::VOXEL_SIZE);
        let config =
            SessionConfig { first_view, max_views: N_VIEWS, ..SessionConfig::new(Self::VOXEL_SIZE, bounds) };
        let mut session = Session::new(config, Intrinsics::d435i(), self.views.clone(), planner)?;
        let (mut camera, mut evaluator) =
            (ScanCamera::new(&self.scene), Evaluator::new(&self.scene, &self.voxels));
        let mut seen = Vec::new();
        while let Decision::Move(next) = session.decide()? {
            let (frame, shown) = camera.capture(&next)?;
            let report = session.observe(&frame)?;
            let measures = evaluator.measure(&session, &frame.with_pose(report.world_from_camera), shown);
            seen.push(measures.n_seen as f64 / self.truth.n_reachable() as f64);
        }
        let random = RandomCurve::new(&self.truth, first_view, N_VIEWS, 0).mean;
        Ok(skill(&extended(seen, N_VIEWS), &random, &clairvoyant_curve(&self.truth, first_view, N_VIEWS)))
    }
}
