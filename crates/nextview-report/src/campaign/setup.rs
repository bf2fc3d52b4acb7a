//! The setup of a campaign: objects, variants, parameters, failures.

use super::document::{Block, Cell, Column, Row, Section, Table};
use super::planner_section::other_sections;
use nextview_campaign::RunRecord;
use nextview_campaign::statistics::{Study, StudyVariant};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of list entries and of rows of failed runs.
const MAX_LISTED: usize = 200;

/// The configurations and hosts of the runs, collected record by record.
#[derive(Default)]
pub(crate) struct Setup {
    n_runs: usize,
    n_failed: usize,
    seeds: BTreeSet<u64>,
    view_seeds: BTreeSet<u64>,
    first_views: BTreeSet<usize>,
    hosts: BTreeSet<String>,
    builds: BTreeSet<String>,
    /// Rows of the first failed runs.
    failures: Vec<Row>,
    parameters: ParameterValues,
}

impl Setup {
    /// Adds a run.
    pub fn add(&mut self, run: &RunRecord) {
        self.n_runs += 1;
        self.seeds.insert(run.seed);
        self.view_seeds.insert(run.view_seed);
        self.first_views.insert(run.first_view);
        let host = &run.host;
        self.hosts.insert(format!("{} ({}, {} threads a run)", host.name, host.cpu, host.n_threads));
        self.builds.insert(run.build.to_string());
        self.parameters.add(run);
        if let Some(reason) = run.failure() {
            self.n_failed += 1;
            if self.failures.len() < MAX_LISTED {
                self.failures.push(failure(run, reason));
            }
        }
    }

    fn failures(&self) -> Option<Table> {
        let n = self.n_failed;
        let which = if n > MAX_LISTED { format!(": the first {MAX_LISTED} of {n}") } else { String::new() };
        (n > 0).then(|| Table {
            caption: format!("Failed runs, which are excluded below{which}"),
            head: ["variant", "object", "seed", "view seed", "first view", "reason"]
                .map(Column::text)
                .to_vec(),
            rows: self.failures.clone(),
        })
    }
}

/// The section.
pub(crate) fn section(setup: &Setup, study: &Study, torn: bool) -> Section {
    let mut blocks = vec![
        Block::Table(overview(setup, study)),
        Block::Table(variants(study, &setup.parameters)),
        Block::Aside(
            "Parameters that all runs share".to_owned(),
            listing(setup.parameters.shared(study.variants.len()), "\n"),
        ),
    ];
    blocks.extend(setup.failures().map(Block::Table));
    if torn {
        let text = "The last line of runs.jsonl was incomplete and was left out: the campaign may still be \
                    running.";
        blocks.insert(0, Block::Text(text.to_owned()));
    }
    Section { title: "What was run".to_owned(), blocks }
}

/// Rows for a file: variant, parameter and value. The variant is empty if all variants have the value.
pub(crate) fn rows(setup: &Setup, study: &Study) -> Vec<[String; 3]> {
    let n_variants = study.variants.len();
    let of_all = |(name, value)| [String::new(), name, value];
    let overview = facts(setup, study).into_iter().map(|(name, value)| of_all((name.to_owned(), value)));
    let of_variant = |variant: &StudyVariant| {
        let planner = ("planner".to_owned(), variant.planner.to_string());
        let own = setup.parameters.own(&variant.name, n_variants);
        let values = std::iter::once(planner).chain(own);
        values.map(|(name, value)| [variant.name.clone(), name, value]).collect::<Vec<_>>()
    };
    let of_variants = study.variants.iter().flat_map(of_variant);
    overview.chain(of_variants).chain(setup.parameters.shared(n_variants).into_iter().map(of_all)).collect()
}

fn overview(setup: &Setup, study: &Study) -> Table {
    let row = |(label, value): (&str, String)| Row::new(vec![label.into(), value.into()]);
    Table {
        caption: String::new(),
        head: vec![Column::text(""), Column::text("")],
        rows: facts(setup, study).into_iter().map(row).collect(),
    }
}

/// Facts about all runs together.
fn facts(setup: &Setup, study: &Study) -> Vec<(&'static str, String)> {
    let Setup { n_runs, n_failed, .. } = setup;
    let mut rows = vec![
        ("runs", format!("{} done, {n_failed} failed", n_runs - n_failed)),
        ("seeds", listed(&setup.seeds)),
        ("sets of candidates", listed(&setup.view_seeds)),
        ("first views", listed(&setup.first_views)),
        ("host", listed(&setup.hosts)),
        ("nextview", listed(&setup.builds)),
    ];
    let mut by_set = BTreeMap::<&str, Vec<&str>>::new();
    study.objects.iter().for_each(|object| by_set.entry(&object.data_set).or_default().push(&object.name));
    let objects = by_set.iter().map(|(set, names)| format!("{set} ({}): {}", names.len(), listed(names)));
    rows.insert(1, ("objects", objects.collect::<Vec<_>>().join("; ")));
    rows
}

