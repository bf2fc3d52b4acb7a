use super::ScanState;
use super::arm::{ArmMove, ScanArm};
use super::scan_facts::ScanFacts;
use super::warning::{POSES_AS_GIVEN, poses_are_wrong, warning};
use crate::earlier_scan::EarlierScan;
use crate::journal::{JournalEntry, KeptFrame, SkippedView};
use crate::record::milliseconds;
use crate::{
    Captured, Fault, FaultKind, Faults, FrameSource, FrameTruth, ScanConfig, ScanJournal, StepRecord,
    TurntableConfig,
};
use glam::DVec3;
use nextview::motion::Trajectory;
use nextview::sensor::{ColorImage, Frame};
use nextview::session::{Decision, NextView, Session, StopReason};
use nextview::{Cancel, Cancelled};
use nextview_robot::path::JointTrajectory;
use std::time::{Duration, Instant};

/// Number of frames that are checked for wrong poses and units.
const MOST_SUSPECTED: usize = 8;

/// A scan in progress. It never blocks: the owner of the camera requests the [`next`](Self::next) step, takes
/// the picture, and [`push`](Self::push)es it.
///
/// With a [journal](Self::with_journal), every frame is on the disk before it counts. After an interruption,
/// the journal replays its frames before any capture is requested.
///
/// ```
/// use glam::DVec3;
/// use nextview::geometry::Aabb;
/// use nextview::planner::RandomViews;
/// use nextview::sensor::{DepthImage, Frame, Intrinsics};
/// use nextview::session::{Session, SessionConfig};
/// use nextview::view::generate;
/// use nextview_scan::{Next, ScanRun};
///
/// let camera = Intrinsics::d435i();
/// let config = SessionConfig::new(0.01, Aabb::cube(DVec3::ZERO, 0.1));
/// let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 50)?;
/// let session = Session::new(config, camera, views, Box::new(RandomViews { seed: 1 }))?;
/// let mut run = ScanRun::new(session);
/// loop {
///     match run.next()? {
///         Next::Replay(frame) => _ = run.push(frame)?,
///         Next::Capture(view) => {
///             let image = DepthImage::from_metres(640, 480, vec![f32::INFINITY; camera.n_pixels()])?;
///             run.push(Frame::new(image, camera, view.world_from_camera, 1.0)?)?;
///         }
///         Next::Stop(_) => break,
///     }
/// }
/// assert_eq!(run.steps().len(), 10);
/// # Ok::<(), nextview_scan::Fault>(())
/// ```
pub struct ScanRun<'a> {
    scan: ScanState<'a>,
    /// Counted from the first decision.
    time_limit: Option<Duration>,
    /// Time of the first request for a decision.
    began: Option<Instant>,
    asked: Option<Asked>,
    path: PathLength,
    turntable: Option<TurntableConfig>,
    arm: Option<ScanArm>,
}

/// The next step of a run.
#[derive(Clone, Debug)]
pub enum Next {
    /// Push this frame, taken before an interruption, unchanged.
    Replay(Frame),
    /// Take a frame from this view, or from another pose, and push it.
    Capture(NextView),
    /// The scan is over. After [`StopReason::NoObject`] or [`StopReason::Cancelled`] it can continue.
    Stop(StopReason),
}

/// How to begin a run.
#[derive(Default)]
pub struct RunOptions {
    /// The journal for its frames; `None` to keep them in memory only.
    pub journal: Option<ScanJournal>,
    /// Flag that cancels long computations.
    pub cancel: Cancel,
}

/// A frame with its optional colours and name.
#[derive(Clone, Debug)]
pub struct TakenFrame {
    /// The depth image and its pose.
    pub frame: Frame,
    /// A colour image of the frame's size, used by the final model.
    pub color: Option<ColorImage>,
    /// A name for its record.
    pub name: Option<String>,
}

impl From<Frame> for TakenFrame {
    fn from(frame: Frame) -> Self {
        Self { frame, color: None, name: None }
    }
}

