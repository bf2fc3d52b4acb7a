/// The value of each of many sets for each of many items.
///
/// An item counts with its largest value in any of the chosen sets; their joint value is the sum over the
/// items. If an item has one value in all its sets, this is weighted coverage.
///
/// ```
/// use nextview::flow::SetValues;
///
/// let values = SetValues::new(3, vec![vec![(0, 1.0), (1, 0.5)], vec![(1, 2.0)], vec![(2, 0.25)]]);
/// assert_eq!(values.value_of([0, 1]), 3.0);
/// assert_eq!(values.value_of(0..3), 3.25);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SetValues {
    n_items: usize,
    /// By set, in increasing order of the items; values are positive.
    rows: Vec<Vec<(u32, f32)>>,
}

impl SetValues {
    /// Creates the values from a row of items, each below `n_items`, and their values for every set. Values
    /// that are not positive and finite are ignored; for repeated items in a row, the largest value counts.
    ///
    /// # Panics
    /// If an item is out of range.
    pub fn new(n_items: usize, rows: Vec<Vec<(u32, f32)>>) -> Self {
        Self { n_items, rows: rows.into_iter().map(|row| tidied(row, n_items)).collect() }
    }

    /// Creates the values from [tidied](tidied) rows.
    pub(crate) fn of_tidied(n_items: usize, rows: Vec<Vec<(u32, f32)>>) -> Self {
        Self { n_items, rows }
    }

    /// Number of items.
    pub fn n_items(&self) -> usize {
        self.n_items
    }

    /// Number of sets.
    pub fn n_sets(&self) -> usize {
        self.rows.len()
    }

    /// Returns the items of a set in increasing order, and their values.
    pub fn row(&self, set: u32) -> &[(u32, f32)] {
        &self.rows[set as usize]
    }

    /// Returns the joint value of these sets.
    pub fn value_of(&self, sets: impl IntoIterator<Item = u32>) -> f64 {
        let mut selection = Selection::new(self);
        sets.into_iter().for_each(|set| _ = selection.add(set));
        selection.value()
    }

    /// Number of pairs of item and set.
    pub fn n_pairs(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }
}

/// Sorts a row by its items, each below `n_items`, and keeps only values that count.
///
/// # Panics
/// If an item is out of range.
pub(crate) fn tidied(mut row: Vec<(u32, f32)>, n_items: usize) -> Vec<(u32, f32)> {
    row.retain(|&(_, value)| value > 0.0 && value.is_finite());
    if !row.is_sorted_by(|a, b| a.0 < b.0) {
        row.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        row.dedup_by_key(|(item, _)| *item);
    }
    assert!(row.last().is_none_or(|&(item, _)| (item as usize) < n_items), "items below {n_items}");
    row
}

/// A selection of the sets, and how well it serves every item.
#[derive(Clone, Debug)]
pub struct Selection<'a> {
    pub(super) values: &'a SetValues,
    /// By item, its largest value in the selected sets.
    served: Vec<f32>,
}

impl<'a> Selection<'a> {
    /// Creates an empty selection.
    pub fn new(values: &'a SetValues) -> Self {
        Self { values, served: vec![0.0; values.n_items] }
    }

    /// Returns the value that this set would add to the selection. It never grows as sets are added, not even
    /// by rounding.
    pub fn gain(&self, set: u32) -> f64 {
        let more = |sum, &(item, value): &(u32, f32)| {
            sum + (value as f64 - self.served[item as usize] as f64).max(0.0)
        };
        self.values.row(set).iter().fold(0.0, more)
    }

    /// Adds a set and returns its gain.
    pub fn add(&mut self, set: u32) -> f64 {
        let gain = self.gain(set);
        for &(item, value) in self.values.row(set) {
            let served = &mut self.served[item as usize];
            *served = served.max(value);
        }
        gain
    }

    /// Returns the joint value of the selected sets.
    pub fn value(&self) -> f64 {
        self.served.iter().fold(0.0, |sum, &value| sum + value as f64)
    }

    /// By item, its largest value in the selected sets.
    pub(super) fn served(&self) -> &[f32] {
        &self.served
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_put_in_order() {
        let rows = vec![vec![(4, 1.0), (1, 0.5), (4, 3.0), (0, f32::NAN), (2, -1.0), (3, 0.0), (1, 0.25)]];
        let values = SetValues::new(5, rows);
        assert_eq!(values.row(0), [(1, 0.5), (4, 3.0)]);
        assert_eq!((values.n_items(), values.n_sets(), values.n_pairs()), (5, 1, 2));
    }

    #[test]
    fn the_value_of_a_selection_is_the_sum_of_its_gains() {
        let values = SetValues::new(3, vec![vec![(0, 1.0), (1, 2.0)], vec![(1, 3.0), (2, 1.0)], vec![]]);
        let mut selection = Selection::new(&values);
        assert_eq!([0, 1, 1, 2].map(|set| selection.add(set)), [3.0, 2.0, 0.0, 0.0]);
        assert_eq!((selection.value(), selection.served()), (5.0, [1.0, 3.0, 1.0].as_slice()));
        assert_eq!(SetValues::new(0, vec![]).value_of([]), 0.0);
    }
}
