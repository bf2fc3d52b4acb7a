//! Who does what next.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Groups of runs that share something which takes long to prepare. Jobs ask for tasks until there are none left.
pub(super) struct Queue<T> {
    groups: Mutex<Vec<Group<T>>>,
    changed: Condvar,
}

/// What to do.
pub(super) enum Task<T> {
    /// Prepare this group, then call [`Queue::prepared`].
    Prepare(usize),
    /// Do this run with what was prepared for it.
    Run(usize, Arc<T>),
}

struct Group<T> {
    /// Runs to do.
    open: VecDeque<usize>,
    stage: Stage<T>,
}

enum Stage<T> {
    New,
    InPreparation,
    Prepared(Arc<T>),
}

impl<T> Queue<T> {
    /// Groups of runs; every group has one at least.
    pub fn new(groups: Vec<Vec<usize>>) -> Self {
        let groups = groups.into_iter().map(|runs| Group { open: runs.into(), stage: Stage::New });
        Self { groups: Mutex::new(groups.collect()), changed: Condvar::new() }
    }

    /// The next task; none if all are taken. Runs that are prepared come first, so that few groups are held in memory; if
    /// all that is left waits for a preparation, so does this.
    pub fn next(&self) -> Option<Task<T>> {
        let mut groups = self.lock();
        loop {
            if let Some(task) = groups.iter_mut().find_map(Group::next_run) {
                return Some(task);
            }
            if let Some(number) = groups.iter().position(|group| matches!(group.stage, Stage::New)) {
                groups[number].stage = Stage::InPreparation;
                return Some(Task::Prepare(number));
            }
            if groups.iter().all(|group| group.open.is_empty()) {
                return None;
            }
            groups = self.changed.wait(groups).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// The runs of this group can be done, unless the queue was stopped.
    pub fn prepared(&self, group: usize, prepared: T) {
        if let Some(group) = self.lock().get_mut(group) {
            group.stage = Stage::Prepared(Arc::new(prepared));
        }
        self.changed.notify_all();
    }

    /// Forgets all tasks that were not begun.
    pub fn stop(&self) {
        self.lock().clear();
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Group<T>>> {
        self.groups.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> Group<T> {
    fn next_run(&mut self) -> Option<Task<T>> {
        let Stage::Prepared(prepared) = &self.stage else { return None };
        let prepared = prepared.clone();
        let run = self.open.pop_front()?;
        if self.open.is_empty() {
            // Nobody needs it any more but the last runs, which hold it themselves.
            self.stage = Stage::InPreparation;
        }
        Some(Task::Run(run, prepared))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_is_done_once_with_what_was_prepared_for_it() {
        let groups = vec![vec![0, 1, 2], vec![3], vec![4, 5, 6, 7]];
        for n_jobs in [1, 2, 5] {
            let queue = Queue::new(groups.clone());
            let done = Mutex::new(Vec::new());
            let job = || {
                while let Some(task) = queue.next() {
                    match task {
                        Task::Prepare(group) => queue.prepared(group, group),
                        Task::Run(run, group) => done.lock().unwrap().push((*group, run)),
                    }
                }
            };
            std::thread::scope(|scope| (0..n_jobs).for_each(|_| drop(scope.spawn(job))));
            let mut done = done.into_inner().unwrap();
            done.sort_unstable();
            assert_eq!(done, [(0, 0), (0, 1), (0, 2), (1, 3), (2, 4), (2, 5), (2, 6), (2, 7)]);
        }
    }

    #[test]
    fn a_preparation_may_end_after_the_queue_was_stopped() {
        let queue = Queue::new(vec![vec![0, 1], vec![2]]);
        let Some(Task::Prepare(0)) = queue.next() else { panic!("a group is prepared first") };
        queue.stop();
        queue.prepared(0, ());
        assert!(queue.next().is_none());
    }

    #[test]
    fn what_is_prepared_is_dropped_with_the_last_run() {
        let queue = Queue::new(vec![vec![0, 1]]);
        let Some(Task::Prepare(0)) = queue.next() else { panic!("a group is prepared first") };
        queue.prepared(0, ());
        let Some(Task::Run(0, first)) = queue.next() else { panic!("then its runs follow") };
        assert_eq!(Arc::strong_count(&first), 2);
        let Some(Task::Run(1, last)) = queue.next() else { panic!("one after the other") };
        drop(first);
        assert_eq!(Arc::strong_count(&last), 1);
        assert!(queue.next().is_none());
    }
}