/// A requested view.
struct Asked {
    next: NextView,
    trajectory: Trajectory,
    /// Motion of the robot along that trajectory of the camera.
    joints: Option<JointTrajectory>,
    plan_time: Duration,
    since: Instant,
}

impl<'a> ScanRun<'a> {
    /// Creates a run of this session with a user's camera.
    pub fn new(session: Session) -> Self {
        let scan = ScanState::new(session);
        let path = PathLength::default();
        let (turntable, arm) = (None, None);
        Self { scan, time_limit: None, began: None, asked: None, path, turntable, arm }
    }

    /// Begins the configured run with frames from this source.
    pub fn begin(
        source: &'a dyn FrameSource,
        config: &ScanConfig,
        options: RunOptions,
    ) -> Result<Self, Faults> {
        let mut run = Self::of_session(source.session(config)?, config, options)?;
        run.scan.source = Some(source);
        run.scan.evaluator = Some(source.evaluator(config));
        Ok(run)
    }

    /// The run of this session with a user's camera and the configured time limit.
    pub(crate) fn of_session(
        session: Session,
        config: &ScanConfig,
        options: RunOptions,
    ) -> Result<Self, Fault> {
        let earlier =
            config.after.as_deref().map(|dir| EarlierScan::open(dir, &options.cancel)).transpose()?;
        let session = match &earlier {
            Some(earlier) => session.after(earlier.shown.clone()),
            None => session,
        };
        let mut run = Self::new(session.with_cancel(options.cancel));
        run.scan.earlier = earlier;
        run.time_limit = config.time_limit_s.map(Duration::try_from_secs_f64).and_then(Result::ok);
        run.scan.journal = options.journal;
        run.scan.facts = ScanFacts::of(config);
        run.turntable = config.turntable;
        run.arm = config.robot.as_ref().map(ScanArm::of_config).transpose()?;
        Ok(run)
    }

    /// Sets the journal that keeps every frame.
    pub fn with_journal(mut self, journal: ScanJournal) -> Self {
        self.scan.journal = Some(journal);
        self
    }

    /// Returns the next step. Repeated calls return the same step until a frame is pushed or a view skipped.
    ///
    /// Fails if the scan decides otherwise than before its interruption.
    #[expect(clippy::should_implement_trait, reason = "an iterator could be neither asked again nor fail")]
    pub fn next(&mut self) -> Result<Next, Fault> {
        let began = *self.began.get_or_insert_with(Instant::now);
        loop {
            match self.replay() {
                Some(JournalEntry::Frame(kept)) if !kept.was_asked => {
                    return Ok(Next::Replay(kept.frame.clone()));
                }
                Some(JournalEntry::Skip(skipped)) if skipped.was_decided == self.asked.is_some() => {
                    let view = skipped.view;
                    self.forget(view);
                    self.scan.journal.as_mut().map(ScanJournal::replayed);
                    continue;
                }
                _ => (),
            }
            if self.asked.is_none() {
                let is_over = self.time_limit.is_some_and(|limit| began.elapsed() >= limit);
                if is_over && !self.scan.steps.is_empty() && self.replay().is_none() {
                    return Ok(Next::Stop(StopReason::TimeLimit));
                }
                if let Some(reason) = self.decide()? {
                    return self.check_stop(reason).map(|()| Next::Stop(reason));
                }
            }
            let Some(asked) = &self.asked else { continue };
            match self.replay() {
                None => return Ok(Next::Capture(asked.next.clone())),
                Some(JournalEntry::Frame(kept)) => {
                    self.check_replay(kept, &asked.next)?;
                    return Ok(Next::Replay(kept.frame.clone()));
                }
                Some(JournalEntry::Skip(_)) => (),
            }
        }
    }

    /// Keeps, maps and evaluates a frame in any pose. The requested view, if any, counts as visited. A
    /// [replayed](Next::Replay) frame has the colours and the name kept with it.
    ///
    /// Fails before any change if the frame cannot be kept, or if [cancelled](RunOptions::cancel): the frame
    /// is then requested again, or [replayed](Next::Replay) from the journal.
    pub fn push(&mut self, taken: impl Into<TakenFrame>) -> Result<&StepRecord, Fault> {
        self.add(taken.into(), None)
    }

