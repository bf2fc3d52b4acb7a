use super::super::rows::Rows;

/// Rows that are all lists, so that loops need not check their form.
pub(super) struct Lists {
    columns: Vec<u32>,
    starts: Vec<u32>,
}

impl Lists {
    pub fn of(rows: &Rows) -> Self {
        let (mut columns, mut starts) = (Vec::new(), vec![0]);
        for row in rows.iter() {
            columns.extend(row.columns());
            starts.push(columns.len() as u32);
        }
        Self { columns, starts }
    }

    pub fn n_pairs(&self) -> usize {
        self.columns.len()
    }

    pub fn n_rows(&self) -> usize {
        self.starts.len() - 1
    }

    #[inline]
    pub fn row(&self, row: u32) -> &[u32] {
        let row = row as usize;
        &self.columns[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}
