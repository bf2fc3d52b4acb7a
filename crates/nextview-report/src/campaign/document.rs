//! The report before it becomes HTML or Markdown. All strings are plain text.

use super::data_file::DataFile;
use crate::plot::Plot;

/// A page.
#[derive(Clone, Debug)]
pub(crate) struct Document {
    pub title: String,
    pub subtitle: String,
    pub sections: Vec<Section>,
    /// Values of the configuration and of the runs: variant, or nothing if all have it, parameter, value.
    pub setup: Vec<[String; 3]>,
}

/// A part of the page with a heading.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    pub title: String,
    pub blocks: Vec<Block>,
}

#[derive(Clone, Debug)]
pub(crate) enum Block {
    Text(String),
    Table(Table),
    Figure(Figure),
    /// Literal text, collapsed on the page: a title and the text.
    Aside(String, String),
}

/// The first column names the rows.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub caption: String,
    pub head: Vec<Column>,
    pub rows: Vec<Row>,
}

#[derive(Clone, Debug)]
pub(crate) struct Column {
    pub name: String,
    /// Whether it is right-aligned, as numbers are.
    pub is_number: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub cells: Vec<Cell>,
    /// Whether it is a total of the rows above.
    pub is_total: bool,
}

/// A value and a remark: its interval, the paper's number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cell {
    pub text: String,
    pub note: String,
    /// The numbers in the cell, by the column of a data file; empty if nothing was measured.
    pub values: Vec<(&'static str, String)>,
    /// The file that has these numbers, and the key of their row.
    pub row: Option<(DataFile, Vec<String>)>,
}

/// Drawings and their numbers.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    pub caption: String,
    /// A drawing of all curves; `None` if there are too many.
    pub overview: Option<Plot>,
    /// Small drawings with their titles.
    pub panels: Vec<(String, Plot)>,
    pub data: Table,
}

impl Column {
    pub fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), is_number: false }
    }

    pub fn number(name: impl Into<String>) -> Self {
        Self { name: name.into(), is_number: true }
    }
}

impl Row {
    pub fn new(cells: Vec<Cell>) -> Self {
        Self { cells, is_total: false }
    }

    pub fn total(cells: Vec<Cell>) -> Self {
        Self { cells, is_total: true }
    }
}

impl Cell {
    pub fn with_note(text: impl Into<String>, note: impl Into<String>) -> Self {
        Self { text: text.into(), note: note.into(), ..Self::default() }
    }

    /// Adds numbers for a file of data.
    pub fn with_values(mut self, values: impl IntoIterator<Item = (&'static str, String)>) -> Self {
        self.values.extend(values);
        self
    }

    /// Puts its numbers into the row of a file.
    pub fn in_row<const N: usize>(self, file: DataFile, key: [&str; N]) -> Self {
        Self { row: Some((file, key.map(str::to_owned).to_vec())), ..self }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), ..Self::default() }
    }
}

impl Table {
    /// Swaps rows and columns. All cells but the names must be numbers.
    pub fn transposed(self) -> Self {
        let mut lines: Vec<Vec<Cell>> = vec![self.head.into_iter().map(|c| c.name.into()).collect()];
        lines.extend(self.rows.into_iter().map(|row| row.cells));
        let n_columns = lines[0].len();
        let mut columns =
            (0..n_columns).map(|i| lines.iter().map(|line| line[i].clone()).collect::<Vec<Cell>>());
        let names = columns.next().unwrap_or_default().into_iter().map(|cell| cell.text);
        let head = names.enumerate().map(|(i, name)| Column { name, is_number: i > 0 }).collect();
        Self { caption: self.caption, head, rows: columns.map(Row::new).collect() }
    }
}
