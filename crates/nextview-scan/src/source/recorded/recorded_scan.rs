use crate::source::session_config::{VOXEL_SIZE, session_config, suitable_voxel_size, voxel_block};
#[cfg(feature = "simulated")]
use crate::source::{
    recorded::true_shape::{RecordedEvaluation, TrueShape},
    simulated::{Baselines, Truth, measure_model},
};
use crate::{
    BoxRule, Captured, Evaluator, Fault, Faults, FrameSource, RecordingConfig, ScanConfig, ScanRecord,
    StepRecord, TableRule, short_name,
};
use glam::DVec3;
#[cfg(feature = "simulated")]
use nextview::Cancel;
use nextview::geometry::Aabb;
#[cfg(feature = "simulated")]
use nextview::geometry::Pose;
use nextview::object::{BOX_MARGIN_FACTOR, BOX_MARGIN_VOXELS, ObjectBox, Table};
use nextview::planner::ViewPlanner;
use nextview::sensor::{ColorImage, SurfaceNoise};
use nextview::session::{NextView, Session, SessionConfig};
use nextview::view::ViewSpace;
use nextview_model::SurfaceMesh;
use nextview_recording::{RecordedFrame, Recording, Skipped};
use std::path::Path;

/// A scan of recorded frames: their poses are the candidates, and the planner chooses among those not yet
/// used.
pub struct RecordedScan {
    recording: Recording,
    session_config: SessionConfig,
    notes: Vec<String>,
    #[cfg(feature = "simulated")]
    truth: Option<TrueShape>,
    #[cfg(feature = "simulated")]
    shown: Option<(Truth, Baselines)>,
}

impl RecordedScan {
    /// Opens the configured recording and completes the configuration: the camera, the number of views, the
    /// voxel size, whether the box grows.
    pub fn open(config: &mut ScanConfig) -> Result<Self, Faults> {
        let Some(recording_config) = config.source.recording().cloned() else {
            return Err(Fault::request("there is no `recording`").into());
        };
        let mut recording = Recording::open(Path::new(&config.object), &recording_config.read)?;
        let n_recorded = recording.frames.len();
        recording.frames =
            config.reach.filter(recording.frames, |frame| frame.world_from_camera.translation())?;
        let session_config = resolve(config, &recording_config, &recording)?;
        let notes = recording.notes.clone();
        #[cfg(feature = "simulated")]
        let (truth, notes) = {
            let truth = TrueShape::load(config, &recording_config, &session_config)?;
            let note = truth.as_ref().and_then(|truth| truth.note.clone());
            if truth.is_none() {
                // Before any computation.
                config.planner(None).map(drop).map_err(|fault| {
                    match config.planner.properties().needs_truth {
                        true => fault.with_remedy("set `recording.truth` to its mesh"),
                        false => fault,
                    }
                })?;
            }
            (truth, notes.into_iter().chain(note).collect())
        };
        let reach_note = config.reach.note(recording.frames.len(), n_recorded);
        let notes = Vec::into_iter(notes).chain(reach_note).collect();
        Ok(Self {
            recording,
            session_config,
            notes,
            #[cfg(feature = "simulated")]
            truth,
            #[cfg(feature = "simulated")]
            shown: None,
        })
    }

    /// Computes the visible part of the true object in every frame, for baselines and the clairvoyant
    /// planner; does nothing if the truth is unknown. Fails if cancelled.
    #[cfg(feature = "simulated")]
    pub fn look(&mut self, config: &ScanConfig, cancel: &Cancel) -> Result<(), Fault> {
        if let Some(truth) = self.truth.as_ref().filter(|_| config.needs_truth()) {
            let truth = truth.shown_by(&self.recording, cancel)?;
            let baselines = Baselines::new(&truth, config);
            self.shown = Some((truth, baselines));
        }
        Ok(())
    }

    /// Name, number of frames and size of the images.
    pub fn description(&self, config: &ScanConfig) -> String {
        let (width, height) = (self.recording.intrinsics.width(), self.recording.intrinsics.height());
        let n = self.recording.frames.len();
        format!("{}: {n} recorded frames of {width} x {height} pixels", short_name(&config.object))
    }

    /// Notes for the user: oddities of the recording, a guessed unit, frames out of reach.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Frames and poses left out, and why.
    pub fn skipped(&self) -> Vec<String> {
        self.recording.skipped.iter().map(ToString::to_string).collect()
    }

    /// Number of frames within reach.
    pub fn n_views(&self) -> usize {
        self.recording.frames.len()
    }

    fn frame(&self, view: Option<usize>) -> Option<&RecordedFrame> {
        self.recording.frames.get(view?)
    }

    #[cfg(feature = "simulated")]
    fn clairvoyant(&self) -> Option<Box<dyn ViewPlanner>> {
        let (truth, _) = self.shown.as_ref()?;
        Some(Box::new(nextview_sim::baseline::Clairvoyant::new(truth.visibility.clone())))
    }

    #[cfg(not(feature = "simulated"))]
    fn clairvoyant(&self) -> Option<Box<dyn ViewPlanner>> {
        None
    }
}

impl FrameSource for RecordedScan {
    fn session(&self, config: &ScanConfig) -> Result<Session, Faults> {
        let views = self.recording.frames.iter().map(|frame| frame.world_from_camera).collect();
        let planner = config.planner(self.clairvoyant())?;
        Ok(Session::new(self.session_config, config.camera, ViewSpace::new(views)?, planner)?)
    }

