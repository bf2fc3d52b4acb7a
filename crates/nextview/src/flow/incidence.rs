use std::iter::Copied;
use std::slice::Iter;

/// For each of a number of rows, a set of column numbers.
///
/// A row is a sorted list while that is the smaller form, and a row of bits from then on, so a row over `n` columns
/// never holds more than `n / 8` bytes. Both forms live in one vector of words and its length tells them apart: as
/// many words as it takes to hold a bit for every column mean bits, fewer a list. Lists alone would need 1.2 GB for
/// 60,000 rows of 5000 columns (bits: 38 MB), bits alone 625 MB for 10^6 rows that hold a handful each.
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
    /// `n_rows` empty rows over the columns below `n_columns`.
    pub fn new(n_rows: usize, n_columns: usize) -> Self {
        Self { rows: vec![Vec::new(); n_rows], n_columns }
    }

    /// One row per list; order and repetition in a list do not matter.
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

    /// Adds a column to a row; nothing happens if the row has it. Cheapest in increasing order.
    ///
    /// # Panics
    /// If the row or the column is out of range.
    #[inline]
    pub fn insert(&mut self, row: usize, column: u32) {
        assert!((column as usize) < self.n_columns, "column {column} of {}", self.n_columns);
        let n_words = self.n_words();
        let words = &mut self.rows[row];
        if words.len() == n_words {
            words[column as usize / 32] |= 1 << (column % 32);
        } else if words.last() != Some(&column) {
            insert_in_list(words, column, n_words);
        }
    }

    /// Empties a row, keeping its memory for what comes next.
    pub fn clear(&mut self, row: usize) {
        self.rows[row].clear();
    }

    /// The columns of a row in increasing order.
    #[inline]
    pub fn row(&self, row: usize) -> impl Iterator<Item = u32> + use<'_> {
        match self.form(row) {
            Form::List(list) => Columns::List(list.iter().copied()),
            Form::Bits(bits) => Columns::Bits { rest: bits.iter().copied(), word: 0, end: 0 },
        }
    }

    /// Number of columns of a row.
    pub fn row_len(&self, row: usize) -> usize {
        match self.form(row) {
            Form::List(list) => list.len(),
            Form::Bits(bits) => bits.iter().map(|word| word.count_ones() as usize).sum(),
        }
    }

    /// Number of columns of a row among those whose bit is set in `mask`, 32 columns to a word.
    pub(super) fn row_len_in(&self, row: usize, mask: &[u32]) -> usize {
        match self.form(row) {
            Form::List(list) => list.iter().filter(|&&column| has_bit(mask, column)).count(),
            Form::Bits(bits) => bits.iter().zip(mask).map(|(a, b)| (a & b).count_ones() as usize).sum(),
        }
    }

    /// Whether every column of row `inner` is one of row `outer`.
    pub(super) fn row_is_subset(&self, inner: usize, outer: usize) -> bool {
        match (self.form(inner), self.form(outer)) {
            (Form::List(a), Form::List(b)) => is_sublist(a, b),
            (Form::List(a), Form::Bits(b)) => a.iter().all(|&column| has_bit(b, column)),
            (Form::Bits(a), Form::Bits(b)) => a.iter().zip(b).all(|(a, b)| a & !b == 0),
            // Bits stand for more columns than any list holds.
            (Form::Bits(_), Form::List(_)) => false,
        }
    }

    /// The row's columns modulo 64, a bit for each: a row that holds all columns of another holds all its bits too.
    pub(super) fn row_signature(&self, row: usize) -> u64 {
        match self.form(row) {
            Form::List(list) => list.iter().fold(0, |all, column| all | 1 << (column % 64)),
            Form::Bits(bits) => {
                bits.iter().enumerate().fold(0, |all, (i, &word)| all | u64::from(word) << (i % 2 * 32))
            }
        }
    }

    /// The words that hold a row, equal for rows of equal content.
    pub(super) fn row_words(&self, row: usize) -> &[u32] {
        &self.rows[row]
    }

    /// Takes the union of a row with the same row of another incidence of equal size.
    pub(super) fn unite_row(&mut self, row: usize, other: &Self) {
        let n_words = self.n_words();
        match other.form(row) {
            Form::Bits(bits) if self.rows[row].len() == n_words => {
                self.rows[row].iter_mut().zip(bits).for_each(|(mine, theirs)| *mine |= theirs);
            }
            _ => other.row(row).for_each(|column| self.insert(row, column)),
        }
    }

    /// Replaces a row by the same row of another incidence of equal size, which is left undefined.
    pub(super) fn take_row(&mut self, row: usize, other: &mut Self) {
        std::mem::swap(&mut self.rows[row], &mut other.rows[row]);
    }

    /// The same relation read the other way: for each column its rows.
    pub fn transposed(&self) -> Self {
        let mut columns = Self::new(self.n_columns, self.n_rows());
        for row in 0..self.n_rows() {
            self.row(row).for_each(|column| columns.insert(column as usize, row as u32));
        }
        columns
    }

    fn n_words(&self) -> usize {
        self.n_columns.div_ceil(32)
    }

    #[inline]
    fn form(&self, row: usize) -> Form<'_> {
        let words = &self.rows[row];
        if words.len() == self.n_words() { Form::Bits(words) } else { Form::List(words) }
    }
}

