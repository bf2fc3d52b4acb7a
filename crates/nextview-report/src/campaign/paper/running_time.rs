//! Table VI in the paper's form: the running time of a scan by a robot.

use super::published;
use crate::campaign::data_file::DataFile;
use crate::campaign::document::{Cell, Column, Row, Table};
use nextview_campaign::statistics::measure::{MOVING, PLANNING, RUNNING_TIME, SENSING};
use nextview_campaign::statistics::{Measure, Study, StudyVariant, deviation};

/// The parts and their sum.
const PARTS: [Measure; 4] = [PLANNING, MOVING, SENSING, RUNNING_TIME];

/// The remark above the table.
pub(super) const NOTE: &str = "Running times of a simulated robot, mean and standard deviation over objects: \
                               planning and map updates as measured; moving around the object's sphere and \
                               sensing at each view with the limits of [motion]. The paper's times are of a \
                               real robot.";

/// The table, with a row per variant; `None` if all runs failed.
pub(super) fn table(study: &Study) -> Option<Table> {
    let variants = study.variants.iter().filter(|variant| variant.mean(&RUNNING_TIME).is_some());
    let rows: Vec<Row> = variants.map(row).collect();
    let head = PARTS.map(|part| Column::number(part.name));
    (!rows.is_empty()).then(|| Table {
        caption: "Table VI. Total running time".to_owned(),
        head: std::iter::once(Column::text("method")).chain(head).collect(),
        rows,
    })
}

fn row(variant: &StudyVariant) -> Row {
    let mut cells = PARTS.map(|part| with_spread(variant, &part));
    let published =
        published::method(&variant.planner).and_then(|method| published::number("VI", "", method, "minutes"));
    cells[PARTS.len() - 1].note = published.map(|value| format!("paper {value}")).unwrap_or_default();
    Row::new(std::iter::once(variant.name.as_str().into()).chain(cells).collect())
}

fn with_spread(variant: &StudyVariant, measure: &Measure) -> Cell {
    let sample = variant.sample(measure);
    let mean = sample.mean().map_or_else(|| "–".to_owned(), |mean| measure.show(mean));
    let deviation = deviation(&sample.object_means()).map(|deviation| measure.show(deviation));
    let text = deviation.as_ref().map_or(mean.clone(), |deviation| format!("{mean} ± {deviation}"));
    Cell::from(text)
        .with_values([("value", mean), ("n_objects", sample.n_objects().to_string())])
        .with_values(deviation.map(|deviation| ("deviation", deviation)))
        .in_row(DataFile::Statistics, [&variant.name, measure.name])
}
