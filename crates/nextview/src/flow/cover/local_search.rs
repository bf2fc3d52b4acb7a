use super::super::rows::Rows;
use std::cmp::Reverse;

/// Visits of an edge after which the search ends: some 4 ms. Real problems of 200 items and 500 sets needed up to
/// 1.5 million to reach the proved optimum.
const MAX_WORK: usize = 2_000_000;

/// The same for each edge of the problem, so that small problems take less.
const MAX_WORK_PER_EDGE: usize = 2_000;

/// Tries to serve all items with fewer sets than `cover`, which must serve them all.
///
/// Local search with weights on the items (Gao, Weise and Li 2015): take a set away from a cover, then swap sets one
/// for one until the rest is a cover again. An item that stays unserved gains weight from step to step, so the search
/// leaves every dead end. Where the published method draws an unserved item by lot, the heaviest is taken: the search
/// then needs no random numbers, and on the problems at hand it reached the optimum soonest.
pub(super) fn improve(candidates: &Rows, by_set: &Rows, cover: Vec<u32>) -> Vec<u32> {
    let n_edges: usize = candidates.iter().map(|row| row.len()).sum();
    if n_edges > MAX_WORK {
        return cover;
    }
    let max_work = MAX_WORK.min(n_edges * MAX_WORK_PER_EDGE);
    let mut search = Search::new(candidates, by_set);
    cover.iter().for_each(|&set| search.add(set));
    let mut best = cover;
    while search.work < max_work && best.len() > 1 {
        if search.unserved.is_empty() {
            best.clone_from(&search.chosen);
            search.remove_least(search.chosen.len());
        } else {
            search.swap();
        }
    }
    best
}

/// A choice of sets, and what adding or removing one would change.
struct Search<'a> {
    candidates: &'a Rows,
    by_set: &'a Rows,
    /// In the order in which they were added.
    chosen: Vec<u32>,
    /// Items that no chosen set serves.
    unserved: Vec<u32>,
    /// For each item the number of chosen sets that serve it, and the sum of their numbers: of one set, its number.
    serving: Vec<(u32, u64)>,
    /// For each item one more than the number of swaps that left it unserved.
    weight: Vec<u64>,
    /// For each set the weight of the items that only it serves or would serve.
    worth: Vec<u64>,
    /// For each set the step in which it was last added or removed.
    moved: Vec<usize>,
    n_steps: usize,
    /// Edges visited.
    work: usize,
}

impl<'a> Search<'a> {
    fn new(candidates: &'a Rows, by_set: &'a Rows) -> Self {
        let (n_items, n_sets) = (candidates.n_rows(), by_set.n_rows());
        Self {
            candidates,
            by_set,
            chosen: Vec::new(),
            unserved: (0..n_items as u32).collect(),
            serving: vec![(0, 0); n_items],
            weight: vec![1; n_items],
            worth: (0..n_sets).map(|set| by_set.row(set).len() as u64).collect(),
            moved: vec![0; n_sets],
            n_steps: 0,
            work: 0,
        }
    }

    /// Moves to another choice of as many sets. The set that was chosen last stays, if others are there.
    fn swap(&mut self) {
        self.n_steps += 1;
        let removed = self.remove_least(self.chosen.len().max(2) - 1);
        let set = self.best_candidate(removed);
        self.add(set);
        for i in 0..self.unserved.len() {
            let item = self.unserved[i];
            self.weight[item as usize] += 1;
            self.change_worth(item, |worth| *worth += 1);
        }
    }

    /// The candidate of most worth for the heaviest unserved item, of several the longest unmoved; `removed` only if
    /// there is no other.
    fn best_candidate(&self, removed: u32) -> u32 {
        let heaviest = self.unserved.iter().max_by_key(|&&item| (self.weight[item as usize], Reverse(item)));
        let item = *heaviest.expect("removing a set of worth leaves items unserved");
        let others = self.candidates.row(item as usize).columns().filter(|&set| set != removed);
        let by_worth = |&set: &u32| (self.worth[set as usize], Reverse((self.moved[set as usize], set)));
        others.max_by_key(by_worth).unwrap_or(removed)
    }

    /// Removes that of the first `n` chosen sets that is missed least, of several the one chosen first.
    fn remove_least(&mut self, n: usize) -> u32 {
        self.work += n;
        let worth = |&i: &usize| self.worth[self.chosen[i] as usize];
        let least = (0..n).min_by_key(worth).expect("a cover of more than one set loses one at a time");
        let set = self.chosen.remove(least);
        self.remove(set);
        set
    }

    fn add(&mut self, set: u32) {
        self.chosen.push(set);
        self.moved[set as usize] = self.n_steps;
        let own_worth = self.worth[set as usize];
        for item in self.by_set.row(set as usize).columns() {
            let (n, sum) = self.serving[item as usize];
            self.serving[item as usize] = (n + 1, sum + set as u64);
            let weight = self.weight[item as usize];
            match n {
                0 => {
                    self.unserved.retain(|&other| other != item);
                    self.change_worth(item, |worth| *worth -= weight);
                }
                1 => self.worth[sum as usize] -= weight,
                _ => self.work += 1,
            }
        }
        self.worth[set as usize] = own_worth;
    }

    fn remove(&mut self, set: u32) {
        self.moved[set as usize] = self.n_steps;
        let own_worth = self.worth[set as usize];
        for item in self.by_set.row(set as usize).columns() {
            let (n, sum) = self.serving[item as usize];
            let others = sum - set as u64;
            self.serving[item as usize] = (n - 1, others);
            let weight = self.weight[item as usize];
            match n {
                1 => {
                    self.unserved.push(item);
                    self.change_worth(item, |worth| *worth += weight);
                }
                2 => self.worth[others as usize] += weight,
                _ => self.work += 1,
            }
        }
        self.worth[set as usize] = own_worth;
    }

    /// Changes the worth of all candidates of an item.
    fn change_worth(&mut self, item: u32, change: impl Fn(&mut u64)) {
        for set in self.candidates.row(item as usize).columns() {
            change(&mut self.worth[set as usize]);
            self.work += 1;
        }
    }
}