enum Form<'a> {
    List(&'a [u32]),
    Bits(&'a [u32]),
}

enum Columns<'a> {
    List(Copied<Iter<'a, u32>>),
    /// `word` holds the bits still to report of the columns `end - 32..end`.
    Bits {
        rest: Copied<Iter<'a, u32>>,
        word: u32,
        end: u32,
    },
}

impl Iterator for Columns<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        match self {
            Self::List(list) => list.next(),
            Self::Bits { rest, word, end } => {
                while *word == 0 {
                    *word = rest.next()?;
                    *end += 32;
                }
                let column = *end - 32 + word.trailing_zeros();
                *word &= *word - 1;
                Some(column)
            }
        }
    }
}

/// Inserts into a sorted list; turns it into bits when it grows to the size of the bits.
fn insert_in_list(list: &mut Vec<u32>, column: u32, n_words: usize) {
    if list.last().is_none_or(|&last| last < column) {
        list.push(column);
    } else if let Err(place) = list.binary_search(&column) {
        list.insert(place, column);
    }
    if list.len() == n_words {
        let mut bits = vec![0; n_words];
        list.iter().for_each(|&column| bits[column as usize / 32] |= 1 << (column % 32));
        *list = bits;
    }
}

/// Whether the bit of a column is set.
pub(super) fn has_bit(bits: &[u32], column: u32) -> bool {
    bits[column as usize / 32] >> (column % 32) & 1 == 1
}

fn is_sublist(inner: &[u32], outer: &[u32]) -> bool {
    let mut rest = outer.iter();
    inner.len() <= outer.len()
        && inner.iter().all(|column| rest.find(|other| *other >= column) == Some(column))
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
            prop_assert_eq!(incidence.row_is_subset(0, 1), sets[0].is_subset(&sets[1]));
            prop_assert_eq!(incidence.row_is_subset(1, 0), sets[1].is_subset(&sets[0]));
            for (row, set) in sets.iter().enumerate() {
                let signature = set.iter().fold(0, |all, column| all | 1 << (column % 64));
                prop_assert_eq!(incidence.row_signature(row), signature);
            }
            prop_assert_eq!(incidence.transposed().transposed(), incidence);
        }
    }

    #[test]
    fn memory_of_a_row_is_bounded() {
        let incidence = Incidence::from_rows(5000, std::iter::once(0..5000));
        assert_eq!(incidence.rows[0].capacity(), 157);
        assert_eq!(Incidence::new(3, 0).transposed().n_rows(), 0);
    }
}
