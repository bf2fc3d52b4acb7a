use super::turn::turn_error;
use super::{Baselines, SimulatedObject, Truth, measure_model};
use crate::{BoxRule, Captured, Evaluator, Fault, Faults, FrameSource, ScanConfig, ScanRecord, StepRecord};
use glam::DVec3;
use nextview::geometry::{Aabb, Pose};
use nextview::object::{BOX_MARGIN_FACTOR, BOX_MARGIN_VOXELS};
use nextview::planner::ViewPlanner;
use nextview::sensor::ColorImage;
use nextview::session::{NextView, Session};
use nextview_model::SurfaceMesh;
use nextview_sim::baseline::Clairvoyant;
use nextview_sim::evaluator;
use nextview_sim::quality::align;

/// A simulated camera that scans an object with one configuration.
pub struct Simulation<'a> {
    object: &'a SimulatedObject,
    truth: Option<&'a Truth>,
    baselines: Option<Baselines>,
}

impl<'a> Simulation<'a> {
    /// Creates the scan of this object with this configuration. With the truth, it is compared with the
    /// baselines.
    pub fn new(object: &'a SimulatedObject, config: &ScanConfig, truth: Option<&'a Truth>) -> Self {
        Self { object, truth, baselines: truth.map(|truth| Baselines::new(truth, config)) }
    }
}

impl FrameSource for Simulation<'_> {
    fn session(&self, config: &ScanConfig) -> Result<Session, Faults> {
        let clairvoyant = self
            .truth
            .map(|truth| Box::new(Clairvoyant::new(truth.visibility.clone())) as Box<dyn ViewPlanner>);
        self.object.session(config, config.planner(clairvoyant)?)
    }

    fn capture(&self, next: &NextView, is_first: bool) -> Result<Captured, Fault> {
        let (frame, truth) = evaluator::capture(&self.object.scene, &next.world_from_camera, is_first)?;
        Ok(Captured { frame, truth: Some(truth) })
    }

    /// Renders on demand, for an object with colours.
    fn color(&self, next: &NextView) -> Result<Option<ColorImage>, Fault> {
        Ok(self.object.scene.camera().color(&next.world_from_camera)?)
    }

    fn bounds(&self) -> Option<Aabb> {
        Some(self.object.scene.planning_box(self.object.voxel_size))
    }

    fn evaluator(&self, config: &ScanConfig) -> Box<dyn Evaluator + '_> {
        Box::new(SimulatedEvaluator::new(self, config))
    }
}

/// Evaluates a simulated run against ground truth.
struct SimulatedEvaluator<'a> {
    simulation: &'a Simulation<'a>,
    evaluator: evaluator::Evaluator<'a>,
    box_rule: BoxRule,
    /// Whether frames claim wrong poses.
    is_pose_wrong: bool,
    /// Whether the first frame claims a wrong pose, which displaces the whole model from the truth.
    is_first_pose_wrong: bool,
}

impl<'a> SimulatedEvaluator<'a> {
    /// Starts before the first frame.
    fn new(simulation: &'a Simulation<'a>, config: &ScanConfig) -> Self {
        let object = simulation.object;
        let mut evaluator = evaluator::Evaluator::new(&object.scene, &object.object_voxels);
        if let Some(truth) = simulation.truth {
            evaluator = evaluator.with_reachable(&truth.reachable_voxels);
        }
        let is_pose_wrong = config.noise.is_pose_wrong();
        let is_first_pose_wrong = is_pose_wrong && !config.noise.first_pose_is_right;
        let box_rule = config.object_box.rule;
        Self { simulation, evaluator, box_rule, is_pose_wrong, is_first_pose_wrong }
    }

    /// Fills in the error of the turn; does nothing if poses are wrong as a whole.
    fn measure_turn(&self, record: &mut ScanRecord) {
        let (Some(turn), false) = (&mut record.turn, self.is_first_pose_wrong) else { return };
        let object = self.simulation.object;
        let poses = object.now_from_before().zip(turn.now_from_before());
        let error = |(truth, found)| 1e3 * turn_error(&object.true_surface, &truth, &found);
        turn.error_mm = poses.map(error);
    }
}

impl Evaluator for SimulatedEvaluator<'_> {
    fn measure(
        &mut self,
        session: &Session,
        taken: Option<&NextView>,
        Captured { frame, truth }: Captured,
        record: &mut StepRecord,
    ) -> Result<(), Fault> {
        let truth = match truth {
            Some(truth) => truth,
            // The camera truly stood where it was sent.
            None => {
                let place = taken.map_or(frame.world_from_camera(), |next| next.world_from_camera);
                evaluator::capture(&self.simulation.object.scene, &place, false)?.1
            }
        };
        let measures = self.evaluator.measure(session, &frame, truth);
        let baselines = self.simulation.baselines.as_ref();
        record.set_voxels(&measures.voxels);
        record.reachable_coverage =
            baselines.map(|baselines: &Baselines| baselines.reachable_coverage(measures.n_seen));
        [record.surface_coverage_1mm, record.surface_coverage_2mm, record.surface_coverage_5mm] =
            measures.surface_coverage.map(Some);
        record.misplaced_mm = measures.misplacement.filter(|_| self.is_pose_wrong).map(|m| 1e3 * m);
        Ok(())
    }

    fn describe(&self, record: &mut ScanRecord) {
        record.object_voxels = Some(self.simulation.object.object_voxels.len());
        record.box_rule = Some(self.box_rule);
        record.box_margin_factor = Some(BOX_MARGIN_FACTOR);
        record.box_margin_voxels = Some(BOX_MARGIN_VOXELS);
        self.simulation.baselines.iter().for_each(|baselines| baselines.describe(record));
        self.measure_turn(record);
    }

    fn measure_model(&self, cloud: &[DVec3], mesh: Option<&SurfaceMesh>, record: &mut ScanRecord) {
        let surface = &self.simulation.object.true_surface;
        let truth_from_model = match self.is_first_pose_wrong {
            true => align(cloud, surface.distance()),
            false => Pose::IDENTITY,
        };
        let reachable = self.simulation.truth.map(|truth| &truth.reachable_surface);
        measure_model((surface, reachable), &truth_from_model, cloud, mesh, record);
    }
}
