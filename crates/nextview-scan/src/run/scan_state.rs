use super::scan_facts::ScanFacts;
use crate::earlier_scan::EarlierScan;
use crate::model::{Extent, cloud_positions};
use crate::{
    BoxRule, Evaluator, Fault, FinalModel, FrameSource, HandEyeRecord, ModelConfig, ScanConfig, ScanJournal,
    ScanRecord, StepRecord, TurnRecord, ViewRule, memory, short_name,
};
use glam::{DVec2, DVec3};
use nextview::geometry::{Aabb, Plane};
use nextview::motion::Trajectory;
use nextview::object::{BOX_MARGIN_FACTOR, BOX_MARGIN_VOXELS, ON_TABLE, TableTops};
use nextview::registration::PoseFit;
use nextview::sensor::{ColorImage, Depth, Frame};
use nextview::session::{NextView, Session, StopReason};
use nextview_model::{SurfaceMesh, WatertightMesh};
use nextview_robot::path::JointTrajectory;
use std::borrow::Cow;

/// A scan in its current state, finished or not.
pub struct ScanState<'a> {
    /// The session: its map, its frames in their mapped poses, its candidates.
    pub session: Session,
    /// The source of the frames; `None` if a user's camera pushed them.
    pub(crate) source: Option<&'a dyn FrameSource>,
    /// `None` if a user's camera pushed the frames.
    pub(crate) evaluator: Option<Box<dyn Evaluator + 'a>>,
    pub(crate) journal: Option<ScanJournal>,
    /// The scan before the object was turned.
    pub(crate) earlier: Option<EarlierScan>,
    /// What the configuration states about the frames.
    pub(crate) facts: ScanFacts,
    /// For each step, the requested view; `None` if its frame was not requested.
    pub(crate) requested: Vec<Option<NextView>>,
    /// The trajectory from the preceding view to each view.
    pub trajectories: Vec<Trajectory>,
    /// For each step, the motion of the robot to its view; `None` if there is no robot, or if the frame was
    /// not requested.
    pub joint_trajectories: Vec<Option<JointTrajectory>>,
    /// The views.
    pub steps: Vec<StepRecord>,
    /// For each step, the colours pushed with its frame.
    pub(crate) colors: Vec<Option<ColorImage>>,
    /// The reason why the scan ended; `None` while it is in progress.
    pub stop_reason: Option<StopReason>,
}

/// The frames for a model, in their current poses.
pub struct ModelFrames<'a> {
    /// The frames of the map. Once the object's turn is known, those of the previous scan come first, and all
    /// show only the object.
    pub frames: Cow<'a, [Frame]>,
    /// Number of frames, at the beginning, from the scan before the turn.
    pub n_earlier: usize,
}

/// The part of the final model that is evaluated against ground truth.
#[derive(Clone, Copy, Debug)]
pub enum Measured<'a> {
    /// Nothing.
    Nothing,
    /// The cloud, without normals and colours, which take most of the time.
    CloudOnly,
    /// Cloud and mesh of this model.
    Model(&'a FinalModel),
}

