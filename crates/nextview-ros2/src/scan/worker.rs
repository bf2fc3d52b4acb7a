use super::picture::outputs;
use crate::camera::PosedImage;
use crate::connections::OutgoingMessage;
use crate::messages::TriggerResponse;
use crate::notes::say;
use crate::parameters::Parameters;
use nextview::Cancel;
use nextview::geometry::Pose;
use nextview::planner::Outlook;
use nextview::sensor::Intrinsics;
use nextview::session::StopReason;
use nextview_scan::files::Overwrite;
use nextview_scan::{Fault, Faults, LiveFrame, LiveScan, ScanJournal, begin_results};
use serde::Serialize;
use std::sync::mpsc;
use tokio::sync::mpsc::UnboundedSender;

/// A job for the scan, and who waits for the answer.
pub struct Order<T> {
    pub job: Job,
    pub askers: Vec<T>,
}

pub enum Job {
    /// Resumes the interrupted scan of the folder, if there is one.
    Resume,
    /// Starts with this camera, or resumes if the interrupted scan used the same camera.
    Begin(Intrinsics),
    Observe(Box<PosedImage>),
    Plan,
    Skip,
    Save,
    /// Starts a new scan with this camera.
    Reset(Intrinsics),
}

/// The messages of the thread.
pub enum WorkerReport<T> {
    /// Messages to publish.
    Outputs(Vec<OutgoingMessage>),
    State(State),
    /// A finished order.
    Done {
        askers: Vec<T>,
        answer: TriggerResponse,
    },
}

/// The state of the scan.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct State {
    pub state: ScanStage,
    /// Number of frames taken.
    pub frames: usize,
    /// Number of the next view among the candidates; `None` if it is no candidate, or if there is none.
    pub view: Option<usize>,
    /// Estimated share of the visible surface seen so far.
    pub estimated_completeness: Option<f64>,
    /// Estimated completeness after the next view and each expected later view.
    pub forecast_completeness: Option<Vec<f64>>,
    pub stop_reason: Option<StopReason>,
    /// The wanted pose of the camera.
    #[serde(skip)]
    pub wanted: Option<Pose>,
}

/// The stage, in the words of the status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScanStage {
    /// No camera_info has arrived.
    #[default]
    WaitingForCamera,
    /// The next view is known.
    View,
    /// The scan is over.
    Finished,
}

/// Starts the thread. Orders are processed one after the other, in order of arrival.
pub fn start<T: Send + 'static>(
    parameters: Parameters,
    reports: UnboundedSender<WorkerReport<T>>,
) -> mpsc::Sender<Order<T>> {
    let (sender, orders) = mpsc::channel();
    std::thread::spawn(move || {
        let mut worker = Worker { parameters, scan: None, is_saved: false };
        for Order { job, askers } in orders {
            let answer = worker.tell(&reports, job);
            // If nobody listens, the node has ended.
            let _ = reports.send(WorkerReport::Done { askers, answer });
        }
    });
    sender
}

struct Worker {
    parameters: Parameters,
    scan: Option<LiveScan>,
    /// Whether the results of the finished scan are on the disk.
    is_saved: bool,
}

impl Worker {
    /// Does a job, and reports its visible results.
    fn tell<T>(&mut self, reports: &UnboundedSender<WorkerReport<T>>, job: Job) -> TriggerResponse {
        match self.work(job).and_then(|has_changed| self.show(has_changed)) {
            Ok((outputs, state)) => {
                // Numbers and names can always be serialized.
                let message = serde_json::to_string(&state).unwrap_or_default();
                let _ = reports.send(WorkerReport::Outputs(outputs));
                let _ = reports.send(WorkerReport::State(state));
                TriggerResponse { success: true, message }
            }
            Err(faults) => TriggerResponse { success: false, message: told(&faults) },
        }
    }

