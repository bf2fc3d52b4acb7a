//! Table I: the coverage of every variant on every object, against the published one.

use super::published;
use crate::campaign::data_file::DataFile;
use crate::campaign::document::{Block, Cell, Column, Row, Section, Table};
use crate::campaign::statistic::with_median;
use nextview_campaign::statistics::measure::VOXEL_COVERAGE;
use nextview_campaign::statistics::{Study, mean};

/// Maximum number of objects with a row each: the page must open quickly.
const MAX_OBJECTS: usize = 1000;

/// The section.
pub(in crate::campaign) fn section(study: &Study) -> Section {
    let note = "Final voxel coverage in %, as in table I of the paper. The paper's columns are filled for \
                objects that can be matched: Stanford models by name, LINEMOD and HomebrewedDB by the \
                object's number, assuming that the paper's LMn is object n of the BOP benchmark. Its \
                averages here are over the matched objects; its published averages are in the last row.";
    let mut note = note.to_owned();
    if study.objects.len() > MAX_OBJECTS {
        note += &format!(" With more than {MAX_OBJECTS} objects, only the averages are shown.");
    }
    let table = Table { caption: String::new(), head: head(study), rows: rows(study) };
    Section {
        title: "Voxel coverage by object".to_owned(),
        blocks: vec![Block::Text(note), Block::Table(table)],
    }
}

fn head(study: &Study) -> Vec<Column> {
    let own = study.variants.iter().map(|variant| Column::number(&variant.name));
    let published = published::METHODS.map(|method| Column::number(format!("paper: {method}")));
    std::iter::once(Column::text("object")).chain(own).chain(published).collect()
}

fn rows(study: &Study) -> Vec<Row> {
    let columns = columns(study);
    let names: Vec<String> = head(study).into_iter().skip(1).map(|column| column.name).collect();
    let show = |value: Option<f64>| {
        let shown = value.map(|value| VOXEL_COVERAGE.show(value));
        let cell = Cell::from(shown.clone().unwrap_or_else(|| "–".to_owned()));
        cell.with_values(shown.map(|shown| ("voxel_coverage_percent", shown)))
    };
    let cells = |[set, object]: [&str; 2], values: Vec<Option<f64>>| -> Vec<Cell> {
        let cells = names.iter().zip(values);
        cells.map(|(name, value)| show(value).in_row(DataFile::Objects, [set, object, name])).collect()
    };
    let average = |set: &str, objects: &[usize]| {
        let of_column =
            |column: &Vec<Option<f64>>| mean(&objects.iter().filter_map(|&i| column[i]).collect::<Vec<_>>());
        cells([set, ""], columns.iter().map(of_column).collect())
    };
    let total =
        |label: String, cells: Vec<Cell>| Row::total(std::iter::once(label.into()).chain(cells).collect());
    let indices: Vec<usize> = (0..study.objects.len()).collect();
    let mut rows = Vec::new();
    for of_set in indices.chunk_by(|&a, &b| study.objects[a].data_set == study.objects[b].data_set) {
        let set = study.objects[of_set[0]].data_set.as_str();
        for &i in of_set.iter().filter(|_| study.objects.len() <= MAX_OBJECTS) {
            let object = &study.objects[i];
            let name = published::object(object).map(|name| format!("paper's {name}"));
            let name = Cell::with_note(object.name.as_str(), name.unwrap_or_default());
            let cells = cells([set, &object.name], columns.iter().map(|column| column[i]).collect());
            rows.push(Row::new(std::iter::once(name).chain(cells).collect()));
        }
        rows.push(total(format!("average of {set}"), average(set, of_set)));
    }
    let mut totals = average("", &indices);
    for (cell, variant) in totals.iter_mut().zip(&study.variants) {
        cell.note = with_median(&variant.sample(&VOXEL_COVERAGE), &VOXEL_COVERAGE).note;
    }
    rows.push(total("total average".to_owned(), totals));
    let blank = study.variants.iter().map(|_| Cell::default());
    let published =
        |method| show(published::number("I", "Total average", method, "coverage").map(|v| v / 100.0));
    let cells = blank.chain(published::METHODS.map(published)).collect();
    rows.push(total("the paper's, 49 objects".to_owned(), cells));
    rows
}

/// The values of all variants and of the paper's methods, by object.
fn columns(study: &Study) -> Vec<Vec<Option<f64>>> {
    let own = study.variants.iter().map(|variant| variant.by_object(&VOXEL_COVERAGE));
    let names: Vec<Option<String>> = study.objects.iter().map(published::object).collect();
    let published = published::METHODS.map(|method| {
        let number = |name: &Option<String>| published::number("I", name.as_ref()?, method, "coverage");
        names.iter().map(|name| number(name).map(|percent| percent / 100.0)).collect()
    });
    own.chain(published).collect()
}