impl ScanState<'_> {
    /// The scan of this session before its first view.
    pub(crate) fn new(session: Session) -> Self {
        Self {
            session,
            source: None,
            evaluator: None,
            journal: None,
            earlier: None,
            facts: ScanFacts::default(),
            requested: Vec::new(),
            trajectories: Vec::new(),
            joint_trajectories: Vec::new(),
            steps: Vec::new(),
            colors: Vec::new(),
            stop_reason: None,
        }
    }

    /// Drops the source of the frames, and with it their colours and the truth.
    pub fn without_source(self) -> ScanState<'static> {
        ScanState { source: None, evaluator: None, ..self }
    }

    /// The object's box in metres; `None` if no object was found.
    pub fn bounds(&self) -> Option<Aabb> {
        self.session.bounds().or_else(|| self.source.and_then(FrameSource::bounds))
    }

    /// The box of the model in metres; `None` if no object was found. This is the object's box; if both
    /// placements of a turned object are known, it extends to just below the table.
    pub fn model_bounds(&self) -> Option<Aabb> {
        let mut bounds = self.bounds()?;
        if let (Some(table), false) = (self.session.table(), self.session.earlier_frames().is_empty()) {
            let margin = 2.0 * self.session.map().lattice().voxel_size();
            let on_table = |corner: DVec3| corner.z - table.height(corner) / table.normal().z;
            let lowest = bounds.corners().map(on_table).into_iter().fold(bounds.min.z, f64::min);
            bounds.min.z = lowest - margin;
        }
        Some(bounds)
    }

    /// Edge of the cells of the final cloud and mesh in metres: a quarter of a voxel, since the map's voxels
    /// are larger than the camera's resolution, but at most 128 cells along the box, which limits meshing to
    /// a second or two.
    pub fn detail(&self, bounds: Aabb) -> f64 {
        let voxel_size = self.session.map().lattice().voxel_size();
        (0.25 * voxel_size).max(bounds.longest_side() / 128.0)
    }

    /// Makes cloud and mesh, closed if configured. Fails if no object was found, if a colour image cannot be
    /// loaded, or if cancelled; to make the model of a cancelled scan, reset the flag.
    pub fn model(&self, config: ModelConfig) -> Result<FinalModel, Fault> {
        let extent = self.extent().ok_or_else(|| self.no_object())?;
        let ModelFrames { frames, n_earlier } = self.model_frames()?;
        let color = |i: usize| self.model_color(i, n_earlier);
        FinalModel::new(&frames, color, extent, config, self.session.cancel())
    }

    /// The extent and resolution of the model; `None` before an object was found.
    fn extent(&self) -> Option<Extent> {
        let bounds = self.model_bounds()?;
        let (detail, error) = (self.detail(bounds), self.session.surface_error());
        Some(Extent { bounds, table: self.table(), tops: self.table_tops(), detail, error })
    }

    /// The frames for the model. Fails if cancelled.
    pub fn model_frames(&self) -> Result<ModelFrames<'_>, Fault> {
        Ok(match self.session.frames_of_object()? {
            None => ModelFrames { frames: self.session.frames().into(), n_earlier: 0 },
            Some(frames) => {
                ModelFrames { frames: frames.into(), n_earlier: self.session.earlier_frames().len() }
            }
        })
    }

    /// The colours of a frame of the model by index, given the number of frames of the previous scan; `None`
    /// if there are no colours.
    pub fn model_color(&self, i: usize, n_earlier: usize) -> Result<Option<ColorImage>, Fault> {
        match (i.checked_sub(n_earlier), &self.earlier) {
            (Some(now), _) => self.color(self.session.frame_numbers()[now]),
            (None, Some(earlier)) => earlier.color(i),
            (None, None) => Ok(None),
        }
    }

    /// The table top in each frame of the model; `None` if frames show only the object.
    pub fn table_tops(&self) -> Option<TableTops> {
        self.session.table_tops().filter(|_| self.session.earlier_frames().is_empty())
    }

    /// The record. Fails if the cloud to be measured cannot be made, or if cancelled.
    pub fn record(&self, config: &ScanConfig, measured: Measured<'_>) -> Result<ScanRecord, Fault> {
        let mut record = self.bare_record(config);
        record.other_bodies = self.session.other_bodies()?.into_iter().map(Into::into).collect();
        if let Measured::Model(model) = measured {
            if let Some([median, p95]) = model.expected_errors() {
                record.cloud_expected_error_median_mm = Some(1e3 * median);
                record.cloud_expected_error_p95_mm = Some(1e3 * p95);
            }
            record.mesh_filled_share = model.closed.as_ref().map(WatertightMesh::filled_share);
        }
        let Some(evaluator) = &self.evaluator else { return Ok(record) };
        match measured {
            Measured::Nothing => (),
            Measured::CloudOnly => {
                evaluator.measure_model(&self.of_object(self.cloud_positions()?), None, &mut record);
            }
            Measured::Model(model) => {
                let mesh = above(self.table(), &model.mesh);
                let cloud = model.cloud.iter().map(|point| point.position);
                evaluator.measure_model(&self.of_object(cloud), Some(&mesh), &mut record);
            }
        }
        Ok(record)
    }

    /// The record without the model's measures and other bodies.
    pub(crate) fn bare_record(&self, config: &ScanConfig) -> ScanRecord {
        let last = self.steps.last();
        let (bounds, fit) = (self.session.bounds(), self.session.pose_fit());
        let mut record = ScanRecord {
            object: short_name(&config.object),
            planner: config.planner.clone(),
            profile: config.profile,
            seed: config.seed,
            stop_reason: self.stop_reason,
            voxel_size_m: self.session.map().lattice().voxel_size(),
            candidates: self.session.views().len(),
            views: self.steps.len(),
            frames_set_aside: self.session.aligns_frames().then(|| self.session.set_aside().len()),
            frame_residual_mm: fit.and_then(PoseFit::residual).map(|m| 1e3 * m),
            frame_residuals_mm: fit.map(|fit| self.residuals_mm(fit)),
            hand_eye: fit.and_then(|fit| fit.hand_eye).map(HandEyeRecord::from),
            box_min_m: bounds.map(|bounds| bounds.min.to_array()),
            box_max_m: bounds.map(|bounds| bounds.max.to_array()),
            path_length_m: last.map_or(0.0, |step| step.path_length_m),
            trajectory_length_m: last.map_or(0.0, |step| step.trajectory_length_m),
            trajectory_time_s: last.map_or(0.0, |step| step.trajectory_time_s),
            peak_memory_mb: memory::peak_mb(),
            turn: self.session.turn().map(TurnRecord::from),
            next_placement: self.stop_reason.and_then(|_| self.session.next_placement()).map(Into::into),
            steps: self.steps.clone(),
            ..ScanRecord::default()
        };
        if let Some(evaluator) = &self.evaluator {
            evaluator.describe(&mut record);
            set_seeds(&mut record, config);
        }
        if config.source.live().is_some() {
            describe_box(&mut record, config.object_box.rule);
            set_seeds(&mut record, config);
        }
        record
    }

    /// By step, the residual of its frame in the map, millimetres.
    fn residuals_mm(&self, fit: &PoseFit) -> Vec<Option<f64>> {
        let mut by_step = vec![None; self.steps.len()];
        // Frames of an earlier placement come first.
        for (&step_idx, residual) in self.session.frame_numbers().iter().rev().zip(fit.residuals.iter().rev())
        {
            by_step[step_idx] = residual.map(|m| 1e3 * m);
        }
        by_step
    }

    /// Removes the journal: the results are on the disk, or there will be none.
    pub fn forget_journal(&mut self) {
        if let Some(journal) = self.journal.take() {
            journal.finish();
        }
    }

    /// The frame of a step by its index from 0, in its mapped pose, or set aside.
    pub fn frame(&self, step_idx: usize) -> Result<&Frame, Fault> {
        let mapped = self.session.frame_numbers().iter().copied().zip(self.session.frames());
        let aside = self.session.set_aside().iter().map(|aside| (aside.number, &aside.frame));
        let found = mapped.chain(aside).find(|(number, _)| *number == step_idx);
        let expected = || match self.steps.len() {
            0 => "a frame to be taken first".to_owned(),
            n => format!("0 to {}", n - 1),
        };
        found.map(|(_, frame)| frame).ok_or_else(|| Fault::of_value("step_idx", step_idx, expected()))
    }

    /// The colours of a step by its index from 0: the pushed ones, otherwise those of the source.
    ///
    /// # Panics
    /// If there is no such step.
    pub fn color(&self, step_idx: usize) -> Result<Option<ColorImage>, Fault> {
        if let Some(color) = &self.colors[step_idx] {
            return Ok(Some(color.clone()));
        }
        let candidate = self.requested[step_idx].as_ref().filter(|next| next.view.is_some());
        match self.source.zip(candidate) {
            Some((source, next)) => source.color(next),
            None => Ok(None),
        }
    }

    /// The positions of the final cloud.
    fn cloud_positions(&self) -> Result<Vec<DVec3>, Fault> {
        let Some(extent) = self.extent() else { return Ok(Vec::new()) };
        cloud_positions(&self.model_frames()?.frames, extent, self.session.cancel())
    }

    /// The points that do not belong to the table.
    fn of_object(&self, points: impl IntoIterator<Item = DVec3>) -> Vec<DVec3> {
        let table = self.table();
        points.into_iter().filter(|point| is_above(table, *point)).collect()
    }

    /// The fault of a scan with no object in its first frame.
    fn no_object(&self) -> Fault {
        let first = self.session.frames().first();
        let key = |key: &str| self.facts.section.map(|section| format!("`{section}.{key}`"));
        if let Some(height) = self.table().zip(first).and_then(|(table, frame)| middle_height(table, frame)) {
            let message = format!(
                "the first frame shows no object above the table, so there is nothing to plan for; 95 % of \
                 the points in the middle of the image are at most {:.1} mm above it",
                1e3 * height
            );
            let stated = key("table_z_m").map(|key| format!("; {key} states where the table is"));
            let remedy = "set `first_view` to begin with another frame; a closer view or a less noisy camera \
                          shows flat objects";
            return Fault::data(message).with_remedy(format!("{remedy}{}", stated.unwrap_or_default()));
        }
        let depth = first.and_then(middle_depth).map_or_else(
            || "it measured no depth".to_owned(),
            |depth| format!("the median of its depths is {depth:.3} m"),
        );
        let stated = key("box_m").map(|key| format!(", {key} states where the object is"));
        let message = format!("the first frame shows no object, so there is nothing to plan for; {depth}");
        Fault::data(message).with_remedy(format!(
            "set `first_view` to begin with another frame{}; if the object is not that far away, state the \
             unit of the depth images",
            stated.unwrap_or_default()
        ))
    }

    /// The table in the frames of the model; `None` if they show only the object.
    fn table(&self) -> Option<Plane> {
        self.session.table().filter(|_| self.session.earlier_frames().is_empty())
    }
}

