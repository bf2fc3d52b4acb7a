use super::fingerprint::fingerprint;
use super::known_poses::KnownPoses;
use crate::files::ResultFolder;
use crate::{
    Damage, Fault, Faults, Interrupted, LiveFrame, Next, OwnCamera, Results, RunOptions, ScanConfig,
    ScanJournal, ScanRun, ScanState, StepRecord, TakenFrame, ViewRecord, write_results,
};
use nextview::Cancel;
use nextview::geometry::Pose;
use nextview::motion::Trajectory;
use nextview::planner::Leg;
use nextview::registration::GivenPoses;
use nextview::sensor::{ColorImage, DepthImage};
use nextview::session::{NextView, StopReason};
use nextview_robot::path::JointTrajectory;
use std::path::Path;

/// A scan with a user's camera, configured with a section `live`.
///
/// The owner of the camera requests the [`next`](Self::next) view, takes a depth image there, and passes it
/// to [`observe`](Self::observe). With a folder, every frame is on the disk before it counts, and an
/// interrupted scan can be [resumed](Self::resume) without requesting old views again.
///
/// ```
/// use nextview::Cancel;
/// use nextview::sensor::DepthImage;
/// use nextview_scan::{LiveConfig, LiveFrame, LiveScan, ScanConfig, SourceConfig};
///
/// let live = LiveConfig { box_m: Some([-0.1, -0.1, -0.1, 0.1, 0.1, 0.1]), ..LiveConfig::default() };
/// let source = SourceConfig::Live(live);
/// let config = ScanConfig { source, views: Some(3), ..ScanConfig::default() };
/// let mut scan = LiveScan::begin(config, None, Cancel::default())?;
/// while let Some(view) = scan.next()? {
///     let nothing = vec![f32::INFINITY; scan.config().camera.n_pixels()];
///     let depth = DepthImage::from_metres(640, 480, nothing)?;
///     scan.observe(LiveFrame::new(depth, view.world_from_camera))?;
/// }
/// assert!(scan.scan().steps.len() <= 3 && scan.stop_reason().is_some());
/// # Ok::<(), nextview_scan::Faults>(())
/// ```
pub struct LiveScan {
    camera: OwnCamera,
    config: ScanConfig,
    run: ScanRun<'static>,
    cancel: Cancel,
    damage: Option<Damage>,
    /// For each step, the fingerprint of the frame as given.
    fingerprints: Vec<u64>,
    pub(super) poses: KnownPoses,
    /// Whether the journal was removed: a further frame would be in no file.
    is_closed: bool,
}

impl LiveScan {
    /// Begins a scan. With a folder, its frames are kept there until its results are
    /// [published](Self::forget_journal). Fails if the folder holds an interrupted scan.
    pub fn begin(mut config: ScanConfig, dir: Option<&Path>, cancel: Cancel) -> Result<Self, Faults> {
        let camera = OwnCamera::open(&mut config)?;
        let begin = |dir: &Path| {
            let text = toml::to_string(&config.kept_in(dir)).map_err(Fault::data)?;
            ScanJournal::begin(dir, &text)
        };
        let journal = dir.map(begin).transpose()?;
        Self::with_journal(camera, config, journal, cancel)
    }

    /// Resumes the scan in a folder and observes the frames kept there again. Fails if it is not a scan with
    /// a user's camera.
    ///
    /// If cancelled, it can be resumed again.
    pub fn resume(dir: &Path, cancel: Cancel) -> Result<Self, Faults> {
        let Interrupted { heading, journal, n_frames, damage } = ScanJournal::resume(dir)?;
        let path = dir.join(ScanJournal::FILE);
        let mut config = ScanConfig::parse(&heading, Some(&path), None)?;
        if config.source.live().is_none() {
            let fault = Fault::data("holds a scan of simulated or recorded frames").in_file(dir);
            return Err(fault.with_remedy("`nextview scan` resumes it").into());
        }
        let camera = OwnCamera::open(&mut config)?;
        let mut scan = Self { damage, ..Self::with_journal(camera, config, Some(journal), cancel)? };
        while scan.scan().steps.len() < n_frames {
            match scan.run.next()? {
                Next::Replay(frame) => _ = scan.push(frame.into())?,
                Next::Stop(StopReason::Cancelled) => return Err(nextview::Cancelled.into()),
                Next::Capture(_) | Next::Stop(_) => break,
            }
        }
        Ok(scan)
    }

