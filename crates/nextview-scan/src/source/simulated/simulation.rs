use super::turn::turn_error;
use super::{Baselines, SimulatedObject, Truth, measure_model};
use crate::{BoxRule, Evaluator, Fault, Faults, FrameSource, ScanConfig, ScanRecord, StepRecord};
use glam::DVec3;
use nextview::geometry::{Aabb, Pose};
use nextview::object::{BOX_MARGIN_FACTOR, BOX_MARGIN_VOXELS};
use nextview::planner::ViewPlanner;
use nextview::sensor::{ColorImage, Frame};
use nextview::session::{NextView, Session};
use nextview_model::SurfaceMesh;
use nextview_sim::baseline::Clairvoyant;
use nextview_sim::evaluator::{self, Shown};
use nextview_sim::quality::align;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// A simulated camera that scans an object with one configuration.
pub struct Simulation<'a> {
    object: &'a SimulatedObject,
    truth: Option<&'a Truth>,
    baselines: Option<Baselines>,
    box_rule: BoxRule,
    /// Whether the first frame claims a wrong pose, which displaces the whole model from the truth.
    is_first_pose_wrong: bool,
    /// The true content and pose of the last frame: rendered together, and evaluated right after.
    last: Mutex<Option<(Pose, Shown)>>,
    /// The true pose of the camera by view.
    places: Mutex<BTreeMap<usize, Pose>>,
}

impl<'a> Simulation<'a> {
    /// Creates the scan of this object with this configuration. With the truth, it is compared with the
    /// baselines.
    pub fn new(object: &'a SimulatedObject, config: &ScanConfig, truth: Option<&'a Truth>) -> Self {
        let baselines = truth.map(|truth| Baselines::new(truth, config));
        let is_first_pose_wrong = config.noise.is_pose_wrong() && !config.noise.first_pose_is_right;
        let box_rule = config.object_box.rule;
        let (last, places) = (Mutex::new(None), Mutex::default());
        Self { object, truth, baselines, box_rule, is_first_pose_wrong, last, places }
    }

    /// Records the camera's true pose.
    fn stood(&self, next: &NextView) {
        if let Some(view) = next.view {
            let mut places = self.places.lock().unwrap_or_else(PoisonError::into_inner);
            places.insert(view, next.world_from_camera);
        }
    }

    /// The true content of the camera's image from this pose.
    fn shown_from(&self, world_from_camera: &Pose) -> Result<Shown, Fault> {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner).take();
        match last.filter(|(place, _)| place == world_from_camera) {
            Some((_, shown)) => Ok(shown),
            None => Ok(evaluator::capture(&self.object.scene, world_from_camera, false)?.1),
        }
    }
}

impl Simulation<'_> {
    /// Fills in the error of the turn; does nothing if poses are wrong as a whole.
    fn measure_turn(&self, record: &mut ScanRecord) {
        let (Some(turn), false) = (&mut record.turn, self.is_first_pose_wrong) else { return };
        let poses = self.object.now_from_before().zip(turn.now_from_before());
        let error = |(truth, found)| 1e3 * turn_error(&self.object.true_surface, &truth, &found);
        turn.error_mm = poses.map(error);
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
        self.stood(next);
        let (frame, shown) = evaluator::capture(&self.object.scene, &place, is_first)?;
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some((place, shown));
        Ok(frame)
    }

    fn evaluator(&self, config: &ScanConfig) -> Option<Box<dyn Evaluator + '_>> {
        Some(Box::new(SimulatedEvaluator::new(self, config.noise.is_pose_wrong())))
    }

    /// Renders on demand, for an object with colours.
    fn color(&self, view: Option<usize>) -> Result<Option<ColorImage>, Fault> {
        let places = self.places.lock().unwrap_or_else(PoisonError::into_inner);
        let place = view.and_then(|view| places.get(&view).copied());
        drop(places);
        Ok(place.map(|place| self.object.scene.camera().color(&place)).transpose()?.flatten())
    }

    fn bounds(&self) -> Option<Aabb> {
        Some(self.object.scene.planning_box(self.object.voxel_size))
    }

    fn describe(&self, record: &mut ScanRecord) {
        record.object_voxels = Some(self.object.object_voxels.len());
        record.box_rule = Some(self.box_rule);
        record.box_margin_factor = Some(BOX_MARGIN_FACTOR);
        record.box_margin_voxels = Some(BOX_MARGIN_VOXELS);
        self.baselines.iter().for_each(|baselines| baselines.describe(record));
        self.measure_turn(record);
    }

    fn measure_model(&self, cloud: &[DVec3], mesh: Option<&SurfaceMesh>, record: &mut ScanRecord) {
        let surface = &self.object.true_surface;
        let truth_from_model = match self.is_first_pose_wrong {
            true => align(cloud, surface.distance()),
            false => Pose::IDENTITY,
        };
        let reachable = self.truth.map(|truth| &truth.reachable_surface);
        measure_model((surface, reachable), &truth_from_model, cloud, mesh, record);
    }
}

/// Evaluates a simulated run against ground truth.
struct SimulatedEvaluator<'a> {
    simulation: &'a Simulation<'a>,
    evaluator: evaluator::Evaluator<'a>,
    /// Whether frames claim wrong poses.
    is_pose_wrong: bool,
}

impl<'a> SimulatedEvaluator<'a> {
    /// Starts before the first frame.
    pub fn new(simulation: &'a Simulation<'a>, is_pose_wrong: bool) -> Self {
        let object = simulation.object;
        let mut evaluator = evaluator::Evaluator::new(&object.scene, &object.object_voxels);
        if let Some(truth) = simulation.truth {
            evaluator = evaluator.with_reachable(&truth.reachable_voxels);
        }
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
        taken.iter().for_each(|next| self.simulation.stood(next));
        let place = taken.map_or(frame.world_from_camera(), |next| next.world_from_camera);
        let shown = self.simulation.shown_from(&place)?;
        let truth = self.evaluator.measure(session, frame, shown);
        let baselines = self.simulation.baselines.as_ref();
        record.set_voxels(&truth.voxels);
        record.reachable_coverage =
            baselines.map(|baselines: &Baselines| baselines.reachable_coverage(truth.n_seen));
        [record.surface_coverage_1mm, record.surface_coverage_2mm, record.surface_coverage_5mm] =
            truth.surface_coverage.map(Some);
        record.misplaced_mm = truth.misplacement.filter(|_| self.is_pose_wrong).map(|m| 1e3 * m);
        Ok(())
    }
}