    /// Pushes a frame with the truth about it, if known.
    fn add(&mut self, taken: TakenFrame, truth: Option<FrameTruth>) -> Result<&StepRecord, Fault> {
        check_size(&taken.frame, taken.color.as_ref())?;
        let capture_time = self.asked.as_ref().map_or(Duration::ZERO, |asked| asked.since.elapsed());
        let trajectory = match &self.asked {
            Some(asked) => asked.trajectory.clone(),
            None => self.scan.session.trajectory_to(&taken.frame.world_from_camera())?,
        };
        let TakenFrame { frame, color, name } = self.keep(taken)?;
        let claimed = frame.world_from_camera();
        let start = Instant::now();
        let report = match self.scan.session.observe(&frame) {
            Ok(report) => report,
            Err(cancelled) => {
                return Err(self.put_back(TakenFrame { frame, color, name }, cancelled));
            }
        };
        let map_time = start.elapsed();
        let asked = self.asked.take();
        let joints = asked.as_ref().and_then(|asked| asked.joints.clone());
        let (next, plan_time) = asked.map(|asked| (asked.next, asked.plan_time)).unzip();
        let mut record = StepRecord::of_report(self.scan.steps.len() + 1, &report);
        if let Some(evaluator) = &mut self.scan.evaluator {
            let captured = Captured { frame: frame.with_pose(report.world_from_camera), truth };
            evaluator.measure(&self.scan.session, next.as_ref(), captured, &mut record)?;
        }
        let last = self.scan.steps.last();
        record.frame = name.or(record.frame);
        record.path_length_m = self.path.extend_to(report.world_from_camera.translation());
        record.trajectory_length_m = last.map_or(0.0, |last| last.trajectory_length_m) + trajectory.length();
        record.trajectory_time_s = last.map_or(0.0, |last| last.trajectory_time_s) + trajectory.duration();
        let place = report.world_from_camera;
        record.turntable_angle_deg = self.turntable.map(|turntable| turntable.angle_deg(&place));
        record.plan_time_ms = milliseconds(plan_time.unwrap_or_default());
        record.map_time_ms = milliseconds(map_time);
        record.capture_time_ms = milliseconds(capture_time);
        let as_given = report.is_as_given.then(|| POSES_AS_GIVEN.to_owned());
        record.warning = self.warning().or(as_given).or(report.apart.map(poses_are_wrong));
        if let Some(arm) = &mut self.arm {
            arm.arrive(joints.as_ref(), &claimed);
            record.joint_values = arm.values().map(<[f64]>::to_vec);
        }
        self.scan.requested.push(next);
        self.scan.trajectories.push(trajectory);
        self.scan.joint_trajectories.push(joints);
        self.scan.colors.push(color);
        self.scan.steps.push(record);
        Ok(self.scan.steps.last().expect("a step was added"))
    }

    /// Skips a candidate: it is never proposed again. The reason is kept in the journal.
    pub fn skip(&mut self, view: usize, reason: &str) -> Result<(), Fault> {
        if view >= self.scan.session.views().len() {
            let expected = format!("0 to {}", self.scan.session.views().len().saturating_sub(1));
            return Err(Fault::of_value("view", view, expected));
        }
        if self.replay().is_some() {
            return Err(Fault::request(
                "the frames from before the interruption must be replayed before a view is skipped",
            ));
        }
        let skipped = SkippedView { view, reason: reason.to_owned(), was_decided: self.asked.is_some() };
        self.scan.journal.as_mut().map_or(Ok(()), |journal| journal.skip(&skipped))?;
        self.forget(view);
        Ok(())
    }