    fn with_journal(
        camera: OwnCamera,
        config: ScanConfig,
        journal: Option<ScanJournal>,
        cancel: Cancel,
    ) -> Result<Self, Faults> {
        let options = RunOptions { journal, cancel: cancel.clone() };
        let run = ScanRun::of_session(camera.session(&config)?, &config, options)?;
        let (damage, fingerprints, poses, is_closed) = Default::default();
        Ok(Self { camera, config, run, cancel, damage, fingerprints, poses, is_closed })
    }

    /// The unreadable end of the journal when the scan was resumed: the frames there are lost.
    pub fn damage(&self) -> Option<&Damage> {
        self.damage.as_ref()
    }

    /// Returns the next view; `None` if the scan is over, for the [reason](Self::stop_reason). Repeated calls
    /// return the same view until a frame is observed or a view skipped.
    ///
    /// Fails if cancelled; it can then be called again.
    #[expect(clippy::should_implement_trait, reason = "an iterator could be neither asked again nor fail")]
    pub fn next(&mut self) -> Result<Option<NextView>, Fault> {
        self.run.scan_mut().stop_reason = None;
        loop {
            match self.run.next()? {
                // The observation was cancelled after the frame had been kept.
                Next::Replay(frame) => _ = self.push(frame.into())?,
                Next::Capture(view) => {
                    self.poses.asked = Some(view.world_from_camera);
                    return Ok(Some(view));
                }
                Next::Stop(StopReason::Cancelled) => return Err(nextview::Cancelled.into()),
                Next::Stop(reason) => {
                    self.run.scan_mut().stop_reason = Some(reason);
                    return Ok(None);
                }
            }
        }
    }

    /// Observes a frame from any pose; one without a pose is [located](Self::locate) first. The requested
    /// view, if any, counts as taken. Fails before any change if an image is not of the camera's size or
    /// cannot be kept, or if cancelled.
    ///
    /// A cancelled frame that was kept in a folder is observed by [`next`](Self::next), or can be observed
    /// again.
    pub fn observe(&mut self, taken: LiveFrame) -> Result<&StepRecord, Fault> {
        if self.is_closed {
            let fault = Fault::request("the scan is finished and saved, and accepts no more frames");
            return Err(fault.with_remedy("start a new scan"));
        }
        let LiveFrame { depth, world_from_camera, color, name } = taken;
        let pose = world_from_camera.map_or_else(|| self.locate(&depth), Ok)?;
        let frame = self.camera.frame(depth, pose)?;
        self.push(TakenFrame { frame, color, name })
    }

    /// Returns the step of an already observed frame, recognised by its name; `None` for a new or unnamed
    /// frame. A frame sent again after a lost answer therefore counts once.
    ///
    /// Fails if the frame of that name had other content, or can no longer be found on the disk.
    pub fn known(&self, frame: &LiveFrame) -> Result<Option<&StepRecord>, Fault> {
        let named = |step: &&StepRecord| frame.name.is_some() && step.frame == frame.name;
        let Some(step) = self.scan().steps.iter().find(named) else { return Ok(None) };
        let given = self.fingerprint(frame.world_from_camera.as_ref(), &frame.depth, frame.color.as_ref());
        if self.fingerprints[step.step - 1] == given {
            self.scan().journal.as_ref().map_or(Ok(()), ScanJournal::check)?;
            return Ok(Some(step));
        }
        let name = frame.name.as_deref().unwrap_or_default();
        let fault = Fault::of_value("id", name, "the same content as before, or a new id for a new frame");
        Err(fault.with_remedy(format!("step {} has a frame with this id but different content", step.step)))
    }

    fn push(&mut self, taken: TakenFrame) -> Result<&StepRecord, Fault> {
        let (pose, image) = (taken.frame.world_from_camera(), taken.frame.image().clone());
        let step_idx = self.run.push(taken)?.step - 1;
        self.poses = KnownPoses::default();
        let color = self.run.scan().color(step_idx)?;
        self.fingerprints.push(self.fingerprint(Some(&pose), &image, color.as_ref()));
        Ok(&self.run.steps()[step_idx])
    }

    /// Tracked poses are not given poses.
    fn fingerprint(&self, pose: Option<&Pose>, depth: &DepthImage, color: Option<&ColorImage>) -> u64 {
        let is_given = self.config.registration.given_poses != GivenPoses::Tracked;
        fingerprint(pose.filter(|_| is_given), depth, color)
    }

    /// Skips a candidate, for example one out of a robot's reach: it is never proposed again.
    pub fn skip(&mut self, view: usize, reason: &str) -> Result<(), Fault> {
        self.run.skip(view, reason)
    }

