//! The runs of a campaign.

use super::RunRecord;
use super::object::ObjectSpec;
use super::spec::Spec;
use super::variant::Variant;
use crate::Failure;
use crate::scan::ScanConfig;
use std::collections::BTreeMap;
use std::fmt;

/// A run to do.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    pub id: RunId,
    pub data_set: String,
    pub config: ScanConfig,
}

/// What tells a run from all others of its campaign.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RunId {
    pub object: String,
    pub variant: String,
    pub seed: u64,
    pub first_view: usize,
}

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { object, variant, seed, first_view } = self;
        write!(f, "object {object}, variant {variant}, seed {seed}, first view {first_view}")
    }
}

/// All runs of a specification, by object, variant, seed and first view, in this order of importance.
pub(super) fn runs(spec: &Spec) -> Result<Vec<Run>, Failure> {
    let variants = variants(spec)?;
    check_objects(&spec.objects)?;
    let mut runs = Vec::new();
    for object in &spec.objects {
        for Variant { label, config, seeds, first_views } in &variants {
            let config = object.configure(config);
            for (&seed, &first_view) in
                seeds.iter().flat_map(|seed| first_views.iter().map(move |v| (seed, v)))
            {
                let id = RunId { object: object.name(), variant: label.clone(), seed, first_view };
                let config = ScanConfig { seed, first_view, ..config.clone() };
                runs.push(Run { id, data_set: object.data_set(), config });
            }
        }
    }
    Ok(runs)
}

fn variants(spec: &Spec) -> Result<Vec<Variant>, Failure> {
    let mut variants: Vec<Variant> = Vec::new();
    for (variant, number) in spec.variant.iter().zip(1..) {
        let name = || match &variant.label {
            Some(label) => format!("variant {number} ({label:?})"),
            None => format!("variant {number}"),
        };
        variants.extend(
            variant
                .expand(&spec.scan, &spec.seeds, &spec.first_views)
                .map_err(|failure| failure.within(name()))?,
        );
    }
    let labels = variants.iter().map(|variant| (variant.label.clone(), ()));
    match first_twice(labels) {
        Some((label, ..)) => Err(Failure::data(format!("two variants are labelled {label:?}"))
            .with_hint("give each a label of its own; {max_flow.gamma} in it stands for that value")),
        None => Ok(variants),
    }
}

/// Fails on objects that could not be told apart or be of no size.
fn check_objects(objects: &[ObjectSpec]) -> Result<(), Failure> {
    for object in objects {
        if let Some(size) = object.size_m.filter(|size| !(*size > 0.0 && size.is_finite())) {
            return Err(Failure::data(format!(
                "object {}: size_m is {size}, expected a positive number of metres",
                object.file
            )));
        }
    }
    match first_twice(objects.iter().map(|object| (object.name(), &object.file))) {
        Some((name, first, second)) => {
            Err(Failure::data(format!("two objects are named {name:?}: {first} and {second}"))
                .with_hint("write one as { file = \"...\", name = \"...\" }"))
        }
        None => Ok(()),
    }
}

/// The first key that comes twice, with the values of both.
fn first_twice<K: Ord, V: Clone>(entries: impl Iterator<Item = (K, V)>) -> Option<(K, V, V)> {
    let mut known = BTreeMap::new();
    for (key, value) in entries {
        if let Some(first) = known.get(&key) {
            let first: &V = first;
            return Some((key, first.clone(), value));
        }
        known.insert(key, value);
    }
    None
}

impl RunId {
    /// That of the run which this is the record of.
    pub fn of(record: &RunRecord) -> Self {
        Self {
            object: record.object.clone(),
            variant: record.variant.clone(),
            seed: record.seed,
            first_view: record.first_view,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::builtin;
    use super::*;

    fn ids(spec: &str) -> Vec<String> {
        let spec: Spec = toml::from_str(spec).unwrap();
        let name = |run: &Run| {
            let RunId { object, variant, seed, first_view } = &run.id;
            assert_eq!((run.config.seed, run.config.first_view), (*seed, *first_view));
            assert_eq!(run.config.view_seed(), 0, "all seeds share their candidates");
            format!("{object} | {variant} | {seed} | {first_view}")
        };
        runs(&spec).unwrap().iter().map(name).collect()
    }

    #[test]
    fn runs_come_by_object_variant_seed_and_first_view() {
        let spec = r#"
            name = "x"
            objects = ["b/two.ply", { file = "a/one.ply", name = "uno" }]
            first_views = [3, 1]
            [[variant]]
            scan.planner = "random"
            seeds = [5, 2]
            [[variant]]
            scan.planner = "apora"
            first_views = [0]
        "#;
        let of_object = |object: &str| {
            ["random | 5 | 3", "random | 5 | 1", "random | 2 | 3", "random | 2 | 1", "apora | 0 | 0"]
                .map(|run| format!("{object} | {run}"))
        };
        assert_eq!(ids(spec), [of_object("two"), of_object("uno")].concat());
    }

    #[test]
    fn sweeps_combine_and_fill_labels() {
        let spec = |label: &str| {
            format!(
                "name = \"x\"\nobjects = [\"a.ply\"]\n[[variant]]\n{label}\n\
                 sweep.\"max_flow.gamma\" = [0, 0.5]\nsweep.map.background = [\"carve\", \"ignore\"]\n"
            )
        };
        let background_first = ["carve, gamma 0", "carve, gamma 0.5", "ignore, gamma 0", "ignore, gamma 0.5"];
        let expected = background_first.map(|label| format!("a | most-surface, background {label} | 0 | 0"));
        assert_eq!(ids(&spec("")), expected);
        let label = "label = \"{max_flow.gamma} {map.background} of {candidates}\"";
        let expected = ["0 carve", "0.5 carve", "0 ignore", "0.5 ignore"];
        let mut found = ids(&spec(label));
        found.sort();
        let mut expected = expected.map(|label| format!("a | {label} of 1000 | 0 | 0"));
        expected.sort();
        assert_eq!(found, expected);
    }

    #[test]
    fn built_in_specifications_are_whole() {
        for name in builtin::names() {
            let spec = Spec::load(name, &[]).unwrap();
            assert_eq!(spec.name, name);
            assert_eq!(spec.objects.len(), 4, "the built-in objects");
            for run in runs(&spec).unwrap() {
                let config = run.config;
                assert_eq!((config.candidates, config.views, config.size_m), (5000, 10, Some(0.2)));
                assert_eq!(config.stop.entropy_share, Some(0.0), "no run stops early");
            }
        }
    }
}
