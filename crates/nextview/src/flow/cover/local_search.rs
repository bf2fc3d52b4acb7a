use super::super::rows::Rows;
use std::cmp::Reverse;

/// Work after which the search ends: some 1 ms. Real problems of 200 items and 500 sets needed up to 1.5 million to
/// reach the proved optimum.
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
    let (candidates, by_set) = (Lists::of(candidates), Lists::of(by_set));
    let mut search = Search::new(&candidates, &by_set);
    cover.iter().for_each(|&set| search.add(set));
    let mut best = cover;
    while search.work < max_work && best.len() > 1 {
        if search.unserved.is_empty() {
            best = search.chosen();
            search.shrink();
        } else {
            search.swap();
        }
    }
    best
}

/// Rows that are all lists, so that the search need not ask for their form.
struct Lists {
    columns: Vec<u32>,
    starts: Vec<u32>,
}

impl Lists {
    fn of(rows: &Rows) -> Self {
        let (mut columns, mut starts) = (Vec::new(), vec![0]);
        for row in rows.iter() {
            columns.extend(row.columns());
            starts.push(columns.len() as u32);
        }
        Self { columns, starts }
    }

    fn n_rows(&self) -> usize {
        self.starts.len() - 1
    }

    #[inline]
    fn row(&self, row: u32) -> &[u32] {
        let row = row as usize;
        &self.columns[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}

/// A choice of sets, and what adding or removing one would change.
///
/// Weights and numbers of steps fit 32 bits, for each costs the visit of an edge.
struct Search<'a> {
    candidates: &'a Lists,
    by_set: &'a Lists,
    /// For each chosen set, the newest last, the weight of the items that only it serves, and in the lower half how many
    /// sets were added before it. So the least is that which is missed least, of several the one chosen first.
    losses: Vec<u64>,
    /// All sets ever added, in that order.
    added: Vec<u32>,
    /// For each chosen set its place among the losses.
    place: Vec<u32>,
    /// Items that no chosen set serves.
    unserved: Vec<u32>,
    /// For each item the number of chosen sets that serve it, and their numbers combined by exclusive or: of one set,
    /// its number.
    serving: Vec<(u32, u32)>,
    /// For each item one more than the number of swaps that left it unserved.
    weight: Vec<u32>,
    /// The same while it is unserved, else 0.
    weight_unserved: Vec<u32>,
    /// For each set the step in which it was last added or removed.
    moved: Vec<u32>,
    n_steps: u32,
    /// Edges visited, as if each set's gain were kept up to date. It is found when asked for: a few sets are asked in a
    /// step, many more change.
    work: usize,
}

impl<'a> Search<'a> {
    fn new(candidates: &'a Lists, by_set: &'a Lists) -> Self {
        let (n_items, n_sets) = (candidates.n_rows(), by_set.n_rows());
        Self {
            candidates,
            by_set,
            losses: Vec::new(),
            added: Vec::new(),
            place: vec![0; n_sets],
            unserved: (0..n_items as u32).collect(),
            serving: vec![(0, 0); n_items],
            weight: vec![1; n_items],
            weight_unserved: vec![1; n_items],
            moved: vec![0; n_sets],
            n_steps: 0,
            work: 0,
        }
    }

    fn chosen(&self) -> Vec<u32> {
        self.losses.iter().map(|&loss| self.set_of(loss)).collect()
    }

    /// Goes on from a cover to a choice of one set less.
    fn shrink(&mut self) {
        self.remove_least(self.losses.len());
        if let Some(newest) = (0..self.losses.len()).max_by_key(|&place| self.losses[place] as u32) {
            let last = self.losses.len() - 1;
            self.losses.swap(newest, last);
            [newest, last].into_iter().for_each(|place| self.note_place(place));
        }
    }

    /// Moves to another choice of as many sets. The set that was chosen last stays, if others are there.
    fn swap(&mut self) {
        self.n_steps += 1;
        let removed = self.remove_least(self.losses.len().max(2) - 1);
        let set = self.best_candidate(removed);
        self.add(set);
        for &item in &self.unserved {
            self.weight[item as usize] += 1;
            self.weight_unserved[item as usize] = self.weight[item as usize];
            self.work += self.candidates.row(item).len();
        }
    }

    /// The candidate that serves most weight, the heaviest unserved item with it, of several the longest unmoved;
    /// `removed` only if there is no other.
    fn best_candidate(&self, removed: u32) -> u32 {
        let heaviest = self.unserved.iter().max_by_key(|&&item| (self.weight[item as usize], Reverse(item)));
        let item = *heaviest.expect("removing a set of worth leaves items unserved");
        let gain = |set: u32| -> u32 {
            self.by_set.row(set).iter().map(|&item| self.weight_unserved[item as usize]).sum()
        };
        let others = self.candidates.row(item).iter().copied().filter(|&set| set != removed);
        others.max_by_key(|&set| (gain(set), Reverse((self.moved[set as usize], set)))).unwrap_or(removed)
    }

    /// Removes that of the first `n` chosen sets that is missed least, of several the one chosen first.
    fn remove_least(&mut self, n: usize) -> u32 {
        self.work += n;
        let least = self.losses[..n].iter().copied().min();
        let set = self.set_of(least.expect("a cover of more than one set loses one at a time"));
        let place = self.place[set as usize] as usize;
        self.losses.swap_remove(place);
        if place < self.losses.len() {
            self.note_place(place);
        }
        self.remove(set);
        set
    }

    fn add(&mut self, set: u32) {
        self.moved[set as usize] = self.n_steps;
        let mut loss = 0;
        for &item in self.by_set.row(set) {
            let (n, sets) = &mut self.serving[item as usize];
            let weight = self.weight[item as usize];
            match *n {
                0 => {
                    loss += weight;
                    self.unserved.retain(|&other| other != item);
                    self.weight_unserved[item as usize] = 0;
                    self.work += self.candidates.row(item).len();
                }
                1 => self.losses[self.place[*sets as usize] as usize] -= u64::from(weight) << 32,
                _ => self.work += 1,
            }
            *n += 1;
            *sets ^= set;
        }
        self.losses.push(u64::from(loss) << 32 | self.added.len() as u64);
        self.added.push(set);
        self.place[set as usize] = self.losses.len() as u32 - 1;
    }

    fn remove(&mut self, set: u32) {
        self.moved[set as usize] = self.n_steps;
        for &item in self.by_set.row(set) {
            let (n, sets) = &mut self.serving[item as usize];
            *n -= 1;
            *sets ^= set;
            let weight = self.weight[item as usize];
            match *n {
                0 => {
                    self.unserved.push(item);
                    self.weight_unserved[item as usize] = weight;
                    self.work += self.candidates.row(item).len();
                }
                1 => self.losses[self.place[*sets as usize] as usize] += u64::from(weight) << 32,
                _ => self.work += 1,
            }
        }
    }

    fn set_of(&self, loss: u64) -> u32 {
        self.added[loss as u32 as usize]
    }

    fn note_place(&mut self, place: usize) {
        let set = self.set_of(self.losses[place]);
        self.place[set as usize] = place as u32;
    }
}
