//! What campaigns tell: the report of one, and the comparison of two. Both read `runs.jsonl` alone.

mod calibration;
mod campaign;
mod compare;
mod compare_text;
mod document;
mod figures;
mod html;
#[cfg(test)]
mod made_up;
mod markdown;
mod measure;
mod object_table;
mod paper;
mod paper_tables;
mod running_time;
mod setup;
mod statistics;
#[expect(clippy::module_inception, reason = "the study is what this module is about")]
mod study;
mod summary;

pub(crate) use campaign::Campaign;
pub(crate) use compare::compare;

use document::Document;
use study::Study;

/// The report of a campaign as HTML and as Markdown. Equal campaigns give equal bytes.
pub(crate) fn report(campaign: &Campaign) -> [String; 2] {
    let document = document(&Study::new(campaign));
    [html::render(&document), markdown::render(&document)]
}

fn document(study: &Study<'_>) -> Document {
    let (n_variants, n_objects) = (study.variants.len(), study.objects.len());
    let sections = [
        Some(setup::section(study)),
        Some(figures::section(study)).filter(|section| !section.blocks.is_empty()),
        Some(summary::section(study)),
        calibration::section(study),
        Some(object_table::section(study)),
        paper_tables::section(study),
    ];
    Document {
        title: study.campaign.name.clone(),
        subtitle: format!(
            "campaign of {} runs · {n_variants} variants · {n_objects} objects",
            study.campaign.runs.len()
        ),
        sections: sections.into_iter().flatten().collect(),
    }
}

#[cfg(test)]
mod tests;
