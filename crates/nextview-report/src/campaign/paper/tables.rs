//! Tables II to VII in the paper's form, if the campaign varies the same parameters.

use super::by_parameter::PARAMETER_TABLES;
use super::published::{self, MEMORY_II, Published, TIME};
use super::running_time;
use crate::campaign::data_file::DataFile;
use crate::campaign::document::{Block, Column, Row, Section, Table};
use nextview_campaign::statistics::{Study, StudyVariant};

/// The section; `None` if the campaign has no data for any of the tables.
pub(in crate::campaign) fn section(study: &Study) -> Option<Section> {
    let mut blocks = vec![by_method(study, "II", "Computational efficiency", &[MEMORY_II, TIME])];
    blocks.extend(PARAMETER_TABLES.iter().map(|definition| definition.fill(study)));
    let running_time = running_time::table(study);
    let running_time_note = running_time.as_ref().map(|_| running_time::NOTE).unwrap_or_default();
    blocks.insert(4, running_time);
    let mut blocks: Vec<Block> = blocks.into_iter().flatten().map(Block::Table).collect();
    if blocks.is_empty() {
        return None;
    }
    let note = "In brackets or below a value: the number that the paper published. Its times were measured \
                on the authors' computer (Intel Xeon E5-2640).";
    blocks.insert(0, Block::Text(format!("{note} {running_time_note}").trim_end().to_owned()));
    Some(Section { title: "The paper's tables".to_owned(), blocks })
}

/// A table with a column per variant; `None` if it includes none of the paper's methods.
fn by_method(study: &Study, number: &str, title: &str, measures: &[Published]) -> Option<Table> {
    let methods: Vec<Option<&str>> = study.variants.iter().map(|v| published::method(&v.planner)).collect();
    methods.iter().flatten().next()?;
    let row = |(measure, name): &Published| {
        let cell = |(variant, method): (&StudyVariant, &Option<&str>)| {
            let sample = variant.sample(measure);
            let text = sample.mean().map(|mean| measure.show(mean));
            let values =
                text.clone().map(|mean| [("value", mean), ("n_objects", sample.n_objects().to_string())]);
            let published = method.and_then(|method| published::number(number, "", method, name));
            published::cell(text.unwrap_or_default(), published)
                .with_values(values.into_iter().flatten())
                .in_row(DataFile::Statistics, [&variant.name, measure.name])
        };
        let cells = study.variants.iter().zip(&methods).map(cell);
        Row::new(std::iter::once(measure.name.into()).chain(cells).collect())
    };
    let names = study.variants.iter().map(|variant| Column::number(&variant.name));
    let table = Table {
        caption: format!("Table {number}. {title}"),
        head: std::iter::once(Column::text("")).chain(names).collect(),
        rows: measures.iter().map(row).collect(),
    };
    // A page has room for about six variants side by side.
    Some(if study.variants.len() > 6 { table.transposed() } else { table })
}