    /// Does a job; returns whether any visible state has changed.
    fn work(&mut self, job: Job) -> Result<bool, Faults> {
        match job {
            Job::Resume => self.resume(),
            Job::Begin(camera) => self.begin_or_check(camera),
            Job::Observe(taken) => {
                let PosedImage { header, depth, intrinsics, world_from_camera } = *taken;
                self.begin_or_check(intrinsics)?;
                let name = format!("{}.{:09}", header.stamp.sec, header.stamp.nanosec);
                let frame = LiveFrame { name: Some(name), ..LiveFrame::new(depth, world_from_camera) };
                self.under_way()?.observe(frame)?;
                Ok(true)
            }
            Job::Plan => self.under_way().map(|_| true),
            Job::Skip => {
                let scan = self.under_way()?;
                match scan.next()?.map(|next| next.view) {
                    Some(Some(view)) => scan.skip(view, "the robot cannot go there")?,
                    Some(None) => {
                        let fault = Fault::request("the first view is not a candidate and cannot be skipped");
                        return Err(fault
                            .with_remedy("take an image from anywhere that shows the object")
                            .into());
                    }
                    None => return Err(Fault::request("the scan is over: there is no view to skip").into()),
                }
                Ok(true)
            }
            Job::Save => self.save().map(|()| false),
            Job::Reset(camera) => {
                if let Some(mut scan) = self.scan.take() {
                    scan.forget_journal();
                }
                self.begin(camera)
            }
        }
    }

    /// Begins the scan, unless it is in progress with this camera.
    fn begin_or_check(&mut self, camera: Intrinsics) -> Result<bool, Faults> {
        match &self.scan {
            None => self.begin(camera),
            Some(scan) if scan.config().camera == camera => Ok(false),
            Some(_) => {
                let fault = Fault::data(
                    "camera_info differs from that of the scan, whose images must be of one camera",
                );
                Err(fault.with_remedy("`~/reset` starts a new scan with this camera").into())
            }
        }
    }

    fn begin(&mut self, camera: Intrinsics) -> Result<bool, Faults> {
        let config = self.parameters.scan_config(camera)?;
        let directory = self.parameters.directory.as_deref();
        self.scan = Some(LiveScan::begin(config, directory, Cancel::default())?);
        self.is_saved = false;
        Ok(true)
    }

    fn resume(&mut self) -> Result<bool, Faults> {
        let Some(directory) = self.parameters.directory.as_deref() else { return Ok(false) };
        if !ScanJournal::is_in(directory) {
            return Ok(false);
        }
        let scan = LiveScan::resume(directory, Cancel::default())?;
        if let Some(damage) = scan.damage() {
            say(&directory.join(ScanJournal::FILE).display().to_string(), &damage.to_string());
        }
        self.scan = Some(scan);
        Ok(true)
    }

    fn under_way(&mut self) -> Result<&mut LiveScan, Faults> {
        self.scan.as_mut().ok_or_else(|| {
            let fault = Fault::request("there is no scan yet, because no camera_info has arrived");
            fault.with_remedy("remap depth/camera_info to the topic of the camera").into()
        })
    }

    /// Plans if needed, and saves a scan that is over.
    fn show(&mut self, has_changed: bool) -> Result<(Vec<OutgoingMessage>, State), Faults> {
        let Some(scan) = &mut self.scan else { return Ok((Vec::new(), State::default())) };
        let next = scan.next()?;
        let outlook = next.as_ref().and_then(|next| next.outlook.as_ref());
        let state = State {
            state: if next.is_some() { ScanStage::View } else { ScanStage::Finished },
            frames: scan.scan().steps.len(),
            view: next.as_ref().and_then(|next| next.view),
            estimated_completeness: outlook.map(Outlook::completeness),
            forecast_completeness: outlook.map(Outlook::forecast),
            stop_reason: scan.stop_reason(),
            wanted: next.as_ref().map(|next| next.world_from_camera),
        };
        let seen = match has_changed {
            true => outputs(scan, next.as_ref(), &self.parameters.global_frame)?,
            false => Vec::new(),
        };
        if next.is_none() && self.parameters.directory.is_some() && !self.is_saved {
            self.save()?;
            self.is_saved = true;
        }
        Ok((seen, state))
    }

    /// Writes the results. Those of a finished scan are final: its journal is removed.
    fn save(&mut self) -> Result<(), Faults> {
        let Some(directory) = self.parameters.directory.clone() else {
            let fault = Fault::request("no folder is set to save in");
            return Err(fault.with_remedy("set the parameter `directory`").into());
        };
        let scan = self.under_way()?;
        let mut folder = begin_results(&directory, Overwrite::results())?;
        let faults = scan.write_results(&mut folder)?.faults;
        folder.publish()?;
        if scan.stop_reason().is_some() {
            scan.forget_journal();
        }
        faults.map_or(Ok(()), Err)
    }
}

/// All faults in one line, with their remedies.
fn told(faults: &Faults) -> String {
    let fault = |fault: &Fault| match &fault.remedy {
        Some(remedy) => format!("{fault}: {remedy}"),
        None => fault.to_string(),
    };
    faults.iter().map(fault).collect::<Vec<_>>().join("; ")
}
