use super::super::row::Row;
use super::super::rows::Rows;
use crate::{Cancel, Cancelled};
use rustc_hash::FxHashSet;

/// Edges visited and rows compared after which the search for dominated rows ends. Its results are used; a
/// problem that is not fully reduced is only harder to solve.
const MAX_WORK: usize = 4_000_000;

/// The undecided part of a cover problem.
pub(super) struct Core {
    /// Sets of a smallest cover that are already decided, by their original numbers.
    pub chosen: Vec<u32>,
    /// For each remaining item, its candidates among the remaining sets, by their new numbers.
    pub candidates: Rows,
    /// The transposed rows: for each set, its items.
    pub by_set: Rows,
    /// The original number of each remaining set, increasing.
    pub set_ids: Vec<u32>,
}

impl Core {
    /// Applies the classic reductions until none applies (Garfinkel and Nemhauser 1972, Beasley 1987): a set
    /// that is the only candidate of an item is chosen; an item with all the candidates of another is served
    /// along with it; a set that serves only what another serves is not needed.
    pub(super) fn of(all: &Rows, cancel: &Cancel) -> Result<Self, Cancelled> {
        let (is_chosen, keep) = only_candidates(all);
        cancel.check()?;
        let candidates = all.selected(&keep);
        let by_set = candidates.transposed(cancel)?;
        let set_ids = (0..all.n_columns() as u32).collect();
        let mut core = Self { chosen: Vec::new(), candidates, by_set, set_ids };
        core.choose(&is_chosen);
        let mut work = StepBudget { left: MAX_WORK };
        loop {
            cancel.check()?;
            let size = core.size();
            core.drop_wider_items(&mut work, cancel)?;
            core.drop_dominated_sets(&mut work, cancel)?;
            let (is_chosen, keep) = only_candidates(&core.candidates);
            core.choose(&is_chosen);
            core.keep_items(&keep, cancel)?;
            if core.size() == size {
                return Ok(core);
            }
        }
    }

    fn size(&self) -> (usize, usize) {
        (self.candidates.n_rows(), self.by_set.n_rows())
    }

    fn choose(&mut self, is_chosen: &[bool]) {
        let chosen = self.set_ids.iter().zip(is_chosen).filter(|(_, is_chosen)| **is_chosen);
        self.chosen.extend(chosen.map(|(id, _)| id));
    }

    /// Drops every item that has all candidates of another.
    fn drop_wider_items(&mut self, work: &mut StepBudget, cancel: &Cancel) -> Result<(), Cancelled> {
        let held = Containment::new(&self.candidates, &self.by_set);
        let mut narrow_first: Vec<usize> = (0..held.lens.len()).collect();
        narrow_first.sort_by_key(|&item| held.lens[item]);
        let mut keep = vec![true; held.lens.len()];
        for item in narrow_first {
            cancel.check()?;
            if keep[item] {
                held.supersets(item, work).for_each(|wider| keep[wider] = false);
            }
        }
        self.keep_items(&keep, cancel)
    }

    /// Drops every set whose items are all served by another set; of equal sets, the first stays.
    fn drop_dominated_sets(&mut self, work: &mut StepBudget, cancel: &Cancel) -> Result<(), Cancelled> {
        let held = Containment::new(&self.by_set, &self.candidates);
        let keep_set = |set: usize| {
            let beaten_by = |other: usize| held.lens[other] > held.lens[set] || other < set;
            held.lens[set] > 0 && !held.supersets(set, work).any(beaten_by)
        };
        let keep: Vec<bool> = (0..held.lens.len()).map(keep_set).collect();
        self.keep_sets(&keep, cancel)
    }

    fn keep_items(&mut self, keep: &[bool], cancel: &Cancel) -> Result<(), Cancelled> {
        if !keep.iter().all(|&keep| keep) {
            self.candidates = self.candidates.selected(keep);
            self.by_set = self.candidates.transposed(cancel)?;
        }
        Ok(())
    }

    fn keep_sets(&mut self, keep: &[bool], cancel: &Cancel) -> Result<(), Cancelled> {
        if !keep.iter().all(|&keep| keep) {
            self.by_set = self.by_set.selected(keep);
            self.candidates = self.by_set.transposed(cancel)?;
            let ids = self.set_ids.iter().zip(keep).filter(|(_, keep)| **keep);
            self.set_ids = ids.map(|(&id, _)| id).collect();
        }
        Ok(())
    }
}

/// Returns, for each set, whether it is the only candidate of an item, and for each item, whether it is left:
/// not if it is served by those sets or equal to an earlier one.
fn only_candidates(candidates: &Rows) -> (Vec<bool>, Vec<bool>) {
    let mut is_chosen = vec![false; candidates.n_columns()];
    for row in candidates.iter() {
        let mut sets = row.columns();
        if let (Some(only), None) = (sets.next(), sets.next()) {
            is_chosen[only as usize] = true;
        }
    }
    // Used only for membership tests; its order never matters.
    let mut seen = FxHashSet::default();
    let is_served = |row: Row<'_>| row.columns().any(|set| is_chosen[set as usize]);
    let keep = candidates.iter().map(|row| !is_served(row) && seen.insert(row.words())).collect();
    (is_chosen, keep)
}

/// Finds the rows that hold all of another row.
struct Containment<'a> {
    rows: &'a Rows,
    by_column: &'a Rows,
    lens: Vec<u32>,
    column_lens: Vec<u32>,
    /// Signatures that rule out most rows without reading them.
    signatures: Vec<u64>,
}

impl<'a> Containment<'a> {
    fn new(rows: &'a Rows, by_column: &'a Rows) -> Self {
        let signatures = rows.iter().map(|row| row.signature()).collect();
        Self { rows, by_column, lens: rows.lens(), column_lens: by_column.lens(), signatures }
    }

    /// The other rows that hold all columns of `row`; none if it is empty or the work is used up.
    fn supersets(&self, row: usize, work: &mut StepBudget) -> impl Iterator<Item = usize> + use<'_, 'a> {
        // They all hold the row's rarest column, so only the rows of that column are checked.
        let rarest = work.spend(self.lens[row]).then(|| {
            let columns = self.rows.row(row).columns();
            columns.min_by_key(|&column| self.column_lens[column as usize])
        });
        let rarest = rarest.flatten().filter(|&column| work.spend(self.column_lens[column as usize]));
        let others = rarest.into_iter().flat_map(|column| self.by_column.row(column as usize).columns());
        others.map(|other| other as usize).filter(move |&other| {
            other != row
                && self.lens[other] >= self.lens[row]
                && self.signatures[row] & !self.signatures[other] == 0
                && self.rows.row(row).is_subset_of(self.rows.row(other))
        })
    }
}

/// A budget of remaining steps.
struct StepBudget {
    left: usize,
}

impl StepBudget {
    fn spend(&mut self, amount: u32) -> bool {
        let enough = amount as usize <= self.left;
        self.left = self.left.saturating_sub(amount as usize);
        enough
    }
}
