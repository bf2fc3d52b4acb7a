use super::{Baselines, SimulatedObject, Truth, quality_mm};
use crate::{Evaluator, Fault, Faults, FrameSource, QualityMm, ScanConfig, ScanRecord, StepRecord};
use glam::DVec3;
use nextview::geometry::{Aabb, Pose};
use nextview::planner::ViewPlanner;
use nextview::sensor::{ColorImage, Frame};
use nextview::session::{NextView, Session};
use nextview::surface::SurfaceMesh;
use nextview_sim::baseline::Clairvoyant;
use nextview_sim::evaluator::{self, Shown};
use std::sync::{Mutex, PoisonError};

/// A simulated camera that scans an object by one configuration.
pub struct Simulation<'a> {
    object: &'a SimulatedObject,
    truth: Option<&'a Truth>,
    baselines: Option<Baselines>,
    /// What the last frame truly shows, and from where: rendered together, and measured right after.
    last: Mutex<Option<(Pose, Shown)>>,
}

impl<'a> Simulation<'a> {
    /// The scan of this object by this configuration. With the truth, it is measured against the baselines.
    pub fn new(object: &'a SimulatedObject, config: &ScanConfig, truth: Option<&'a Truth>) -> Self {
        let baselines = truth.map(|truth| Baselines::new(truth, config));
        Self { object, truth, baselines, last: Mutex::new(None) }
    }

    /// What the camera truly shows from there.
    fn shown_from(&self, world_from_camera: &Pose) -> Result<Shown, Fault> {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner).take();
        match last.filter(|(place, _)| place == world_from_camera) {
            Some((_, shown)) => Ok(shown),
            None => Ok(evaluator::capture(&self.object.scene, world_from_camera, false)?.1),
        }
    }
}

impl FrameSource for Simulation<'_> {
    fn session(&self, config: &ScanConfig) -> Result<Session, Faults> {
        let clairvoyant = self
            .truth
            .map(|truth| Box::new(Clairvoyant::new(truth.visibility.clone())) as Box<dyn ViewPlanner>);
        self.object.session(config, config.planner(clairvoyant)?)
    }

    fn capture(&self, next: &NextView, is_first: bool) -> Result<Frame, Fault> {
        let place = next.world_from_camera;
        let (frame, shown) = evaluator::capture(&self.object.scene, &place, is_first)?;
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some((place, shown));
        Ok(frame)
    }

    fn evaluator(&self, config: &ScanConfig) -> Option<Box<dyn Evaluator + '_>> {
        Some(Box::new(SimulatedEvaluator::new(self, config.noise.is_pose_wrong())))
    }

    fn color(&self, _: Option<usize>) -> Result<Option<ColorImage>, Fault> {
        Ok(None)
    }

    fn bounds(&self) -> Option<Aabb> {
        Some(self.object.scene.planning_box(self.object.voxel_size))
    }

    fn describe(&self, record: &mut ScanRecord) {
        record.object_voxels = Some(self.object.object_voxels.len());
        self.baselines.iter().for_each(|baselines| baselines.describe(record));
    }

    fn quality_of_points(&self, points: &[DVec3]) -> Option<QualityMm> {
        self.object.true_surface.of_points(points).map(quality_mm)
    }

    fn quality_of_mesh(&self, mesh: &SurfaceMesh) -> Option<QualityMm> {
        self.object.true_surface.of_mesh(mesh).map(quality_mm)
    }
}

/// Measures a simulated run beside the truth.
struct SimulatedEvaluator<'a> {
    simulation: &'a Simulation<'a>,
    evaluator: evaluator::Evaluator<'a>,
    /// Whether frames claim wrong poses.
    is_pose_wrong: bool,
}

impl<'a> SimulatedEvaluator<'a> {
    /// Nothing is scanned yet.
    pub fn new(simulation: &'a Simulation<'a>, is_pose_wrong: bool) -> Self {
        let object = simulation.object;
        let evaluator = evaluator::Evaluator::new(&object.scene, &object.object_voxels);
        Self { simulation, evaluator, is_pose_wrong }
    }
}

impl Evaluator for SimulatedEvaluator<'_> {
    fn measure(
        &mut self,
        session: &Session,
        taken: Option<&NextView>,
        frame: &Frame,
        record: &mut StepRecord,
    ) -> Result<(), Fault> {
        // The camera truly stood where it was sent.
        let place = taken.map_or(frame.world_from_camera(), |next| next.world_from_camera);
        let shown = self.simulation.shown_from(&place)?;
        let truth = self.evaluator.measure(session, frame, shown);
        let baselines = self.simulation.baselines.as_ref();
        record.voxel_coverage = Some(truth.voxels.coverage());
        record.false_voxels = Some(truth.voxels.n_false);
        record.reachable_coverage =
            baselines.map(|baselines: &Baselines| baselines.reachable_coverage(truth.n_seen));
        [record.surface_coverage_1mm, record.surface_coverage_2mm, record.surface_coverage_5mm] =
            truth.surface_coverage.map(Some);
        record.misplaced_mm = truth.misplacement.filter(|_| self.is_pose_wrong).map(|m| 1e3 * m);
        Ok(())
    }
}
