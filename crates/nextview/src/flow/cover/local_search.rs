use super::lists::Lists;
use crate::instructions::instructions;
use crate::{Cancel, Cancelled};

/// Work after which the search ends: about 1 ms. Real problems of 200 items and 500 sets needed up to 1.5
/// million to reach the proved optimum.
const MAX_WORK: usize = 2_000_000;

/// Limit of the work per edge of the problem, so that small problems take less.
const MAX_WORK_PER_EDGE: usize = 2_000;

/// Tries to serve all items with fewer sets than `cover`, which must serve them all.
///
/// Local search with weights on the items (Gao, Weise and Li 2015): it removes a set from a cover, then swaps
/// sets one for one until the rest is a cover again. The weight of an unserved item grows with every step, so
/// the search escapes every dead end. The published method draws an unserved item at random. This one takes
/// the heaviest, which needs no random numbers and reached the optimum soonest on our problems.
///
/// The search ends early once no smaller cover is possible.
pub(super) fn improve(
    candidates: &Lists,
    by_set: &Lists,
    cover: Vec<u32>,
    fewest: usize,
    cancel: &Cancel,
) -> Result<Vec<u32>, Cancelled> {
    let max_work = MAX_WORK.min(candidates.n_pairs() * MAX_WORK_PER_EDGE);
    let mut search = SetSelection::new(candidates, by_set);
    cover.iter().for_each(|&set| search.add(set));
    // A third of the time is spent on the minimum of a few hundred numbers, which takes one vector
    // instruction for every eight.
    instructions().dispatch(
        #[inline(always)]
        || search.run(cover, fewest, max_work, cancel),
    )
}

/// A selection of sets, and the effect of adding or removing one.
///
/// Weights and numbers of steps fit 32 bits, since each costs the visit of an edge.
struct SetSelection<'a> {
    candidates: &'a Lists,
    by_set: &'a Lists,
    /// For each chosen set, the newest last: the weight of the items that only it serves, and in the lower
    /// half the number of sets added before it. The minimum is thus the set whose removal costs least, the
    /// first chosen on ties.
    losses: Vec<u64>,
    /// All sets ever added, in that order.
    added: Vec<u32>,
    /// For each chosen set, its place among the losses.
    place: Vec<u32>,
    items: Vec<SelectionItem>,
    /// Items that no chosen set serves.
    unserved: Vec<u32>,
    /// For each item, its weight while it is unserved, else 0.
    weight_unserved: Vec<u32>,
    /// For each set, the step in which it was last added or removed.
    moved: Vec<u32>,
    n_steps: u32,
    /// Edges visited, as if each set's gain were kept up to date. Gains are computed on demand: a step needs
    /// few of them and changes many more.
    work: usize,
}

struct SelectionItem {
    n_candidates: u32,
    /// Number of chosen sets that serve the item.
    n_serving: u32,
    /// Exclusive or of their numbers; for a single set, its number.
    serving: u32,
    /// One more than the number of swaps that left it unserved.
    weight: u32,
}

impl<'a> SetSelection<'a> {
    fn new(candidates: &'a Lists, by_set: &'a Lists) -> Self {
        let (n_items, n_sets) = (candidates.n_rows() as u32, by_set.n_rows());
        let item = |item| {
            let n_candidates = candidates.row(item).len() as u32;
            SelectionItem { n_candidates, n_serving: 0, serving: 0, weight: 1 }
        };
        Self {
            candidates,
            by_set,
            losses: Vec::new(),
            added: Vec::new(),
            place: vec![0; n_sets],
            items: (0..n_items).map(item).collect(),
            unserved: (0..n_items).collect(),
            weight_unserved: vec![1; n_items as usize],
            moved: vec![0; n_sets],
            n_steps: 0,
            work: 0,
        }
    }

    /// Searches from the added cover; returns the smallest cover found.
    #[inline(always)]
    fn run(
        &mut self,
        cover: Vec<u32>,
        fewest: usize,
        max_work: usize,
        cancel: &Cancel,
    ) -> Result<Vec<u32>, Cancelled> {
        let mut best = cover;
        while self.work < max_work && best.len() > fewest.max(1) {
            cancel.check()?;
            if self.unserved.is_empty() {
                best = self.chosen();
                self.shrink();
            } else {
                self.swap();
            }
        }
        Ok(best)
    }

