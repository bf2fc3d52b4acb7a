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
        variants.extend(variant.expand(spec).map_err(|failure| failure.within(name()))?);
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
