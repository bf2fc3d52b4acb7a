use super::row::{Row, n_words, set_bit};

/// For each row, a set of column numbers.
///
/// A row is a sorted list while that is the smaller form, and a row of bits from then on, so a row over `n`
/// columns never takes more than `n / 8` bytes. Both forms use one vector of words, and its length
/// distinguishes them: enough words for a bit per column mean bits, fewer mean a list. Lists alone would need
/// 1.2 GB for 60,000 rows of 5000 columns (bits: 38 MB), bits alone 625 MB for 10^6 rows that hold a handful
/// each.
///
/// ```
/// use nextview::flow::Incidence;
///
/// let incidence = Incidence::from_rows(100, [vec![7, 3, 7], vec![]]);
/// assert_eq!(incidence.row(0).collect::<Vec<_>>(), [3, 7]);
/// assert_eq!(incidence.row_len(1), 0);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Incidence {
    rows: Vec<Vec<u32>>,
    n_columns: usize,
}

impl Incidence {
    /// Creates `n_rows` empty rows over the columns below `n_columns`.
    pub fn new(n_rows: usize, n_columns: usize) -> Self {
        Self { rows: vec![Vec::new(); n_rows], n_columns }
    }

    /// Creates one row per list; order and repetition in a list do not matter.
    ///
    /// # Panics
    /// If a column is not below `n_columns`.
    pub fn from_rows<R: IntoIterator<Item = u32>>(
        n_columns: usize,
        rows: impl IntoIterator<Item = R>,
    ) -> Self {
        let mut incidence = Self::new(0, n_columns);
        for columns in rows {
            incidence.rows.push(Vec::new());
            let row = incidence.rows.len() - 1;
            columns.into_iter().for_each(|column| incidence.insert(row, column));
        }
        incidence
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.rows.len()
    }

    /// Number of columns.
    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// Adds a column to a row unless the row has it. Cheapest in increasing order.
    ///
    /// # Panics
    /// If the row or the column is out of range.
    #[inline]
    pub fn insert(&mut self, row: usize, column: u32) {
        assert!((column as usize) < self.n_columns, "column {column} of {}", self.n_columns);
        let n_words = n_words(self.n_columns);
        let words = &mut self.rows[row];
        if words.len() == n_words {
            set_bit(words, column);
        } else if words.last() != Some(&column) {
            insert_in_list(words, column, n_words);
        }
    }

    /// Empties a row and keeps its memory.
    pub fn clear(&mut self, row: usize) {
        self.rows[row].clear();
    }

    /// Returns the columns of a row in increasing order.
    #[inline]
    pub fn row(&self, row: usize) -> impl Iterator<Item = u32> + use<'_> {
        self.words_of(row).columns()
    }

    /// Number of columns of a row.
    pub fn row_len(&self, row: usize) -> usize {
        self.words_of(row).len()
    }

    /// Returns a row in its stored form.
    #[inline]
    pub(super) fn words_of(&self, row: usize) -> Row<'_> {
        Row::new(&self.rows[row], n_words(self.n_columns))
    }

    /// Takes the union of a row with the same row of another incidence of equal size.
    pub(super) fn unite_row(&mut self, row: usize, other: &Self) {
        let n_words = n_words(self.n_columns);
        match other.words_of(row) {
            Row::Bits(bits) if self.rows[row].len() == n_words => {
                self.rows[row].iter_mut().zip(bits).for_each(|(mine, theirs)| *mine |= theirs);
            }
            theirs => theirs.columns().for_each(|column| self.insert(row, column)),
        }
    }

    /// Replaces a row by the same row of another incidence of equal size, which is left undefined.
    pub(super) fn take_row(&mut self, row: usize, other: &mut Self) {
        std::mem::swap(&mut self.rows[row], &mut other.rows[row]);
    }
}

/// Inserts into a sorted list; converts it to bits when it reaches their size.
fn insert_in_list(list: &mut Vec<u32>, column: u32, n_words: usize) {
    if list.last().is_none_or(|&last| last < column) {
        list.push(column);
    } else if let Err(place) = list.binary_search(&column) {
        list.insert(place, column);
    }
    if list.len() == n_words {
        let mut bits = vec![0; n_words];
        list.iter().for_each(|&column| set_bit(&mut bits, column));
        *list = bits;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn rows_are_sets_in_either_form(
            n_columns in 1_usize..200,
            drawn in proptest::collection::vec(any::<u32>(), 0..300),
            other in proptest::collection::vec(any::<u32>(), 0..30),
        ) {
            let below = |list: &[u32]| list.iter().map(|i| i % n_columns as u32).collect::<Vec<_>>();
            let (drawn, other) = (below(&drawn), below(&other));
            let sets: Vec<BTreeSet<u32>> = [&drawn, &other].map(|list| list.iter().copied().collect()).into();
            let incidence = Incidence::from_rows(n_columns, [drawn, other]);
            for (row, set) in sets.iter().enumerate() {
                prop_assert!(incidence.row(row).eq(set.iter().copied()));
                prop_assert_eq!(incidence.row_len(row), set.len());
            }
            let [a, b] = [0, 1].map(|row| incidence.words_of(row));
            prop_assert_eq!(a.is_subset_of(b), sets[0].is_subset(&sets[1]));
            prop_assert_eq!(b.is_subset_of(a), sets[1].is_subset(&sets[0]));
            for (row, set) in sets.iter().enumerate() {
                let signature = set.iter().fold(0, |all, column| all | 1 << (column % 64));
                prop_assert_eq!(incidence.words_of(row).signature(), signature);
            }
        }
    }

    #[test]
    fn memory_of_a_row_is_bounded() {
        let incidence = Incidence::from_rows(5000, std::iter::once(0..5000));
        assert_eq!(incidence.rows[0].capacity(), 157);
    }
}
