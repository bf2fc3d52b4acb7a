use nextview_scan::Fault;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Takes groups of runs from a source. Runs of a group have a common, slow preparation.
pub(super) type Take<'a, R> = &'a (dyn Fn() -> Result<Option<Vec<R>>, Fault> + Sync);

/// Groups of runs in progress. Jobs ask for tasks until there are none left.
pub(super) struct Queue<'a, R, T> {
    take: Take<'a, R>,
    state: Mutex<QueueState<R, T>>,
    changed: Condvar,
}

/// A task for a job.
pub(super) enum Task<R, T> {
    /// Prepare the group with this number, to which this run belongs, then call [`Queue::prepared`].
    Prepare(usize, R),
    /// Execute this run with its preparation.
    Run(R, Arc<T>),
}

struct QueueState<R, T> {
    /// Groups with runs left, by number.
    groups: BTreeMap<usize, Group<R, T>>,
    n_taken: usize,
    /// Whether the source is exhausted.
    is_exhausted: bool,
}

struct Group<R, T> {
    open: VecDeque<R>,
    /// `None` during preparation.
    prepared: Option<Arc<T>>,
}

impl<'a, R: Clone, T> Queue<'a, R, T> {
    /// Creates a queue of the tasks of this source.
    pub fn new(take: Take<'a, R>) -> Self {
        let state = QueueState { groups: BTreeMap::new(), n_taken: 0, is_exhausted: false };
        Self { take, state: Mutex::new(state), changed: Condvar::new() }
    }

    /// Returns the next task; `None` if all are taken. Prepared runs come first, to hold few groups in
    /// memory. If all remaining runs wait for a preparation, so does this.
    pub fn next(&self) -> Result<Option<Task<R, T>>, Fault> {
        let mut state = self.lock();
        loop {
            if let Some(task) = state.next_run() {
                return Ok(Some(task));
            }
            if let Some(task) = state.next_group(self.take)? {
                return Ok(Some(task));
            }
            if state.groups.is_empty() {
                return Ok(None);
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Releases the runs of this group, unless the queue was stopped.
    pub fn prepared(&self, group: usize, prepared: T) {
        if let Some(group) = self.lock().groups.get_mut(&group) {
            group.prepared = Some(Arc::new(prepared));
        }
        self.changed.notify_all();
    }

    /// Drops all tasks that have not begun.
    pub fn stop(&self) {
        let mut state = self.lock();
        state.groups.clear();
        state.is_exhausted = true;
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, QueueState<R, T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<R: Clone, T> QueueState<R, T> {
    fn next_run(&mut self) -> Option<Task<R, T>> {
        let (&number, group) = self.groups.iter_mut().find(|(_, group)| group.prepared.is_some())?;
        let prepared = group.prepared.clone()?;
        let run = group.open.pop_front()?;
        if group.open.is_empty() {
            // Only the last runs still need the preparation, and they hold it themselves.
            self.groups.remove(&number);
        }
        Some(Task::Run(run, prepared))
    }

    fn next_group(&mut self, take: Take<'_, R>) -> Result<Option<Task<R, T>>, Fault> {
        while !self.is_exhausted {
            let Some(runs) = take()? else {
                self.is_exhausted = true;
                break;
            };
            if let Some(first) = runs.first().cloned() {
                let number = self.n_taken;
                self.n_taken += 1;
                self.groups.insert(number, Group { open: runs.into(), prepared: None });
                return Ok(Some(Task::Prepare(number, first)));
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source of these groups.
    fn source(groups: &[&[usize]]) -> impl Fn() -> Result<Option<Vec<usize>>, Fault> + Sync {
        let groups: VecDeque<Vec<usize>> = groups.iter().map(|group| group.to_vec()).collect();
        let groups = Mutex::new(groups);
        move || Ok(groups.lock().unwrap().pop_front())
    }

    #[test]
    fn every_run_is_done_once_with_what_was_prepared_for_it() {
        for n_jobs in [1, 2, 5] {
            let take = source(&[&[0, 1, 2], &[3], &[], &[4, 5, 6, 7]]);
            let queue = Queue::new(&take);
            let done = Mutex::new(Vec::new());
            let job = || {
                while let Some(task) = queue.next().unwrap() {
                    match task {
                        Task::Prepare(group, first) => queue.prepared(group, first),
                        Task::Run(run, first) => done.lock().unwrap().push((*first, run)),
                    }
                }
            };
            std::thread::scope(|scope| (0..n_jobs).for_each(|_| drop(scope.spawn(job))));
            let mut done = done.into_inner().unwrap();
            done.sort_unstable();
            assert_eq!(done, [(0, 0), (0, 1), (0, 2), (3, 3), (4, 4), (4, 5), (4, 6), (4, 7)]);
        }
    }

    #[test]
    fn a_preparation_may_end_after_the_queue_was_stopped() {
        let take = source(&[&[0, 1], &[2]]);
        let queue = Queue::new(&take);
        let Ok(Some(Task::Prepare(0, 0))) = queue.next() else { panic!("a group is prepared first") };
        queue.stop();
        queue.prepared(0, ());
        assert!(matches!(queue.next(), Ok(None)));
    }

    #[test]
    fn what_is_prepared_is_dropped_with_the_last_run() {
        let take = source(&[&[0, 1]]);
        let queue = Queue::new(&take);
        let Ok(Some(Task::Prepare(0, 0))) = queue.next() else { panic!("a group is prepared first") };
        queue.prepared(0, ());
        let Ok(Some(Task::Run(0, first))) = queue.next() else { panic!("then its runs follow") };
        assert_eq!(Arc::strong_count(&first), 2);
        let Ok(Some(Task::Run(1, last))) = queue.next() else { panic!("one after the other") };
        drop(first);
        assert_eq!(Arc::strong_count(&last), 1);
        assert!(matches!(queue.next(), Ok(None)));
    }

    #[test]
    fn a_source_that_fails_fails_every_worker() {
        let take = || Err(Fault::data("the lease ended"));
        let queue: Queue<'_, usize, ()> = Queue::new(&take);
        assert!(queue.next().is_err_and(|fault| fault.message == "the lease ended"));
    }
}
