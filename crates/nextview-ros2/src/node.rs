//! The main loop of the node: messages in, orders to the scan, messages out.

use crate::camera::Camera;
use crate::connections::{Connector, Inputs, Message, OutgoingMessage, Outputs, Service, Services, join};
use crate::messages::{Text, TriggerResponse};
use crate::names::Names;
use crate::notes::{Notes, say};
use crate::parameters::Parameters;
use crate::scan::{Job, Order, State, WorkerReport, start};
use crate::status;
use futures_util::StreamExt;
use nextview::sensor::Intrinsics;
use ros2_client::RmwRequestId;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::unbounded_channel;

/// Interval between checks for an image's pose, and for a camera at rest.
const TICK: Duration = Duration::from_millis(20);

/// Maximum interval between status messages.
const STATUS: Duration = Duration::from_secs(1);

/// Maximum number of waiting orders: further requests are refused.
const MAX_ORDERS: usize = 8;

/// A request waiting for an answer.
type Ticket = (Service, RmwRequestId);

/// Runs the node until it is stopped by a signal.
pub fn run(names: &Names, parameters: Parameters) -> Result<(), String> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.map_err(|error| format!("cannot start: {error}"))?.block_on(spin(names, parameters))
}

async fn spin(names: &Names, parameters: Parameters) -> Result<(), String> {
    let mut ros = join(names)?;
    let mut connector = Connector { node: &mut ros, names };
    let inputs = Inputs::connect(&mut connector, parameters.use_tf_transforms)?;
    let outputs = Outputs::connect(&mut connector)?;
    let services = Services::connect(&mut connector)?;
    let spinner = ros.spinner().map_err(|error| format!("cannot watch the network: {error:?}"))?;
    tokio::spawn(spinner.spin());

    let (reporter, mut reports) = unbounded_channel();
    let mut node = Node {
        orders: start(parameters.clone(), reporter),
        camera: Camera::new(&parameters),
        parameters,
        notes: Notes::default(),
        state: State::default(),
        begun_with: None,
        n_orders: 0,
        askers: Vec::new(),
    };
    node.order(Job::Resume, Vec::new());
    say(&names.full(), "is ready");
    let (mut messages, mut requests) = (inputs.messages(), services.requests());
    let mut tick = tokio::time::interval(TICK);
    tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    let (mut told, mut told_at) = (None, Instant::now());
    let mut stop = std::pin::pin!(stopped());
    loop {
        let mut answers = Vec::new();
        let mut seen = Vec::new();
        tokio::select! {
            () = &mut stop => return Ok(()),
            Some(ticket) = requests.next() => answers.extend(node.ask(ticket)),
            Some(message) = messages.next() => node.take(message),
            report = reports.recv() => match report {
                None => return Err("the scan has failed with an internal error; its frames are kept".to_owned()),
                Some(WorkerReport::Outputs(outputs)) => seen = outputs,
                Some(WorkerReport::State(state)) => node.state = state,
                Some(WorkerReport::Done { askers, answer }) => answers.extend(node.done(askers, &answer)),
            },
            _ = tick.tick() => {
                answers.extend(node.tick());
                let status = node.status(0);
                if told.as_ref() != Some(&status) || told_at.elapsed() >= STATUS {
                    seen.push(OutgoingMessage::Status(node.status(node.camera.n_images)));
                    (told, told_at) = (Some(status), Instant::now());
                }
            }
        }
        for output in seen {
            if let Err(problem) = outputs.publish(output) {
                node.notes.add("publishing", problem);
            }
        }
        for ((service, id), answer) in answers {
            services.answer(service, id, answer);
        }
    }
}

/// Returns on a signal to terminate.
async fn stopped() {
    let terminated = async {
        #[cfg(unix)]
        match tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate()) {
            Ok(mut signal) => _ = signal.recv().await,
            Err(_) => std::future::pending().await,
        }
        #[cfg(not(unix))]
        std::future::pending::<()>().await;
    };
    tokio::select! {
        _ = tokio::signal::ctrl_c() => (),
        () = terminated => (),
    }
}