    fn chosen(&self) -> Vec<u32> {
        self.losses.iter().map(|&loss| self.set_of(loss)).collect()
    }

    /// Continues from a cover with one set fewer.
    #[inline(always)]
    fn shrink(&mut self) {
        self.remove_least(self.losses.len());
        if let Some(newest) = (0..self.losses.len()).max_by_key(|&place| self.losses[place] as u32) {
            let last = self.losses.len() - 1;
            self.losses.swap(newest, last);
            self.note_place(newest);
            self.note_place(last);
        }
    }

    /// Moves to another selection of the same number of sets. The set chosen last stays unless it is the only
    /// one.
    #[inline(always)]
    fn swap(&mut self) {
        self.n_steps += 1;
        let removed = self.remove_least(self.losses.len().max(2) - 1);
        let set = self.best_candidate(removed);
        self.add(set);
        for &unserved in &self.unserved {
            let item = &mut self.items[unserved as usize];
            item.weight += 1;
            self.weight_unserved[unserved as usize] = item.weight;
            self.work += item.n_candidates as usize;
        }
    }

    /// The candidate of largest gain for the heaviest unserved item, on ties the one unmoved for longest;
    /// `removed` only if there is no other.
    #[inline(always)]
    fn best_candidate(&self, removed: u32) -> u32 {
        let heaviness = |&item: &u32| u64::from(self.items[item as usize].weight) << 32 | u64::from(!item);
        let heaviest = self.unserved.iter().map(heaviness).max();
        let item = !(heaviest.expect("removing a set of value leaves items unserved") as u32);
        let (mut best, mut most) = (removed, 0);
        for &set in self.candidates.row(item) {
            let gain: u32 =
                self.by_set.row(set).iter().map(|&item| self.weight_unserved[item as usize]).sum();
            let rank = u64::from(gain) << 32 | u64::from(!self.moved[set as usize]);
            if set != removed && rank > most {
                (best, most) = (set, rank);
            }
        }
        best
    }

    /// Removes that one of the first `n` chosen sets whose removal costs least, the first chosen on ties.
    #[inline(always)]
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

    #[inline(always)]
    fn add(&mut self, set: u32) {
        self.moved[set as usize] = self.n_steps;
        let mut loss = 0;
        for &number in self.by_set.row(set) {
            let item = &mut self.items[number as usize];
            match item.n_serving {
                0 => {
                    loss += u64::from(item.weight);
                    self.weight_unserved[number as usize] = 0;
                    self.work += item.n_candidates as usize;
                    let place = self.unserved.iter().position(|&other| other == number);
                    self.unserved.swap_remove(place.expect("it is listed while nothing serves it"));
                }
                1 => self.losses[self.place[item.serving as usize] as usize] -= u64::from(item.weight) << 32,
                _ => self.work += 1,
            }
            item.n_serving += 1;
            item.serving ^= set;
        }
        self.place[set as usize] = self.losses.len() as u32;
        self.losses.push(loss << 32 | self.added.len() as u64);
        self.added.push(set);
    }

    #[inline(always)]
    fn remove(&mut self, set: u32) {
        self.moved[set as usize] = self.n_steps;
        for &number in self.by_set.row(set) {
            let item = &mut self.items[number as usize];
            item.n_serving -= 1;
            item.serving ^= set;
            match item.n_serving {
                0 => {
                    self.unserved.push(number);
                    self.weight_unserved[number as usize] = item.weight;
                    self.work += item.n_candidates as usize;
                }
                1 => self.losses[self.place[item.serving as usize] as usize] += u64::from(item.weight) << 32,
                _ => self.work += 1,
            }
        }
    }

    #[inline(always)]
    fn set_of(&self, loss: u64) -> u32 {
        self.added[loss as u32 as usize]
    }

    #[inline(always)]
    fn note_place(&mut self, place: usize) {
        let set = self.set_of(self.losses[place]);
        self.place[set as usize] = place as u32;
    }
}
