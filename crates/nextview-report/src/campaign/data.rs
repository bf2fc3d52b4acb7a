//! The numbers of all tables and figures of the report as CSV, by variant and measure.

use super::data_file::DataFile;
use super::document::{Block, Cell, Document, Table};
use nextview_scan::files::csv_field;
use std::collections::BTreeMap;

/// The files by name, with the columns that identify a row and those of its values.
const FILES: [(DataFile, &str, &[&str], &[&str]); 5] = [
    (
        DataFile::Statistics,
        "statistics.csv",
        &["variant", "measure"],
        &["value", "low", "high", "median", "deviation", "worst", "worst_object", "n_objects", "n_reaching"],
    ),
    (
        DataFile::Progress,
        "progress.csv",
        &["variant", "view"],
        &[
            "voxel_coverage_percent",
            "voxel_coverage_low_percent",
            "voxel_coverage_high_percent",
            "reachable_coverage_percent",
            "reachable_coverage_low_percent",
            "reachable_coverage_high_percent",
            "entropy_percent",
            "entropy_low_percent",
            "entropy_high_percent",
        ],
    ),
    (DataFile::Objects, "objects.csv", &["data_set", "object", "variant"], &["voxel_coverage_percent"]),
    (
        DataFile::Differences,
        "differences.csv",
        &["variant", "measure", "against"],
        &["mean", "low", "high", "median", "p", "n_objects", "better", "worse", "tied"],
    ),
    (
        DataFile::Estimates,
        "estimates.csv",
        &["variant", "views_ahead", "from_percent", "to_percent"],
        &[
            "n",
            "estimate_percent",
            "reachable_coverage_percent",
            "reachable_coverage_p10_percent",
            "reachable_coverage_p90_percent",
            "difference_points",
        ],
    ),
];

const SETUP: &str = "setup.csv";
const SETUP_COLUMNS: [&str; 3] = ["variant", "parameter", "value"];

/// The files by name, even those without rows.
pub(crate) fn render(document: &Document) -> Vec<(&'static str, String)> {
    let setup = document.setup.iter().map(|row| line(row.iter().map(String::as_str)));
    let setup = std::iter::once(line(SETUP_COLUMNS)).chain(setup).collect();
    let files = FILES.iter().map(|(file, name, keys, columns)| {
        let rows = rows(document, *file).into_iter().map(|(key, values)| {
            let value = |column: &&'static str| values.get(column).map_or("", String::as_str);
            line(key.iter().map(String::as_str).chain(columns.iter().map(value)))
        });
        (*name, std::iter::once(head(keys, columns)).chain(rows).collect())
    });
    std::iter::once((SETUP, setup)).chain(files).collect()
}

/// Returns whether a text is one of these files.
pub(crate) fn is_data(text: &str) -> bool {
    let is_file = FILES.iter().any(|(_, _, keys, columns)| text.starts_with(&head(keys, columns)));
    is_file || text.starts_with(&line(SETUP_COLUMNS))
}

fn head(keys: &[&str], columns: &[&str]) -> String {
    line(keys.iter().chain(columns).copied())
}

type DataRow = (Vec<String>, BTreeMap<&'static str, String>);

/// The rows of a file. Cells of several tables share a row; rows that share their first key are adjacent.
fn rows(document: &Document, file: DataFile) -> Vec<DataRow> {
    let mut places = BTreeMap::new();
    let mut rows: Vec<DataRow> = Vec::new();
    for cell in cells(document).filter(|cell| !cell.values.is_empty()) {
        let Some((_, key)) = cell.row.as_ref().filter(|(of, _)| *of == file) else { continue };
        let place = *places.entry(key).or_insert(rows.len());
        if place == rows.len() {
            rows.push((key.clone(), BTreeMap::new()));
        }
        for (column, value) in &cell.values {
            rows[place].1.entry(column).or_insert_with(|| value.clone());
        }
    }
    let mut firsts = BTreeMap::new();
    for (i, (key, _)) in rows.iter().enumerate() {
        firsts.entry(key[0].clone()).or_insert(i);
    }
    rows.sort_by_key(|(key, _)| firsts[&key[0]]);
    rows
}

fn cells(document: &Document) -> impl Iterator<Item = &Cell> {
    let blocks = document.sections.iter().flat_map(|section| &section.blocks);
    blocks.filter_map(table).flat_map(|table| &table.rows).flat_map(|row| &row.cells)
}

fn table(block: &Block) -> Option<&Table> {
    match block {
        Block::Table(table) => Some(table),
        Block::Figure(figure) => Some(&figure.data),
        Block::Text(_) | Block::Aside(..) => None,
    }
}

/// A line of CSV with a plain line feed. A dash on the page is an empty field.
fn line<'a>(fields: impl IntoIterator<Item = &'a str>) -> String {
    let field = |text: &'a str| if text == "–" { "".into() } else { csv_field(text) };
    fields.into_iter().map(field).collect::<Vec<_>>().join(",") + "\n"
}