struct Node {
    orders: Sender<Order<Ticket>>,
    camera: Camera,
    parameters: Parameters,
    notes: Notes,
    state: State,
    /// The camera with which the scan was begun.
    begun_with: Option<Intrinsics>,
    /// Number of unfinished orders.
    n_orders: usize,
    /// The requests for the image being taken.
    askers: Vec<Ticket>,
}

impl Node {
    /// Handles a service request; answers immediately if that takes no time.
    fn ask(&mut self, (service, id): Ticket) -> Option<(Ticket, TriggerResponse)> {
        let ticket = (service, id);
        let refused =
            |message: &str| Some((ticket, TriggerResponse { success: false, message: message.to_owned() }));
        if self.n_orders >= MAX_ORDERS || self.askers.len() >= MAX_ORDERS {
            return refused("too many requests are waiting: try again later");
        }
        let job = match (service, self.camera.intrinsics) {
            (Service::CaptureRequest, _) => {
                self.askers.push(ticket);
                if !self.camera.is_capturing() {
                    self.camera.capture(self.parameters.capture_timeout);
                }
                return None;
            }
            (Service::Plan, _) => Job::Plan,
            (Service::Skip, _) => Job::Skip,
            (Service::Save, _) => Job::Save,
            (Service::Reset, Some(camera)) => Job::Reset(camera),
            (Service::Reset, None) => {
                return refused("no camera_info has arrived, expected it on depth/camera_info");
            }
        };
        self.order(job, vec![ticket]);
        None
    }

    fn order(&mut self, job: Job, askers: Vec<Ticket>) {
        self.n_orders += 1;
        // If the thread has ended, the reports end, and with them the node.
        let _ = self.orders.send(Order { job, askers });
    }

    fn take(&mut self, message: Message) {
        self.camera.take(message, &mut self.notes);
        if let Some(camera) = self.camera.intrinsics
            && self.begun_with != Some(camera)
        {
            self.begun_with = Some(camera);
            self.order(Job::Begin(camera), Vec::new());
        }
    }

    /// Performs periodic work.
    fn tick(&mut self) -> Vec<(Ticket, TriggerResponse)> {
        let Parameters { auto_capture, capture_distance, capture_angle, capture_timeout, .. } =
            self.parameters;
        if auto_capture
            && self.n_orders == 0
            && !self.camera.is_capturing()
            && let Some(wanted) = self.state.wanted
            && self.camera.rests_near(&wanted, capture_distance, capture_angle)
        {
            self.camera.capture(capture_timeout);
        }
        match self.camera.taken() {
            None => Vec::new(),
            Some(Ok(taken)) => {
                self.notes.clear("~/capture");
                let askers = std::mem::take(&mut self.askers);
                self.order(Job::Observe(Box::new(taken)), askers);
                Vec::new()
            }
            Some(Err(why)) => {
                self.notes.add("~/capture", why.clone());
                let response = TriggerResponse { success: false, message: why };
                self.askers.drain(..).map(|ticket| (ticket, response.clone())).collect()
            }
        }
    }

    /// Handles a finished order: a failure without a request becomes a problem.
    fn done(
        &mut self,
        askers: Vec<Ticket>,
        answer: &TriggerResponse,
    ) -> impl Iterator<Item = (Ticket, TriggerResponse)> {
        self.n_orders -= 1;
        if answer.success {
            self.notes.clear("scan");
        } else if askers.is_empty() {
            self.notes.add("scan", answer.message.clone());
        }
        askers.into_iter().map(|ticket| (ticket, answer.clone()))
    }

    fn status(&self, n_images: u64) -> Text {
        let problems = self.notes.problems();
        status::message(&self.state, self.n_orders, self.camera.is_capturing(), n_images, problems)
    }
}