/// Describes the object's box in front of a user's camera.
fn describe_box(record: &mut ScanRecord, rule: BoxRule) {
    let grows = rule == BoxRule::Grows;
    record.box_rule = Some(rule);
    record.box_margin_factor = grows.then_some(BOX_MARGIN_FACTOR);
    record.box_margin_voxels = grows.then_some(BOX_MARGIN_VOXELS);
}

/// The seeds of all draws that the scan made.
fn set_seeds(record: &mut ScanRecord, config: &ScanConfig) {
    let is_simulated = config.source.is_simulated();
    let has_rule = config.source.live().map_or(is_simulated, |live| live.poses.is_empty());
    let has_shell = has_rule && config.view_space.rule() == Some(ViewRule::Shell);
    record.view_seed = has_shell.then(|| config.view_seed());
    record.baseline_seed = record.random_curve.as_ref().map(|_| config.baseline_seed);
    #[cfg(feature = "simulated")]
    {
        let is_noisy = is_simulated && !config.noise.noise().is_none();
        record.noise_seed = is_noisy.then_some(config.noise.seed);
    }
}

/// Median depth of a frame in metres; `None` if none was measured.
fn middle_depth(frame: &Frame) -> Option<f32> {
    let image = frame.image();
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| image.get(u, v)));
    let surface = |depth| if let Depth::Surface(depth) = depth { Some(depth) } else { None };
    let mut depths: Vec<f32> = pixels.filter_map(surface).collect();
    let middle = depths.len() / 2;
    (!depths.is_empty()).then(|| *depths.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// The 95 % quantile of the height above a table, in metres, of the points in the middle half of a frame;
/// `None` if nothing was measured there.
fn middle_height(table: Plane, frame: &Frame) -> Option<f64> {
    let camera_from_world = frame.world_from_camera().inverse();
    let size = DVec2::new(frame.image().width().into(), frame.image().height().into());
    let is_in_the_middle = |point: &DVec3| {
        let pixel = frame.intrinsics().project(camera_from_world.transform_point(*point));
        pixel.is_some_and(|pixel| (pixel / size - 0.5).abs().max_element() <= 0.25)
    };
    let mut heights: Vec<f64> =
        frame.points().filter(is_in_the_middle).map(|point| table.height(point)).collect();
    let rank = heights.len() * 95 / 100;
    (!heights.is_empty()).then(|| *heights.select_nth_unstable_by(rank, f64::total_cmp).1)
}

fn is_above(table: Option<Plane>, point: DVec3) -> bool {
    table.is_none_or(|table| table.height(point) > ON_TABLE)
}

/// The part of a mesh above the table.
fn above(table: Option<Plane>, mesh: &SurfaceMesh) -> SurfaceMesh {
    let is_above =
        |triangle: &&[u32; 3]| triangle.iter().all(|&i| is_above(table, mesh.vertices[i as usize]));
    let triangles = mesh.triangles.iter().filter(is_above).copied().collect();
    SurfaceMesh { vertices: mesh.vertices.clone(), triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::object::{ObjectBox, Table};
    use nextview::planner::RandomViews;
    use nextview::sensor::{DepthImage, Intrinsics};
    use nextview::session::SessionConfig;
    use nextview::view::{ViewSpace, look_at};

    /// A scan that saw a flat table from above, 0.5 m away.
    fn of_flat(table: Table, section: Option<&'static str>) -> Fault {
        let (width, height) = (64, 48);
        let camera = Intrinsics::pinhole(width, height, DVec2::splat(60.0), DVec2::new(31.5, 23.5)).unwrap();
        let pose = look_at(DVec3::new(0.0, 0.0, 0.5), DVec3::ZERO).unwrap();
        let image = DepthImage::from_metres(width, height, vec![0.499; camera.n_pixels()]).unwrap();
        let config = SessionConfig {
            object_box: ObjectBox::Growing,
            table,
            ..SessionConfig::new(0.005, Aabb::cube(DVec3::ZERO, 0.1))
        };
        let views = ViewSpace::new(vec![pose]).unwrap();
        let mut session = Session::new(config, camera, views, Box::new(RandomViews { seed: 0 })).unwrap();
        session.observe(&Frame::new(image, camera, pose, 1.0).unwrap()).unwrap();
        let facts = ScanFacts { section, ..ScanFacts::default() };
        let scan = ScanState { facts, ..ScanState::new(session) };
        scan.model(ModelConfig::default()).map(drop).unwrap_err()
    }

    #[test]
    fn a_scan_without_an_object_says_what_the_frame_shows() {
        let fault = of_flat(Table::AtHeight(0.0), Some("recording"));
        assert!(fault.message.ends_with("in the middle of the image are at most 1.0 mm above it"), "{fault}");
        let remedy = fault.remedy.unwrap();
        assert!(remedy.ends_with("; `recording.table_z_m` states where the table is"), "{remedy}");
        let remedy = of_flat(Table::AtHeight(0.0), None).remedy.unwrap();
        assert!(!remedy.contains("table_z_m"), "a simulation cannot state it: {remedy}");
    }

    #[test]
    fn the_table_is_no_part_of_the_model() {
        let table = Some(Plane::horizontal(0.1).unwrap());
        let height = |z: f64| DVec3::new(0.3, 0.2, z);
        assert!(
            is_above(table, height(0.103)) && !is_above(table, height(0.101)) && is_above(None, height(0.0))
        );
        let vertices = [0.0, 0.11, 0.12, 0.13].map(height).to_vec();
        let mesh = SurfaceMesh { vertices, triangles: vec![[0, 1, 2], [1, 2, 3]] };
        assert_eq!(above(table, &mesh).triangles, [[1, 2, 3]]);
        assert_eq!(above(None, &mesh), mesh);
    }
}