    /// The trajectory from the last frame to a view: that of the robot, for a requested view; otherwise see
    /// [`Session::trajectory_to`].
    ///
    /// [`Session::trajectory_to`]: nextview::session::Session::trajectory_to
    pub fn trajectory_to(&self, view: &NextView) -> Result<Trajectory, Fault> {
        self.run.trajectory_to(view)
    }

    /// The record of the next view, for a robot and for a page.
    pub fn record_of(&self, view: &NextView) -> Result<ViewRecord, Fault> {
        Ok(self.completed(view, &self.trajectory_to(view)?, self.joints_to(view)))
    }

    /// The record of a view with the turntable angle.
    fn completed(
        &self,
        view: &NextView,
        trajectory: &Trajectory,
        joints: Option<&JointTrajectory>,
    ) -> ViewRecord {
        let turntable_angle_deg = self.turntable_angle_deg(&view.world_from_camera);
        ViewRecord { turntable_angle_deg, ..ViewRecord::new(view, trajectory, joints) }
    }

    /// The views to take after a [requested](Self::next) one if nothing were learned on the way, in the order
    /// of a short tour: at most `n_views`; see [`Session::legs_after`]. For planning ahead, or for taking
    /// several frames at once: they are [observed](Self::observe) like frames from any pose, and count no
    /// more than those towards the [number of views](ScanConfig::views). With a robot, the trajectories are
    /// those of the camera alone.
    ///
    /// [`Session::legs_after`]: nextview::session::Session::legs_after
    pub fn following(&self, view: &NextView, n_views: usize) -> Result<Vec<ViewRecord>, Fault> {
        let session = &self.scan().session;
        let mut from = view.world_from_camera;
        let record = |leg: Leg| {
            let world_from_camera = session.views().pose(leg.choice.view);
            let trajectory = session.trajectory(&from, &world_from_camera)?;
            from = world_from_camera;
            let (view, choice) = (Some(leg.choice.view), Some(leg.choice));
            let record = self.completed(
                &NextView { view, world_from_camera, choice, outlook: None },
                &trajectory,
                None,
            );
            Ok(ViewRecord { expected_new_voxels: Some(leg.expected), ..record })
        };
        session.legs_after(view, n_views)?.into_iter().map(record).collect()
    }

    /// The motion of the robot to a requested view; `None` if there is no robot.
    pub fn joints_to(&self, view: &NextView) -> Option<&JointTrajectory> {
        self.run.joints_to(view)
    }

    /// The angle of the [turntable](crate::TurntableConfig) for a view in degrees, 0 to 360; `None` if there
    /// is no turntable.
    pub fn turntable_angle_deg(&self, world_from_camera: &Pose) -> Option<f64> {
        self.config.turntable.map(|turntable| turntable.angle_deg(world_from_camera))
    }

    /// The pose of the camera relative to the object with the turntable at this angle. Fails without a
    /// turntable.
    pub fn turntable_pose(&self, angle_deg: f64) -> Result<Pose, Fault> {
        let none =
            || Fault { key: Some("turntable".to_owned()), ..Fault::request("there is no `turntable`") };
        self.config.turntable.ok_or_else(none)?.pose_at(angle_deg)
    }

    /// The scan in its current state: map, model, record.
    pub fn scan(&self) -> &ScanState<'static> {
        self.run.scan()
    }

    /// The reason why the scan ended; `None` while it is in progress.
    pub fn stop_reason(&self) -> Option<StopReason> {
        self.scan().stop_reason
    }

    /// The configuration, completed by the decisions made at the beginning.
    pub fn config(&self) -> &ScanConfig {
        &self.config
    }

    /// The camera.
    pub fn camera(&self) -> &OwnCamera {
        &self.camera
    }

    /// The flag that cancels all computations of the scan.
    pub fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// Ends the scan, unless it is already over for another [reason](Self::stop_reason).
    pub fn end(&mut self) {
        self.run.scan_mut().stop_reason.get_or_insert(StopReason::Ended);
    }

    /// Adds the results of the scan in its current state; see [`write_results`].
    pub fn write_results(&self, folder: &mut ResultFolder) -> Result<Results, Fault> {
        write_results(folder, &self.config, self.scan())
    }

    /// Removes the journal: the results are on the disk, or there will be none. No more frames are
    /// [observed](Self::observe).
    pub fn forget_journal(&mut self) {
        self.is_closed = true;
        self.run.scan_mut().forget_journal();
    }
}
