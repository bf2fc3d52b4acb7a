use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::Notify;

/// A client that keeps the server waiting this long is slow. A shorter wait says nothing: its bytes may be on
/// their way.
const SLOW: Duration = Duration::from_secs(1);

/// The places for connections. If all are taken, one waiting for its client gives way: idle or slow clients
/// keep nobody out.
pub(super) struct Places {
    most: usize,
    taken: Mutex<Taken>,
}

#[derive(Default)]
struct Taken {
    n_begun: u64,
    places: BTreeMap<u64, Arc<PlaceState>>,
}

/// State of a place.
struct PlaceState {
    now: Mutex<Now>,
    gives_way: Notify,
}

#[derive(Clone, Copy)]
struct Now {
    turn: ActingSide,
    /// Time at which the current turn began.
    since: Instant,
    /// Time since which the client accepts nothing of an answer; `None` while it accepts.
    stuck_since: Option<Instant>,
}

/// The side that must act next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ActingSide {
    /// The client must send a head.
    Head,
    /// The client must send a body.
    Body,
    /// The server must act.
    Server,
}

/// The place of a connection, released on drop.
pub(super) struct HeldPlace {
    all: Arc<Places>,
    number: u64,
    state: Arc<PlaceState>,
}

impl Places {
    pub fn new(most: usize) -> Arc<Self> {
        Arc::new(Self { most, taken: Mutex::default() })
    }

    /// Takes a place; `None` if all connections wait for the server.
    pub fn take(self: &Arc<Self>) -> Option<Arc<HeldPlace>> {
        let mut taken = self.lock();
        if taken.places.len() >= self.most && !taken.give_way() {
            return None;
        }
        let number = taken.n_begun;
        taken.n_begun += 1;
        let now = Now { turn: ActingSide::Head, since: Instant::now(), stuck_since: None };
        let state = Arc::new(PlaceState { now: Mutex::new(now), gives_way: Notify::new() });
        taken.places.insert(number, state.clone());
        Some(Arc::new(HeldPlace { all: self.clone(), number, state }))
    }

    /// Frees a place, if the server is waiting for any client.
    pub fn give_way(&self) {
        self.lock().give_way();
    }

    fn lock(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Taken {
    /// Frees the place of the slow client that has kept the server waiting longest: first one that owes a
    /// head, otherwise one that owes a body or takes no answer. If no client is slow, the one waited for
    /// longest.
    fn give_way(&mut self) -> bool {
        let now = Instant::now();
        let waiting = self.places.iter().filter_map(|(number, state)| {
            let (turn, since) = state.waits()?;
            let is_slow = now.duration_since(since) >= SLOW;
            Some((!is_slow, is_slow.then_some(turn), since, *number))
        });
        let Some((.., number)) = waiting.min() else { return false };
        if let Some(state) = self.places.remove(&number) {
            state.gives_way.notify_one();
        }
        true
    }
}

impl PlaceState {
    /// The event that the server waits for, and since when; `None` if it does not wait.
    fn waits(&self) -> Option<(ActingSide, Instant)> {
        let Now { turn, since, stuck_since } = *self.lock();
        match (turn, stuck_since) {
            (_, Some(since)) => Some((ActingSide::Body, since)),
            (ActingSide::Server, None) => None,
            (turn, None) => Some((turn, since)),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Now> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl HeldPlace {
    /// Starts this side's turn, unless it already has it.
    pub fn turn(&self, turn: ActingSide) {
        let mut now = self.state.lock();
        if now.turn != turn {
            (now.turn, now.since) = (turn, Instant::now());
        }
    }

    /// Records whether the client is stuck and accepts nothing of an answer.
    pub fn is_stuck(&self, is_stuck: bool) {
        let mut now = self.state.lock();
        now.stuck_since = is_stuck.then(|| now.stuck_since.unwrap_or_else(Instant::now));
    }

    /// Returns when the connection must end.
    pub async fn gives_way(&self) {
        self.state.gives_way.notified().await;
    }
}

impl Drop for HeldPlace {
    fn drop(&mut self) {
        self.all.lock().places.remove(&self.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::FutureExt;

    #[test]
    fn those_that_wait_longest_give_way_and_nobody_who_is_served() {
        let places = Places::new(3);
        let taken: Vec<_> = (0..3).map(|_| places.take().unwrap()).collect();
        let gone = |i: usize| taken[i].gives_way().now_or_never().is_some();
        taken[0].turn(ActingSide::Server);
        taken[1].turn(ActingSide::Body);
        taken.iter().for_each(|place| place.state.lock().since -= SLOW);
        let new = places.take().unwrap();
        assert!(gone(2) && !gone(0) && !gone(1), "a head is waited for");
        new.turn(ActingSide::Server);
        let newest = places.take().unwrap();
        assert!(gone(1) && !gone(0));
        newest.turn(ActingSide::Server);
        assert!(places.take().is_none(), "all are served");
        taken[0].is_stuck(true);
        assert!(places.take().is_some() && gone(0), "it takes nothing of its answer");
        drop((new, newest, taken));
        assert!(places.lock().places.is_empty());
    }

    #[test]
    fn a_client_that_has_just_come_does_not_give_way_to_the_next() {
        let places = Places::new(2);
        let (stalled, new) = (places.take().unwrap(), places.take().unwrap());
        stalled.turn(ActingSide::Body);
        stalled.state.lock().since = new.state.lock().since - SLOW / 2;
        assert!(places.take().is_some());
        let gone = |place: &HeldPlace| place.gives_way().now_or_never().is_some();
        assert!(gone(&stalled) && !gone(&new), "none is slow, and the body was waited for longer");
    }
}
