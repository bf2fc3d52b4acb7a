//! Tables III, IV, V and VII: a few measures over two axes.
//!
//! Variants belong in one table if their configurations differ only in the parameters of its axes.

use super::axis::{GAMMA, HISTORY, METHOD, MULTI, ParameterAxis, Q_THRESH, THETA, configuration, remove};
use super::published::{self, COVERAGE, MOVEMENT, Published, TIME};
use crate::campaign::document::{Cell, Column, Row, Table};
use nextview_campaign::statistics::{Study, StudyVariant};
use serde_json::Value;

/// The measures over an axis, with a row for each measure and each value of the other axis.
pub(super) struct TableDefinition {
    number: &'static str,
    title: &'static str,
    rows: ParameterAxis,
    columns: ParameterAxis,
    measures: &'static [Published],
}

/// The tables, in the paper's order.
pub(super) const PARAMETER_TABLES: [TableDefinition; 4] = [
    TableDefinition {
        number: "III",
        title: "Multi-resolution ablation",
        rows: METHOD,
        columns: MULTI,
        measures: &[COVERAGE, TIME],
    },
    TableDefinition {
        number: "IV",
        title: "Weight of the flow and history",
        rows: HISTORY,
        columns: GAMMA,
        measures: &[COVERAGE],
    },
    TableDefinition {
        number: "V",
        title: "Threshold of multi-resolution",
        rows: METHOD,
        columns: Q_THRESH,
        measures: &[COVERAGE],
    },
    TableDefinition {
        number: "VII",
        title: "Weight of the robot's movement",
        rows: METHOD,
        columns: THETA,
        measures: &[COVERAGE, MOVEMENT],
    },
];

/// A variant's place in a table.
struct TablePosition<'s> {
    variant: &'s StudyVariant,
    /// The configuration without the axes' parameters.
    rest: Value,
    row: String,
    column: String,
}

impl TableDefinition {
    /// Returns the table; `None` if no row would have two columns.
    pub fn fill(&self, study: &Study) -> Option<Table> {
        let places: Vec<TablePosition<'_>> = study.variants.iter().filter_map(|v| self.place(v)).collect();
        let lines = lines(&places);
        let mut columns: Vec<&str> = lines.iter().flatten().map(|place| place.column.as_str()).collect();
        columns.sort_by(|a, b| by_value(a, b));
        columns.dedup();
        let mut head = [self.rows.name, "measure"].map(Column::text).to_vec();
        head.extend(columns.iter().map(|column| Column::number(format!("{} = {column}", self.columns.name))));
        let mut rows = Vec::new();
        for line in &lines {
            let is_alone = lines.iter().filter(|other| other[0].row == line[0].row).count() == 1;
            for published in self.measures {
                let mut cells = vec![line_name(line, is_alone).into(), published.0.name.into()];
                cells.extend(columns.iter().map(|column| self.cell(line, column, published)));
                rows.push(Row::new(cells));
            }
        }
        let caption = format!("Table {}. {}", self.number, self.title);
        (!rows.is_empty()).then_some(Table { caption, head, rows })
    }

    fn place<'s>(&self, variant: &'s StudyVariant) -> Option<TablePosition<'s>> {
        let mut rest = configuration(variant);
        let row = (self.rows.label)(&variant.planner, &rest)?;
        let column = (self.columns.label)(&variant.planner, &rest)?;
        self.rows.keys.iter().chain(self.columns.keys).for_each(|key| remove(&mut rest, key));
        Some(TablePosition { variant, rest, row, column })
    }

    fn cell(&self, row: &[&TablePosition<'_>], column: &str, (measure, name): &Published) -> Cell {
        let here = row.iter().filter(|place| place.column == column);
        let values = here.filter_map(|place| Some(measure.show(place.variant.mean(measure)?)));
        let text = values.collect::<Vec<_>>().join(" / ");
        published::cell(text, published::number(self.number, &row[0].row, column, name))
    }
}

/// Places that differ only in the column, row by row; rows with one column are left out.
fn lines<'p, 's>(places: &'p [TablePosition<'s>]) -> Vec<Vec<&'p TablePosition<'s>>> {
    let mut rows: Vec<Vec<&TablePosition<'_>>> = Vec::new();
    for place in places {
        let same = |row: &&mut Vec<&TablePosition<'_>>| row[0].row == place.row && row[0].rest == place.rest;
        match rows.iter_mut().find(same) {
            Some(row) => row.push(place),
            None => rows.push(vec![place]),
        }
    }
    rows.retain(|row| row.iter().any(|place| place.column != row[0].column));
    rows.sort_by(|a, b| a[0].row.cmp(&b[0].row).then(a[0].variant.name.cmp(&b[0].variant.name)));
    rows
}

/// The name of a line. Lines with the same row label differ in a parameter that the table does not show, and
/// are named after a variant.
fn line_name(line: &[&TablePosition<'_>], is_alone: bool) -> String {
    let TablePosition { row, variant, .. } = line[0];
    if is_alone { row.clone() } else { format!("{row} (as {})", variant.name) }
}

/// Numbers by value, words in reverse alphabetical order, so that "single" precedes "multi".
fn by_value(a: &str, b: &str) -> std::cmp::Ordering {
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => a.total_cmp(&b),
        _ => b.cmp(a),
    }
}
