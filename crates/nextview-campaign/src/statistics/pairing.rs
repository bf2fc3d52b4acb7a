use crate::{RunId, RunRecord};
use std::collections::BTreeMap;

/// A run of campaign A and the same of campaign B.
pub(super) type Pair<'a> = (&'a RunRecord, &'a RunRecord);

/// The runs of two campaigns, paired by their identity.
#[derive(Debug)]
pub(super) struct Pairing<'a> {
    /// In the order of identities.
    pub pairs: Vec<Pair<'a>>,
    pub only_in_a: Vec<&'a RunRecord>,
    pub only_in_b: Vec<&'a RunRecord>,
    /// Names of the variants that are compared: those of one name, or the only one of A with the only one of
    /// B.
    pub variants: Vec<(&'a str, &'a str)>,
}

impl<'a> Pairing<'a> {
    pub fn new(a: &[&'a RunRecord], b: &[&'a RunRecord]) -> Self {
        let (names_a, names_b) = (names(a), names(b));
        let mut variants: Vec<(&str, &str)> =
            names_a.iter().filter(|name| names_b.contains(name)).map(|name| (*name, *name)).collect();
        // The variant that runs of B have in A.
        let mut renamed = None;
        if let ([one_a], [one_b]) = (&names_a[..], &names_b[..])
            && one_a != one_b
        {
            renamed = Some(*one_a);
            variants.push((one_a, one_b));
        }
        let by_id = |runs: &[&'a RunRecord], variant: Option<&str>| -> BTreeMap<RunId, &'a RunRecord> {
            let id = |run: &RunRecord| match variant {
                Some(variant) => RunId { variant: variant.to_owned(), ..run.id() },
                None => run.id(),
            };
            runs.iter().map(|run| (id(run), *run)).collect()
        };
        let (a, b) = (by_id(a, None), by_id(b, renamed));
        let only = |own: &BTreeMap<RunId, &'a RunRecord>, other: &BTreeMap<RunId, &'a RunRecord>| {
            own.iter().filter(|(id, _)| !other.contains_key(*id)).map(|(_, run)| *run).collect()
        };
        let (only_in_a, only_in_b) = (only(&a, &b), only(&b, &a));
        let pairs = a.iter().filter_map(|(id, run)| Some((*run, *b.get(id)?))).collect();
        Self { pairs, only_in_a, only_in_b, variants }
    }
}

fn names<'a>(runs: &[&'a RunRecord]) -> Vec<&'a str> {
    let mut names: Vec<&str> = runs.iter().map(|run| run.variant.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    names
}
