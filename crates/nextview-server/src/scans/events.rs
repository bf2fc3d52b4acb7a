use serde::Serialize;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// Number of events kept for listeners that reconnect.
const KEPT: usize = 1000;

/// Events of a scan since the server began to work on it.
pub(crate) struct Events {
    /// Distinguishes the events of this process from those of an earlier one.
    run: String,
    kept: Mutex<VecDeque<Told>>,
    /// Number of events so far.
    n_told: watch::Sender<u64>,
    /// Pose of the camera. It is only sent to current listeners, because it is soon outdated.
    passing: watch::Sender<Option<Passing>>,
}

/// An event that is not kept.
#[derive(Clone, Debug)]
struct Passing {
    name: &'static str,
    data: String,
}

/// A kept event.
#[derive(Clone, Debug)]
pub(crate) struct Told {
    /// Counted from 1.
    pub number: u64,
    pub name: &'static str,
    /// Payload as JSON.
    pub data: String,
}

impl Told {
    /// Reports that events up to this one were missed.
    fn gap(number: u64) -> Self {
        Self { number, name: "gap", data: "{}".to_owned() }
    }
}

/// A listener's position in the events.
pub(crate) struct EventStream {
    last: u64,
    n_told: watch::Receiver<u64>,
    passing: watch::Receiver<Option<Passing>>,
    /// Whether it has missed events, which is reported first.
    has_gap: bool,
}

impl Events {
    pub fn new(run: String) -> Self {
        let (n_told, passing) = (watch::Sender::new(0), watch::Sender::new(None));
        Self { run, kept: Mutex::default(), n_told, passing }
    }

    /// Sends an event to current listeners; of several at once, only the last.
    pub fn pass(&self, name: &'static str, data: &impl Serialize) {
        let data = serde_json::to_string(data).expect("records are numbers and names");
        self.passing.send_replace(Some(Passing { name, data }));
    }

    /// Sends an event to all listeners, including those that reconnect later.
    pub fn tell(&self, name: &'static str, data: &impl Serialize) {
        let data = serde_json::to_string(data).expect("records are numbers and names");
        let mut kept = self.kept();
        let number = kept.back().map_or(0, |told| told.number) + 1;
        kept.push_back(Told { number, name, data });
        if kept.len() > KEPT {
            kept.pop_front();
        }
        drop(kept);
        self.n_told.send_replace(number);
    }

    /// Listens from the event after this id; without one, from the current event.
    pub fn listen(&self, last_id: Option<&str>) -> EventStream {
        let (n_told, passing) = (self.n_told.subscribe(), self.passing.subscribe());
        let newest = *n_told.borrow();
        let stream = EventStream { last: newest, n_told, passing, has_gap: false };
        let Some(id) = last_id else { return stream };
        let number = id.split_once('-').filter(|(run, _)| *run == self.run).and_then(|(_, n)| n.parse().ok());
        let oldest = self.kept().front().map_or(1, |told| told.number);
        match number {
            Some(last) if last <= newest && last + 1 >= oldest => EventStream { last, ..stream },
            _ => EventStream { has_gap: true, ..stream },
        }
    }

    /// The id of an event.
    pub fn id(&self, number: u64) -> String {
        format!("{}-{number}", self.run)
    }

    /// Returns the events that a listener has not received, once there are some.
    pub async fn next(&self, stream: &mut EventStream) -> Vec<Told> {
        if std::mem::take(&mut stream.has_gap) {
            return vec![Told::gap(stream.last)];
        }
        loop {
            stream.n_told.borrow_and_update();
            let new: Vec<Told> =
                self.kept().iter().filter(|told| told.number > stream.last).cloned().collect();
            if let [first, ..] = &*new {
                // The listener was too slow: events it did not receive have been dropped.
                let has_gap = first.number > stream.last + 1;
                stream.last = new[new.len() - 1].number;
                return if has_gap { vec![Told::gap(stream.last)] } else { new };
            }
            // The senders live as long as these events.
            tokio::select! {
                _ = stream.n_told.changed() => (),
                _ = stream.passing.changed() => {
                    let passing = stream.passing.borrow_and_update().clone();
                    if let Some(Passing { name, data }) = passing {
                        return vec![Told { number: stream.last, name, data }];
                    }
                }
            }
        }
    }

    fn kept(&self) -> MutexGuard<'_, VecDeque<Told>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
