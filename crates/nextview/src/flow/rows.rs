use super::row::{Row, n_words, set_bit};
use crate::{Cancel, Cancelled};

/// Rows over the same columns, packed into one vector: an [`Incidence`](super::Incidence) that no longer
/// grows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Rows {
    words: Vec<u32>,
    /// Where each row starts, and the end.
    starts: Vec<usize>,
    n_columns: usize,
}

impl Rows {
    pub fn new(n_columns: usize) -> Self {
        Self { words: Vec::new(), starts: vec![0], n_columns }
    }

    pub fn n_rows(&self) -> usize {
        self.starts.len() - 1
    }

    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    #[inline]
    pub fn row(&self, row: usize) -> Row<'_> {
        Row::new(&self.words[self.starts[row]..self.starts[row + 1]], n_words(self.n_columns))
    }

    pub fn iter(&self) -> impl Iterator<Item = Row<'_>> {
        (0..self.n_rows()).map(|row| self.row(row))
    }

    /// Number of columns of each row.
    pub fn lens(&self) -> Vec<u32> {
        self.iter().map(|row| row.len() as u32).collect()
    }

    /// Adds a row over the same number of columns.
    pub fn push(&mut self, row: Row<'_>) {
        self.words.extend_from_slice(row.words());
        self.starts.push(self.words.len());
    }

    /// Returns the rows to keep.
    pub fn selected(&self, keep: &[bool]) -> Self {
        let mut selected = Self::new(self.n_columns);
        self.iter().zip(keep).filter(|(_, keep)| **keep).for_each(|(row, _)| selected.push(row));
        selected
    }

    /// Returns the transposed relation: for each column, its rows.
    ///
    /// Fails if `cancel` is set.
    pub fn transposed(&self, cancel: &Cancel) -> Result<Self, Cancelled> {
        let mut n_left = vec![0; self.n_columns];
        for row in self.iter() {
            cancel.check()?;
            row.columns().for_each(|column| n_left[column as usize] += 1);
        }
        let n_words = n_words(self.n_rows());
        let mut starts = vec![0];
        let ends = n_left.iter().scan(0, |end, &len: &usize| {
            *end += len.min(n_words);
            Some(*end)
        });
        starts.extend(ends);
        let mut words = vec![0; starts[self.n_columns]];
        let n_rows = self.n_rows();
        let mut next = starts.clone();
        for (row, columns) in self.iter().enumerate() {
            cancel.check()?;
            columns.columns().for_each(|column| {
                let column = column as usize;
                if n_left[column] < n_words {
                    words[next[column]] = row as u32;
                    next[column] += 1;
                } else {
                    set_bit(&mut words[starts[column]..], row as u32);
                }
            });
        }
        Ok(Self { words, starts, n_columns: n_rows })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Incidence;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn transposed_holds_the_same_pairs(
            n_columns in 1_usize..70,
            drawn in proptest::collection::vec(proptest::collection::vec(any::<u32>(), 0..70), 0..70),
        ) {
            let lists = drawn.iter().map(|list| list.iter().map(|i| i % n_columns as u32));
            let incidence = Incidence::from_rows(n_columns, lists);
            let mut rows = Rows::new(n_columns);
            (0..incidence.n_rows()).for_each(|row| rows.push(incidence.words_of(row)));
            let never = &Cancel::default();
            let transposed = rows.transposed(never).unwrap();
            prop_assert_eq!((transposed.n_rows(), transposed.n_columns()), (n_columns, rows.n_rows()));
            for (column, of_column) in transposed.iter().enumerate() {
                let holds = |row: &u32| rows.row(*row as usize).columns().any(|other| other == column as u32);
                let expected: Vec<u32> = (0..rows.n_rows() as u32).filter(holds).collect();
                prop_assert_eq!(of_column.columns().collect::<Vec<_>>(), expected);
            }
            prop_assert_eq!(transposed.transposed(never).unwrap(), rows);
        }
    }
}
