//! The setup of a campaign: objects, variants, parameters, failures.

use super::document::{Block, Cell, Column, Row, Section, Table};
use nextview_campaign::RunRecord;
use nextview_campaign::statistics::{Study, StudyVariant};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// The section.
pub(crate) fn section(study: &Study<'_>, torn: bool) -> Section {
    let parameters = Parameters::new(study);
    let mut blocks = vec![
        Block::Table(overview(study)),
        Block::Table(variants(study, &parameters)),
        Block::Aside("Parameters that all runs share".to_owned(), parameters.shared_text()),
    ];
    blocks.extend(failures(study).map(Block::Table));
    if torn {
        let text = "The last line of runs.jsonl was not whole yet and was left out: \
                    the campaign may still be running.";
        blocks.insert(0, Block::Text(text.to_owned()));
    }
    Section { title: "What was run".to_owned(), blocks }
}

fn overview(study: &Study<'_>) -> Table {
    let runs = &study.runs;
    let n_failed = runs.iter().filter(|run| run.failure().is_some()).count();
    let host = |run: &&RunRecord| {
        format!("{} ({}, {} threads a run)", run.host.name, run.host.cpu, run.host.n_threads)
    };
    let mut rows = vec![
        ("runs", format!("{} done, {n_failed} failed", runs.len() - n_failed)),
        ("seeds", listed(runs.iter().map(|run| run.seed))),
        ("sets of candidates", listed(runs.iter().map(|run| run.view_seed))),
        ("first views", listed(runs.iter().map(|run| run.first_view))),
        ("host", listed(runs.iter().map(host))),
        ("nextview", listed(runs.iter().map(|run| run.build.to_string()))),
    ];
    let mut by_set = BTreeMap::<&str, Vec<&str>>::new();
    study.objects.iter().for_each(|object| by_set.entry(object.data_set).or_default().push(object.name));
    let objects = by_set.iter().map(|(set, names)| format!("{set} ({}): {}", names.len(), names.join(", ")));
    rows.insert(1, ("objects", objects.collect::<Vec<_>>().join("; ")));
    let row = |(label, value): (&str, String)| Row::new(vec![label.into(), value.into()]);
    Table {
        caption: String::new(),
        head: vec![Column::text(""), Column::text("")],
        rows: rows.into_iter().map(row).collect(),
    }
}

fn listed<T: Ord + ToString>(values: impl Iterator<Item = T>) -> String {
    let values: BTreeSet<T> = values.collect();
    values.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

fn variants(study: &Study<'_>, parameters: &Parameters) -> Table {
    let row = |variant: &StudyVariant<'_>| {
        let own = parameters.own(variant.name);
        Row::new(vec![variant.name.into(), variant.planner.to_string().into(), own.into()])
    };
    Table {
        caption: "Variants".to_owned(),
        head: ["variant", "planner", "parameters that differ between variants"].map(Column::text).to_vec(),
        rows: study.variants.iter().map(row).collect(),
    }
}

fn failures(study: &Study<'_>) -> Option<Table> {
    let row = |run: &&RunRecord| {
        let numbers = [run.seed.to_string(), run.view_seed.to_string(), run.first_view.to_string()];
        let [seed, view_seed, first_view] = numbers;
        let cells = [&run.variant[..], &run.object, &seed, &view_seed, &first_view, run.failure()?];
        Some(Row::new(cells.map(Cell::from).to_vec()))
    };
    let rows: Vec<Row> = study.runs.iter().filter_map(row).collect();
    (!rows.is_empty()).then(|| Table {
        caption: "Failed runs, which count nowhere below".to_owned(),
        head: ["variant", "object", "seed", "view seed", "first view", "reason"].map(Column::text).to_vec(),
        rows,
    })
}

/// The values of all parameters in all runs, sorted by the parameter's name.
struct Parameters {
    /// Values by variant.
    values: BTreeMap<String, BTreeMap<String, BTreeSet<String>>>,
    n_variants: usize,
}

impl Parameters {
    fn new(study: &Study<'_>) -> Self {
        let mut values = BTreeMap::<String, BTreeMap<String, BTreeSet<String>>>::new();
        for run in &study.runs {
            for (key, value) in flat(run) {
                values.entry(key).or_default().entry(run.variant.clone()).or_default().insert(value);
            }
        }
        Self { values, n_variants: study.variants.len() }
    }

    fn shared_text(&self) -> String {
        let value = |by_variant: &BTreeMap<String, BTreeSet<String>>| {
            let all: BTreeSet<&String> = by_variant.values().flatten().collect();
            let first = all.first().map(|value| value.to_string());
            first.filter(|_| all.len() == 1 && by_variant.len() == self.n_variants)
        };
        let line = |(key, by_variant)| Some(format!("{key} = {}", value(by_variant)?));
        self.values.iter().filter_map(line).collect::<Vec<_>>().join("\n")
    }

    /// Values that all runs of this variant share and those of another variant do not, without the planner's
    /// name.
    fn own(&self, variant: &str) -> String {
        let part = |(key, by_variant): (&String, &BTreeMap<String, BTreeSet<String>>)| {
            let own = by_variant.get(variant).filter(|own| own.len() == 1)?;
            let constant = by_variant.values().all(|values| values.len() == 1);
            let differs = by_variant.len() < self.n_variants || by_variant.values().any(|other| other != own);
            let value = own.first().filter(|_| constant && differs && key != "planner")?;
            Some(format!("{key} = {value}"))
        };
        let parts: Vec<String> = self.values.iter().filter_map(part).collect();
        parts.join(", ")
    }
}

/// The parameters of a run as names with dots and values.
fn flat(run: &RunRecord) -> Vec<(String, String)> {
    let mut out = Vec::new();
    flatten("", &serde_json::to_value(&run.config).unwrap_or_default(), &mut out);
    out
}

fn flatten(name: &str, value: &Value, out: &mut Vec<(String, String)>) {
    match value {
        Value::Object(fields) => {
            let dot = if name.is_empty() { "" } else { "." };
            fields.iter().for_each(|(key, value)| flatten(&format!("{name}{dot}{key}"), value, out));
        }
        Value::String(text) => out.push((name.to_owned(), text.clone())),
        value => out.push((name.to_owned(), value.to_string())),
    }
}