/// The first values, and the number of the others.
fn listed<'a, T: ToString + 'a>(
    values: impl IntoIterator<Item = &'a T, IntoIter: ExactSizeIterator>,
) -> String {
    let values = values.into_iter();
    let n_more = values.len().saturating_sub(MAX_LISTED);
    let mut listed: Vec<String> = values.take(MAX_LISTED).map(T::to_string).collect();
    listed.extend((n_more > 0).then(|| format!("and {n_more} more")));
    listed.join(", ")
}

fn variants(study: &Study, parameters: &ParameterValues) -> Table {
    let row = |variant: &StudyVariant| {
        let own = listing(parameters.own(&variant.name, study.variants.len()), ", ");
        Row::new(vec![variant.name.as_str().into(), variant.planner.to_string().into(), own.into()])
    };
    Table {
        caption: "Variants".to_owned(),
        head: ["variant", "planner", "parameters that differ between variants"].map(Column::text).to_vec(),
        rows: study.variants.iter().map(row).collect(),
    }
}

fn failure(run: &RunRecord, reason: &str) -> Row {
    let numbers = [run.seed.to_string(), run.view_seed.to_string(), run.first_view.to_string()];
    let [seed, view_seed, first_view] = numbers;
    let cells = [&run.variant[..], &run.object, &seed, &view_seed, &first_view, reason];
    Row::new(cells.map(Cell::from).to_vec())
}

/// The values of all parameters in all runs, sorted by the parameter's name.
#[derive(Default)]
struct ParameterValues {
    /// Values by variant: one, or two if there are more.
    values: BTreeMap<String, BTreeMap<String, BTreeSet<String>>>,
}

impl ParameterValues {
    fn add(&mut self, run: &RunRecord) {
        for (key, value) in flat(run) {
            let by_variant = self.values.entry(key).or_default();
            if !by_variant.contains_key(&run.variant) {
                by_variant.insert(run.variant.clone(), BTreeSet::new());
            }
            if let Some(values) = by_variant.get_mut(&run.variant).filter(|values| values.len() < 2) {
                values.insert(value);
            }
        }
    }

    /// Values common to all runs.
    fn shared(&self, n_variants: usize) -> Vec<(String, String)> {
        let value = |by_variant: &BTreeMap<String, BTreeSet<String>>| {
            let all: BTreeSet<&String> = by_variant.values().flatten().collect();
            let first = all.first().map(|value| value.to_string());
            first.filter(|_| all.len() == 1 && by_variant.len() == n_variants)
        };
        self.values.iter().filter_map(|(key, of)| Some((key.clone(), value(of)?))).collect()
    }

    /// Values common to all runs of this variant but not to another variant, without the planner's name.
    fn own(&self, variant: &str, n_variants: usize) -> Vec<(String, String)> {
        let part = |(key, by_variant): (&String, &BTreeMap<String, BTreeSet<String>>)| {
            let own = by_variant.get(variant).filter(|own| own.len() == 1)?;
            let constant = by_variant.values().all(|values| values.len() == 1);
            let differs = by_variant.len() < n_variants || by_variant.values().any(|other| other != own);
            let value = own.first().filter(|_| constant && differs && key != "planner")?;
            Some((key.clone(), value.clone()))
        };
        self.values.iter().filter_map(part).collect()
    }
}

/// Parameters with their values, as text.
fn listing(parameters: Vec<(String, String)>, separator: &str) -> String {
    let parts: Vec<String> = parameters.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    parts.join(separator)
}

/// The parameters of a run as dotted names and values, without those of other planners.
fn flat(run: &RunRecord) -> Vec<(String, String)> {
    let mut config = serde_json::to_value(&run.config).unwrap_or_default();
    if let Value::Object(fields) = &mut config {
        other_sections(&run.config.planner).for_each(|section| drop(fields.remove(section)));
        if run.config.planner.properties().fixes_gamma
            && let Some(Value::Object(max_flow)) = fields.get_mut("max_flow")
        {
            max_flow.remove("gamma");
        }
    }
    let mut out = Vec::new();
    flatten("", &config, &mut out);
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