    fn capture(&self, next: &NextView, _: bool) -> Result<Captured, Fault> {
        let frame = self.frame(next.view).expect("all views are fixed candidates, the first one, too");
        Ok(Captured { frame: frame.load()?, truth: None })
    }

    fn color(&self, next: &NextView) -> Result<Option<ColorImage>, Fault> {
        Ok(self.frame(next.view).map_or(Ok(None), RecordedFrame::load_color)?)
    }

    fn bounds(&self) -> Option<Aabb> {
        None
    }

    fn evaluator(&self, _: &ScanConfig) -> Box<dyn Evaluator + '_> {
        Box::new(RecordedEvaluator {
            scan: self,
            #[cfg(feature = "simulated")]
            progress: self
                .truth
                .as_ref()
                .map(|truth| truth.progress(self.shown.as_ref().map(|(shown, _)| &shown.reachable_voxels))),
        })
    }
}

/// Names the frames, and evaluates them if the truth is known.
struct RecordedEvaluator<'a> {
    scan: &'a RecordedScan,
    #[cfg(feature = "simulated")]
    progress: Option<RecordedEvaluation<'a>>,
}

impl Evaluator for RecordedEvaluator<'_> {
    fn measure(
        &mut self,
        session: &Session,
        _: Option<&NextView>,
        _: Captured,
        record: &mut StepRecord,
    ) -> Result<(), Fault> {
        record.frame = self.scan.frame(record.view).map(|frame| frame.name.clone());
        #[cfg(feature = "simulated")]
        if let Some(progress) = &mut self.progress {
            let n_seen = progress.measure(session, record);
            let baselines = self.scan.shown.as_ref().map(|(_, baselines)| baselines);
            record.reachable_coverage = baselines.map(|baselines| baselines.reachable_coverage(n_seen));
        }
        #[cfg(not(feature = "simulated"))]
        let _ = session;
        Ok(())
    }

    fn describe(&self, record: &mut ScanRecord) {
        record.skipped = self.scan.skipped();
        record.notes.clone_from(&self.scan.recording.notes);
        let grows = self.scan.session_config.object_box == ObjectBox::Growing;
        record.box_rule = Some(if grows { BoxRule::Grows } else { BoxRule::Known });
        record.box_margin_factor = grows.then_some(BOX_MARGIN_FACTOR);
        record.box_margin_voxels = grows.then_some(BOX_MARGIN_VOXELS);
        #[cfg(feature = "simulated")]
        {
            record.object_voxels = self.scan.truth.as_ref().map(TrueShape::n_voxels);
            self.scan.shown.iter().for_each(|(_, baselines)| baselines.describe(record));
        }
    }

    #[cfg(feature = "simulated")]
    fn measure_model(&self, cloud: &[DVec3], mesh: Option<&SurfaceMesh>, record: &mut ScanRecord) {
        let Some(truth) = &self.scan.truth else { return };
        let reachable = self.scan.shown.as_ref().map(|(shown, _)| &shown.reachable_surface);
        // The pose of the true mesh in the recording's world was given, so an error may not be the scan's
        // alone.
        measure_model((&truth.surface, reachable), &Pose::IDENTITY, cloud, mesh, record);
    }

    #[cfg(not(feature = "simulated"))]
    fn measure_model(&self, _: &[DVec3], _: Option<&SurfaceMesh>, _: &mut ScanRecord) {}
}

/// Why some recorded frames are not used; `None` if all are.
fn left_out(skipped: &[Skipped]) -> Option<String> {
    let first = skipped.first()?;
    Some(match skipped.len() {
        1 => first.to_string(),
        n => format!("{n} frames of the recording are left out; {first}"),
    })
}

/// Writes the recording's values into the configuration, and derives the session's.
fn resolve(
    config: &mut ScanConfig,
    recording_config: &RecordingConfig,
    recording: &Recording,
) -> Result<SessionConfig, Faults> {
    config.check_views(recording.frames.len()).map_err(|faults| {
        faults.map(|fault| match (left_out(&recording.skipped), &fault.remedy) {
            (Some(why), Some(remedy)) => {
                let remedy = format!("{remedy}; {why}");
                fault.with_remedy(remedy)
            }
            (Some(why), None) => fault.with_remedy(why),
            (None, _) => fault,
        })
    })?;
    config.camera = recording.intrinsics;
    let n_frames = recording.frames.len();
    config.views = Some(config.max_views(n_frames));
    let bounds = recording_config.bounds();
    let suitable = bounds.map_or(VOXEL_SIZE, |bounds| suitable_voxel_size(bounds.longest_side()));
    let voxel_size = *config.voxel_size_m.get_or_insert(suitable);
    config.object_box.rule = if bounds.is_some() { BoxRule::Known } else { BoxRule::Grows };
    let table = match (recording_config.table_z_m, config.object_box.table) {
        (Some(z), _) => Table::AtHeight(z),
        (None, TableRule::Fit) => Table::Fitted,
        _ => Table::None,
    };
    let object_box = bounds.map_or(ObjectBox::Growing, ObjectBox::Known);
    let session_config = session_config(config, n_frames, voxel_size, object_box, table);
    // A real camera is never exact.
    let planned_error = match session_config.surface_error {
        unknown if unknown == SurfaceNoise::default() => SurfaceNoise::of_unknown_camera(),
        stated => stated,
    };
    let session_config = SessionConfig { planned_error, ..session_config };
    bounds.map(|bounds| voxel_block(&session_config, &bounds)).transpose()?;
    Ok(session_config)
}
