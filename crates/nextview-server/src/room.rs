use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::oneshot;

/// A body that received nothing for this long gives way first.
const STALLED: Duration = Duration::from_secs(1);

/// Memory for all bodies being received or processed. If it is full, a body still being received gives way to
/// the others: clients that stall or send a lot keep nobody out.
pub(crate) struct BodyRoom(Mutex<Room>);

struct Room {
    /// Free memory in bytes.
    free: usize,
    /// Bodies being received, oldest first.
    receiving: BTreeMap<u64, Receiving>,
    n_begun: u64,
}

/// A body being received.
struct Receiving {
    bytes: usize,
    /// Time of the last bytes.
    last: Instant,
    /// When dropped, notifies the task that receives the body.
    _gives_way: oneshot::Sender<()>,
}

/// A body's share of the memory, released on drop.
pub(crate) struct Share {
    room: Arc<BodyRoom>,
    number: u64,
    /// Size of a complete body in bytes.
    held: usize,
}

impl BodyRoom {
    pub fn new(bytes: usize) -> Self {
        Self(Mutex::new(Room { free: bytes, receiving: BTreeMap::new(), n_begun: 0 }))
    }

    /// Begins a body. The receiver next to its share is notified when it must give way.
    pub fn begin(self: &Arc<Self>) -> (Share, oneshot::Receiver<()>) {
        let (_gives_way, told) = oneshot::channel();
        let mut room = self.lock();
        let number = room.n_begun;
        room.n_begun += 1;
        room.receiving.insert(number, Receiving { bytes: 0, last: Instant::now(), _gives_way });
        (Share { room: self.clone(), number, held: 0 }, told)
    }

    fn lock(&self) -> MutexGuard<'_, Room> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Room {
    /// The body that gives way to this one: the largest of the stalled bodies, or of all. `None` if that is
    /// the body itself.
    fn victim(&self, number: u64, more: usize, now: Instant) -> Option<u64> {
        let others = || self.receiving.iter().filter(|(of, body)| **of != number && body.bytes > 0);
        let stalled = others().filter(|(_, body)| now.duration_since(body.last) >= STALLED);
        if let Some((of, _)) = stalled.max_by_key(|(_, body)| body.bytes) {
            return Some(*of);
        }
        let own = self.receiving.get(&number)?.bytes + more;
        others().max_by_key(|(_, body)| body.bytes).filter(|(_, body)| body.bytes >= own).map(|(of, _)| *of)
    }
}

impl Share {
    /// Reserves memory for more bytes; returns false if there is none, or if the body had to give way.
    pub fn grow(&mut self, more: usize) -> bool {
        let (mut room, now) = (self.room.lock(), Instant::now());
        while room.free < more {
            let Some(victim) = room.victim(self.number, more, now) else { return false };
            let freed = room.receiving.remove(&victim).map_or(0, |body| body.bytes);
            room.free += freed;
        }
        let Some(body) = room.receiving.get_mut(&self.number) else { return false };
        (body.bytes, body.last) = (body.bytes + more, now);
        room.free -= more;
        true
    }

    /// Marks the body as complete, so it no longer gives way; returns false if it had to.
    pub fn complete(&mut self) -> bool {
        let body = self.room.lock().receiving.remove(&self.number);
        self.held = body.as_ref().map_or(0, |body| body.bytes);
        body.is_some()
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        let mut room = self.room.lock();
        let received = room.receiving.remove(&self.number).map_or(0, |body| body.bytes);
        room.free += received + self.held;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_told(told: &mut oneshot::Receiver<()>) -> bool {
        told.try_recv() == Err(oneshot::error::TryRecvError::Closed)
    }

    #[test]
    fn the_largest_body_gives_way_and_what_is_complete_stays() {
        let room = Arc::new(BodyRoom::new(100));
        let ((mut complete, _), (mut large, mut told), (mut small, _)) =
            (room.begin(), room.begin(), room.begin());
        assert!(complete.grow(30) && complete.complete());
        assert!(large.grow(60) && !is_told(&mut told));
        assert!(small.grow(20) && is_told(&mut told));
        assert!(!large.grow(1) && !large.complete(), "it had to give way");
        assert!(!small.grow(60), "what is complete does not");
        drop((complete, large, small));
        assert_eq!(room.lock().free, 100);
    }

    #[test]
    fn a_body_that_stalls_gives_way_to_larger_ones() {
        let room = Arc::new(BodyRoom::new(100));
        let ((mut stalled, mut told), (mut large, _)) = (room.begin(), room.begin());
        assert!(stalled.grow(40) && large.grow(60) && !large.grow(10));
        room.lock().receiving.get_mut(&stalled.number).unwrap().last -= 2 * STALLED;
        assert!(large.grow(10) && is_told(&mut told));
    }
}
