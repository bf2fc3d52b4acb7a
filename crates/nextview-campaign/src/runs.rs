use crate::spec::{FaultList, Variant, expand};
use crate::{ObjectSpec, Spec};
use nextview_scan::{Fault, Faults, ScanConfig};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// A run to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Which one it is.
    pub id: RunId,
    /// Name of the folder that the object's file is in, or `builtin`.
    pub data_set: String,
    /// Everything that decides it.
    pub config: ScanConfig,
}

/// The identity of a run within its campaign.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunId {
    /// Label of the planner and its parameters.
    pub variant: String,
    /// Name of the object.
    pub object: String,
    /// Seed of the random planner.
    pub seed: u64,
    /// Number of the view to begin with.
    pub first_view: usize,
}

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { object, variant, seed, first_view } = self;
        write!(f, "object {object}, variant {variant}, seed {seed}, first view {first_view}")
    }
}

impl Spec {
    /// All runs by object, variant, seed and first view, in this order of importance.
    pub fn runs(&self) -> Result<Vec<Run>, Faults> {
        let mut faults = FaultList::default();
        let runs = all(self, &mut faults);
        faults.or(runs)
    }
}

/// All runs as far as they can be configured; `faults` gets what is wrong.
pub(crate) fn all(spec: &Spec, faults: &mut FaultList) -> Vec<Run> {
    let variants = variants(spec, faults);
    check_objects(&spec.objects, faults);
    let of_object = |object: &ObjectSpec| -> Vec<Run> {
        variants.iter().flat_map(|variant| runs(object, variant)).collect()
    };
    spec.objects.iter().flat_map(of_object).collect()
}

/// The runs of a variant on an object.
fn runs(object: &ObjectSpec, variant: &Variant) -> Vec<Run> {
    let Variant { label, config, seeds, first_views } = variant;
    let config = object.configure(config);
    let run = |seed: u64, first_view: usize| Run {
        id: RunId { object: object.name(), variant: label.clone(), seed, first_view },
        data_set: object.data_set(),
        config: ScanConfig { seed, first_view, ..config.clone() },
    };
    let starts = seeds.iter().flat_map(|&seed| first_views.iter().map(move |&view| (seed, view)));
    starts.map(|(seed, first_view)| run(seed, first_view)).collect()
}

fn variants(spec: &Spec, faults: &mut FaultList) -> Vec<Variant> {
    let mut variants: Vec<(usize, Variant)> = Vec::new();
    for (variant, i) in spec.variant.iter().zip(0..) {
        variants.extend(expand(variant, i, spec, faults).into_iter().map(|variant| (i, variant)));
    }
    // Labels that could not be read would seem to be equal.
    if faults.is_empty()
        && let Some((label, _, i)) = first_twice(variants.iter().map(|(i, variant)| (&variant.label, i)))
    {
        let fault = Fault::data(format!("two variants are labelled {label:?}"));
        let remedy = "give each a label of its own; {max_flow.gamma} in it stands for that value";
        faults.add(&format!("variant.{i}.label"), fault.with_remedy(remedy));
    }
    variants.into_iter().map(|(_, variant)| variant).collect()
}

/// Objects of one name could not be identified in the results.
fn check_objects(objects: &[ObjectSpec], faults: &mut FaultList) {
    let named = objects.iter().map(|object| (object.name(), &object.file));
    if let Some((name, first, second)) = first_twice(named) {
        let fault = Fault::data(format!("two objects are named {name:?}: {first} and {second}"));
        faults.add("objects", fault.with_remedy("write one as { file = \"...\", name = \"...\" }"));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use std::path::Path;

    fn ids(spec: &str) -> Vec<String> {
        let spec = Spec::parse(spec, Path::new("")).unwrap();
        let name = |run: &Run| {
            let RunId { object, variant, seed, first_view } = &run.id;
            assert_eq!((run.config.seed, run.config.first_view), (*seed, *first_view));
            assert_eq!(run.config.view_seed(), 0, "all seeds share their candidates");
            format!("{object} | {variant} | {seed} | {first_view}")
        };
        spec.runs().unwrap().iter().map(name).collect()
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
        for (name, _) in builtin::list() {
            let spec = Spec::load(name, &[]).unwrap();
            assert_eq!(spec.name, name);
            assert_eq!(spec.objects.len(), 4, "the built-in objects");
            for run in spec.runs().unwrap() {
                let config = run.config;
                assert_eq!((config.candidates, config.views, config.size_m), (5000, Some(10), Some(0.2)));
                assert_eq!(config.stop.entropy_share, Some(0.0), "no run stops early");
            }
        }
    }
}
