use super::super::Incidence;
use rustc_hash::FxHashSet;

/// Edges visited and rows compared after which dominated rows are no longer looked for. What is found by then is
/// used; a problem that is not fully reduced is only harder for what follows.
const MAX_WORK: usize = 4_000_000;

/// What is left to decide of a cover problem.
pub(super) struct Core {
    /// Sets that a smallest cover holds, by their original numbers.
    pub chosen: Vec<u32>,
    /// For each item left, its candidates among the sets left, by their new numbers.
    pub candidates: Incidence,
    /// The same read the other way.
    pub by_set: Incidence,
    /// The original number of each set left, increasing.
    pub set_ids: Vec<u32>,
}

impl Core {
    /// Applies the classic reductions until none applies (Garfinkel and Nemhauser 1972, Beasley 1987): a set that is
    /// the only candidate of an item is chosen; an item with all the candidates of another is served along with it;
    /// a set that serves only what another serves is not needed.
    pub(super) fn of(candidates: Incidence, by_set: Incidence) -> Self {
        let set_ids = (0..candidates.n_columns() as u32).collect();
        let mut core = Self { chosen: Vec::new(), candidates, by_set, set_ids };
        let mut work = Work { left: MAX_WORK };
        loop {
            let size = core.size();
            core.choose_only_candidates();
            core.drop_wider_items(&mut work);
            core.drop_dominated_sets(&mut work);
            if core.size() == size {
                return core;
            }
        }
    }

    fn size(&self) -> (usize, usize) {
        (self.candidates.n_rows(), self.by_set.n_rows())
    }

    /// Drops the items that are served by the sets chosen here, or equal to an earlier item, or without candidates.
    fn choose_only_candidates(&mut self) {
        let mut is_chosen = vec![false; self.by_set.n_rows()];
        for item in 0..self.candidates.n_rows() {
            let mut row = self.candidates.row(item);
            if let (Some(only), None) = (row.next(), row.next()) {
                is_chosen[only as usize] = true;
            }
        }
        // Asked only whether it has a row; its order never matters.
        let mut seen = FxHashSet::default();
        let keep_item = |item: usize| {
            self.candidates.row(item).next().is_some()
                && !self.candidates.row(item).any(|set| is_chosen[set as usize])
                && seen.insert(self.candidates.row_words(item))
        };
        let items: Vec<bool> = (0..self.candidates.n_rows()).map(keep_item).collect();
        let chosen = self.set_ids.iter().zip(&is_chosen).filter(|(_, is_chosen)| **is_chosen);
        self.chosen.extend(chosen.map(|(id, _)| id));
        let sets: Vec<bool> = is_chosen.iter().map(|is_chosen| !is_chosen).collect();
        self.keep(&items, &sets);
    }

    /// Drops every item that has all candidates of another.
    fn drop_wider_items(&mut self, work: &mut Work) {
        let held = Containment::new(&self.candidates, &self.by_set);
        let mut narrow_first: Vec<usize> = (0..held.lens.len()).collect();
        narrow_first.sort_by_key(|&item| held.lens[item]);
        let mut keep = vec![true; held.lens.len()];
        for item in narrow_first {
            if keep[item] {
                held.supersets(item, work).for_each(|wider| keep[wider] = false);
            }
        }
        self.keep(&keep, &vec![true; self.by_set.n_rows()]);
    }

    /// Drops every set that serves only items which another set serves, of equal sets all but the first.
    fn drop_dominated_sets(&mut self, work: &mut Work) {
        let held = Containment::new(&self.by_set, &self.candidates);
        let keep_set = |set: usize| {
            let beaten_by = |other: usize| held.lens[other] > held.lens[set] || other < set;
            held.lens[set] > 0 && !held.supersets(set, work).any(beaten_by)
        };
        let keep: Vec<bool> = (0..held.lens.len()).map(keep_set).collect();
        self.keep(&vec![true; self.candidates.n_rows()], &keep);
    }

    /// Reduces the problem to some of its items and sets.
    fn keep(&mut self, items: &[bool], sets: &[bool]) {
        if items.iter().chain(sets).all(|&keep| keep) {
            return;
        }
        let mut n_sets = 0;
        let number = |&keep: &bool| {
            n_sets += u32::from(keep);
            keep.then(|| n_sets - 1)
        };
        let new_number: Vec<Option<u32>> = sets.iter().map(number).collect();
        let rows = (0..items.len()).filter(|&item| items[item]);
        let rows = rows.map(|item| self.candidates.row(item).filter_map(|set| new_number[set as usize]));
        self.candidates = Incidence::from_rows(n_sets as usize, rows);
        self.by_set = self.candidates.transposed();
        let ids = self.set_ids.iter().zip(sets).filter(|(_, keep)| **keep);
        self.set_ids = ids.map(|(&id, _)| id).collect();
    }
}

/// Finds the rows that hold all of another row.
struct Containment<'a> {
    rows: &'a Incidence,
    by_column: &'a Incidence,
    lens: Vec<usize>,
    column_lens: Vec<usize>,
    /// Most rows that hold not all of another are told apart by these, without a look at the rows.
    signatures: Vec<u64>,
}

impl<'a> Containment<'a> {
    fn new(rows: &'a Incidence, by_column: &'a Incidence) -> Self {
        let lens = |of: &Incidence| (0..of.n_rows()).map(|row| of.row_len(row)).collect();
        let signatures = (0..rows.n_rows()).map(|row| rows.row_signature(row)).collect();
        Self { rows, by_column, lens: lens(rows), column_lens: lens(by_column), signatures }
    }

    /// The other rows that hold all columns of `row`; none if it is empty or the work is used up.
    fn supersets(&self, row: usize, work: &mut Work) -> impl Iterator<Item = usize> + use<'_, 'a> {
        // They all hold the row's rarest column, so only the rows of that one need a look.
        let rarest = work.spend(self.lens[row]).then(|| {
            let columns = self.rows.row(row);
            columns.min_by_key(|&column| self.column_lens[column as usize])
        });
        let rarest = rarest.flatten().filter(|&column| work.spend(self.column_lens[column as usize]));
        let others = rarest.into_iter().flat_map(|column| self.by_column.row(column as usize));
        others.map(|other| other as usize).filter(move |&other| {
            other != row
                && self.lens[other] >= self.lens[row]
                && self.signatures[row] & !self.signatures[other] == 0
                && self.rows.row_is_subset(row, other)
        })
    }
}

/// A count of steps that may still be done.
struct Work {
    left: usize,
}

impl Work {
    fn spend(&mut self, amount: usize) -> bool {
        let enough = amount <= self.left;
        self.left = self.left.saturating_sub(amount);
        enough
    }
}