    /// Captures from the run's source until the scan stops, and reports every step.
    ///
    /// Fails if the run was not begun with a source.
    pub fn drive(
        &mut self,
        mut on_step: impl FnMut(&StepRecord) -> Result<(), Fault>,
    ) -> Result<StopReason, Fault> {
        let source = self.scan.source.ok_or_else(|| Fault::request("the run has no source of frames"))?;
        loop {
            let Captured { frame, truth } = match self.next()? {
                Next::Replay(frame) => Captured { frame, truth: None },
                Next::Capture(view) => source.capture(&view, self.scan.steps.is_empty())?,
                Next::Stop(reason) => return Ok(reason),
            };
            match self.add(frame.into(), truth) {
                Ok(step) => on_step(step)?,
                Err(fault) if fault.kind == FaultKind::Cancelled => return Ok(StopReason::Cancelled),
                Err(fault) => return Err(fault),
            }
        }
    }

    /// The views so far.
    pub fn steps(&self) -> &[StepRecord] {
        &self.scan.steps
    }

    /// The scan in progress: its map, frames and candidates.
    pub fn session(&self) -> &Session {
        &self.scan.session
    }

    /// Returns the state of the run, ended for this reason; `None` to inspect it in progress.
    pub fn finish(self, stop_reason: Option<StopReason>) -> ScanState<'a> {
        ScanState { stop_reason, ..self.scan }
    }

    /// The scan in its current state: its model and its record so far.
    pub fn scan(&self) -> &ScanState<'a> {
        &self.scan
    }

    /// Mutable access, to set the stop reason and to forget the journal.
    pub(crate) fn scan_mut(&mut self) -> &mut ScanState<'a> {
        &mut self.scan
    }

    /// The suspected fault of the frames so far; `None` if already reported, or if there are too many frames
    /// to find a new one.
    fn warning(&self) -> Option<String> {
        let suspicion =
            (self.scan.steps.len() < MOST_SUSPECTED).then(|| self.scan.session.suspicion()).flatten()?;
        let warning = warning(&suspicion, &self.scan.facts);
        self.scan.steps.iter().all(|step| step.warning.as_ref() != Some(&warning)).then_some(warning)
    }

    fn replay(&self) -> Option<&JournalEntry> {
        self.scan.journal.as_ref().and_then(ScanJournal::replay)
    }

    /// Decides on the next view, or returns the reason if the scan stops. With a robot, only candidates that
    /// it can reach are considered; one without a path is given up until the next frame.
    fn decide(&mut self) -> Result<Option<StopReason>, Fault> {
        let start = Instant::now();
        loop {
            let session = &mut self.scan.session;
            if let Some(arm) = &mut self.arm {
                let times = arm.times(session)?;
                session.set_approaches(times);
            }
            let next = match session.decide()? {
                Decision::Stop(reason) => return Ok(Some(reason)),
                Decision::Move(next) => next,
            };
            let ArmMove { trajectory, joints } = match &mut self.arm {
                None => ArmMove { trajectory: session.trajectory_to(&next.world_from_camera)?, joints: None },
                Some(arm) => match arm.way_to(&next, session)? {
                    Some(way) => way,
                    None => continue,
                },
            };
            let plan_time = start.elapsed();
            self.asked = Some(Asked { next, trajectory, joints, plan_time, since: Instant::now() });
            return Ok(None);
        }
    }

    /// The trajectory to a view: that of the robot for a requested view.
    pub(crate) fn trajectory_to(&self, view: &NextView) -> Result<Trajectory, Fault> {
        match self.asked.as_ref().filter(|asked| asked.next == *view) {
            Some(asked) => Ok(asked.trajectory.clone()),
            None => Ok(self.scan.session.trajectory_to(&view.world_from_camera)?),
        }
    }

    /// The motion of the robot to a requested view; `None` if there is no robot.
    pub(crate) fn joints_to(&self, view: &NextView) -> Option<&JointTrajectory> {
        self.asked.as_ref().filter(|asked| asked.next == *view)?.joints.as_ref()
    }

    /// Returns the frame and its colours, once they are on the disk; during a replay, those of the journal.
    fn keep(&mut self, taken: TakenFrame) -> Result<TakenFrame, Fault> {
        let (view, was_asked) = (self.asked.as_ref().and_then(|asked| asked.next.view), self.asked.is_some());
        let Some(journal) = &mut self.scan.journal else { return Ok(taken) };
        match journal.replay() {
            None => {
                let TakenFrame { frame, color, name } = taken;
                let kept = KeptFrame { view, was_asked, frame, color, name };
                journal.keep(&kept)?;
                Ok(TakenFrame { frame: kept.frame, color: kept.color, name: kept.name })
            }
            Some(JournalEntry::Frame(kept))
                if kept.was_asked == was_asked && is_same_place(&kept.frame, &taken.frame) =>
            {
                let (color, name) = (kept.color.clone(), kept.name.clone());
                journal.replayed();
                Ok(TakenFrame { frame: taken.frame, color, name })
            }
            Some(_) => {
                let fault = Fault::request("the pushed frame is not the frame to be replayed");
                Err(fault.with_remedy("ask for the next step, and push the frame that it returns unchanged"))
            }
        }
    }

    /// Queues the frame again, since it does not count.
    fn put_back(&mut self, taken: TakenFrame, cancelled: Cancelled) -> Fault {
        let TakenFrame { frame, color, name } = taken;
        let (view, was_asked) = (self.asked.as_ref().and_then(|asked| asked.next.view), self.asked.is_some());
        if let Some(journal) = &mut self.scan.journal {
            journal.replay_again(KeptFrame { view, was_asked, frame, color, name });
        }
        cancelled.into()
    }

    fn forget(&mut self, view: usize) {
        self.scan.session.skip(view);
        self.asked = None;
    }

    /// Fails if the frame does not belong to the current decision.
    fn check_replay(&self, kept: &KeptFrame, next: &NextView) -> Result<(), Fault> {
        let name =
            |view: Option<usize>| view.map_or("no candidate".to_owned(), |view| format!("view {view}"));
        if kept.view == next.view {
            return Ok(());
        }
        Err(self.differs(&name(kept.view), &format!("the planner now chooses {}", name(next.view))))
    }

    /// Fails if the scan stops although it continued before its interruption.
    fn check_stop(&self, reason: StopReason) -> Result<(), Fault> {
        match self.replay() {
            Some(_) if reason != StopReason::Cancelled => {
                Err(self.differs("another view", "the scan now stops"))
            }
            _ => Ok(()),
        }
    }

    fn differs(&self, was: &str, is: &str) -> Fault {
        let n = self.scan.steps.len() + 1;
        let fault = Fault::data(format!("frame {n} was taken from {was}, but {is}"));
        let fault =
            self.scan.journal.as_ref().map(|journal| fault.clone().in_file(&journal.path())).unwrap_or(fault);
        fault
            .with_remedy("resume a scan with the version of nextview and the files with which it was started")
    }
}

/// Fails if the images of a frame are of different sizes.
fn check_size(frame: &Frame, color: Option<&ColorImage>) -> Result<(), Fault> {
    let size = |width, height| format!("{width} x {height}");
    let depth = size(frame.image().width(), frame.image().height());
    match color.map(|color| size(color.width(), color.height())).filter(|color| *color != depth) {
        Some(color) => {
            Err(Fault::of_value("color", color, format!("{depth} pixels, as the depth image has")))
        }
        None => Ok(()),
    }
}

/// Compares without depths: a missing one equals nothing, not even itself.
fn is_same_place(a: &Frame, b: &Frame) -> bool {
    a.world_from_camera() == b.world_from_camera() && a.intrinsics() == b.intrinsics()
}

/// The length of a growing path.
#[derive(Default)]
struct PathLength {
    length: f64,
    end: Option<DVec3>,
}

impl PathLength {
    fn extend_to(&mut self, position: DVec3) -> f64 {
        self.length += self.end.map_or(0.0, |end| end.distance(position));
        self.end = Some(position);
        self.length
    }
}
