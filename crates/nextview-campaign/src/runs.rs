use crate::seeds::{FirstViewDraw, Repetition};
use crate::spec::{FaultList, Variant, expand};
use crate::{ObjectSpec, Spec};
use nextview_scan::{Fault, Faults, ScanConfig};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// A run to execute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// The identity of the run.
    pub id: RunId,
    /// Name of the folder of the object's file, or `builtin`.
    pub data_set: String,
    /// The configuration that determines it.
    pub config: ScanConfig,
    /// The draw of its first view, if the specification states only the number of first views.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) first_view_draw: Option<FirstViewDraw>,
}

/// The identity of a run within its campaign.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunId {
    /// Label of the planner and its parameters.
    pub variant: String,
    /// Name of the object.
    pub object: String,
    /// Seed from the specification's list: the number of a repetition with other random draws.
    pub seed: u64,
    /// Seed of the set of candidates.
    pub view_seed: u64,
    /// Number of the first view. The number of a drawn view counts the candidates as configured: if some of
    /// them do not exist, the number in the run's configuration differs.
    pub first_view: usize,
}

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { object, variant, seed, view_seed, first_view } = self;
        write!(f, "object {object}, variant {variant}, seed {seed}, ")?;
        write!(f, "view seed {view_seed}, first view {first_view}")
    }
}

/// The runs of a specification, sorted by object, variant, seed, view seed and first view. Each is created on
/// demand: a large campaign has more of them than fit into memory.
///
/// ```
/// use nextview_campaign::Spec;
///
/// let spec = "name = \"x\"\nobjects = [\"builtin:mug\"]\nseeds = [0, 1, 2]";
/// let runs = Spec::parse(spec, "".as_ref())?.runs()?;
/// assert_eq!(runs.len(), 3);
/// assert_eq!(runs.number(&runs.get(2).unwrap().id), Some(2));
/// # Ok::<(), nextview_scan::Faults>(())
/// ```
#[derive(Clone, Debug)]
pub struct Runs {
    campaign_seed: u64,
    objects: Vec<ObjectSpec>,
    variants: Vec<Variant>,
    /// The number of the first run of each variant among those of an object, and the total.
    firsts: Vec<usize>,
    n_of_object: usize,
    objects_by_name: BTreeMap<String, usize>,
    variants_by_label: BTreeMap<String, usize>,
}

impl Spec {
    /// Returns all runs; fails if they cannot be distinguished or configured.
    pub fn runs(&self) -> Result<Runs, Faults> {
        let mut faults = FaultList::default();
        let variants = check(self, &mut faults);
        faults.or(Runs::new(self, variants))
    }
}

impl Runs {
    fn new(spec: &Spec, variants: Vec<Variant>) -> Self {
        let mut n_of_object: usize = 0;
        let firsts = variants.iter().map(|variant| {
            let first = n_of_object;
            n_of_object = n_of_object.saturating_add(n_runs(variant));
            first
        });
        Self {
            campaign_seed: spec.seed,
            firsts: firsts.collect(),
            n_of_object,
            objects_by_name: spec.objects.iter().map(ObjectSpec::name).zip(0..).collect(),
            variants_by_label: variants.iter().map(|variant| variant.label.clone()).zip(0..).collect(),
            objects: spec.objects.clone(),
            variants,
        }
    }

    /// Returns the number of runs.
    pub fn len(&self) -> usize {
        self.objects.len().saturating_mul(self.n_of_object)
    }

    /// Returns whether there are no runs.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of runs of each object.
    pub fn n_of_object(&self) -> usize {
        self.n_of_object
    }

    /// Returns the run with this number, from 0.
    pub fn get(&self, number: usize) -> Option<Run> {
        let (object, rest) = (number.checked_div(self.n_of_object)?, number.checked_rem(self.n_of_object)?);
        let object = self.objects.get(object)?;
        let variant = self.firsts.partition_point(|&first| first <= rest) - 1;
        let (variant, rest) = (&self.variants[variant], rest - self.firsts[variant]);
        let name = object.name();
        let config = object.configure(&variant.config);
        let (n_views, n_sets) = (variant.first_views.len(), variant.view_seeds.len());
        let (seed, view_seed) =
            (variant.seeds[rest / n_views / n_sets], variant.view_seeds[rest / n_views % n_sets]);
        let (first_view, first_view_draw) =
            variant.first_views.of(rest % n_views, &config, self.campaign_seed, &name, view_seed)?;
        let repetition =
            Repetition { campaign_seed: self.campaign_seed, object: &name, seed, view_seed, first_view };
        let config = seeded(config, variant, repetition);
        let id = RunId { variant: variant.label.clone(), object: name, seed, view_seed, first_view };
        Some(Run { id, data_set: object.data_set(), config, first_view_draw })
    }

    /// Returns the number of a run; `None` if it does not belong to this campaign.
    pub fn number(&self, id: &RunId) -> Option<usize> {
        let object = *self.objects_by_name.get(&id.object)?;
        let number = *self.variants_by_label.get(&id.variant)?;
        let variant = &self.variants[number];
        let place = |list: &[u64], value: u64| list.iter().position(|&known| known == value);
        let (seed, set) = (place(&variant.seeds, id.seed)?, place(&variant.view_seeds, id.view_seed)?);
        let view_at = |place| {
            variant.first_views.of(place, &variant.config, self.campaign_seed, &id.object, id.view_seed)
        };
        let is_first = |place: &usize| view_at(*place).is_some_and(|(view, _)| view == id.first_view);
        let view = (0..variant.first_views.len()).find(is_first)?;
        let of_variant = (seed * variant.view_seeds.len() + set) * variant.first_views.len() + view;
        Some(object * self.n_of_object + self.firsts[number] + of_variant)
    }

    /// Iterates over all runs.
    pub fn iter(&self) -> impl Iterator<Item = Run> {
        (0..self.len()).filter_map(|number| self.get(number))
    }
}

/// Number of runs of a variant on an object.
fn n_runs(variant: &Variant) -> usize {
    let n_seeds = variant.seeds.len().saturating_mul(variant.view_seeds.len());
    n_seeds.saturating_mul(variant.first_views.len())
}

/// Maximum number of runs of a campaign: their places in its file are held in memory, 24 bytes each.
const MAX_RUNS: usize = 10_000_000;

/// Maximum number of variants of a campaign, including those of sweeps: each is a whole configuration.
const MAX_VARIANTS: usize = 10_000;

/// The variants that can be configured; faults of variants and objects are added to `faults`.
pub(crate) fn check(spec: &Spec, faults: &mut FaultList) -> Vec<Variant> {
    let variants = variants(spec, faults);
    check_number(spec, &variants, faults);
    check_objects(&spec.objects, faults);
    variants
}

/// The configuration with the seeds of the repetition; seeds stated in the specification stay unchanged.
fn seeded(config: ScanConfig, variant: &Variant, repetition: Repetition<'_>) -> ScanConfig {
    let mut config = ScanConfig {
        seed: repetition.planner_seed(),
        view_seed: Some(repetition.view_seed),
        first_view: repetition.first_view,
        ..config
    };
    if !variant.has_baseline_seed {
        config.baseline_seed = repetition.baseline_seed();
    }
    // Without errors, runs of several seeds share the truth of their object.
    if !variant.has_noise_seed && !config.noise.noise().is_none() {
        config.noise.seed = repetition.noise_seed();
    }
    config
}

/// Fails if there are more runs than a campaign can hold; checked before anything is created for each run.
fn check_number(spec: &Spec, variants: &[Variant], faults: &mut FaultList) {
    let n_of_object = variants.iter().fold(0, |n: usize, variant| n.saturating_add(n_runs(variant)));
    let n_objects = spec.objects.len();
    let n = n_of_object.saturating_mul(n_objects);
    if n <= MAX_RUNS {
        return;
    }
    let most = |number: fn(&Variant) -> usize| variants.iter().map(number).max().unwrap_or_default();
    let (seeds, sets) = (most(|of| of.seeds.len()), most(|of| of.view_seeds.len()));
    let (n_variants, first_views) = (variants.len(), most(|of| of.first_views.len()));
    let message = format!(
        "{n} runs ({n_objects} objects x {n_variants} variants x up to {seeds} seeds x {sets} view_seeds x \
         {first_views} first_views), expected at most {MAX_RUNS}"
    );
    faults.add_without_key(Fault::data(message).with_remedy("split it into several campaigns"));
}

fn variants(spec: &Spec, faults: &mut FaultList) -> Vec<Variant> {
    let mut variants: Vec<(usize, Variant)> = Vec::new();
    for (variant, i) in spec.variant.iter().zip(0..) {
        let most = MAX_VARIANTS - variants.len();
        variants.extend(expand(variant, i, spec, most, faults).into_iter().map(|variant| (i, variant)));
    }
    // Unreadable labels would seem to be equal.
    if faults.is_empty()
        && let Some((label, _, i)) = first_twice(variants.iter().map(|(i, variant)| (&variant.label, i)))
    {
        let fault = Fault::data(format!("two variants are labelled {label:?}"));
        let remedy = "give each its own label; {max_flow.gamma} in a label stands for that value";
        faults.add(&format!("variant.{i}.label"), fault.with_remedy(remedy));
    }
    variants.into_iter().map(|(_, variant)| variant).collect()
}

/// Objects with the same name could not be identified in the results.
fn check_objects(objects: &[ObjectSpec], faults: &mut FaultList) {
    let named = objects.iter().map(|object| (object.name(), &object.file));
    if let Some((name, first, second)) = first_twice(named) {
        let fault = Fault::data(format!("two objects are named {name:?}: {first} and {second}"));
        faults.add("objects", fault.with_remedy("write one as { file = \"...\", name = \"...\" }"));
    }
}

/// The first key that occurs twice, with both values.
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
    use std::collections::BTreeSet;
    use std::path::Path;

    fn ids(spec: &str) -> Vec<String> {
        let spec = Spec::parse(spec, Path::new("")).unwrap();
        let name = |run: Run| {
            let RunId { object, variant, seed, view_seed, first_view } = &run.id;
            let (campaign_seed, seed, view_seed, first_view) = (0, *seed, *view_seed, *first_view);
            let repetition = Repetition { campaign_seed, object, seed, view_seed, first_view };
            assert_eq!((run.config.seed, run.config.first_view), (repetition.planner_seed(), first_view));
            assert_eq!(run.config.baseline_seed, repetition.baseline_seed());
            assert_eq!(run.config.view_seed(), 0, "all seeds share their candidates");
            format!("{object} | {variant} | {seed} | {first_view}")
        };
        let runs = spec.runs().unwrap();
        let numbers = runs.iter().map(|run| runs.number(&run.id));
        assert!(numbers.eq((0..runs.len()).map(Some)) && runs.get(runs.len()).is_none());
        runs.iter().map(name).collect()
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

    fn runs_of(spec: &str) -> Vec<Run> {
        Spec::parse(spec, Path::new("")).unwrap().runs().unwrap().iter().collect()
    }

    #[test]
    fn every_combination_of_seeds_candidates_and_first_views_is_a_run() {
        let runs = runs_of(
            "name = \"x\"\nobjects = [\"a.ply\"]\nseeds = [4, 5]\nview_seeds = [0, 9]\nfirst_views = [7, 1]\n\
             [[variant]]\n[[variant]]\nlabel = \"once\"\nseeds = [0]\nview_seeds = [3]\nfirst_views = [2]",
        );
        let starts: Vec<(u64, u64, usize)> =
            runs.iter().map(|run| (run.id.seed, run.id.view_seed, run.id.first_view)).collect();
        let expected =
            [4, 5].iter().flat_map(|&seed| [(seed, 0, 7), (seed, 0, 1), (seed, 9, 7), (seed, 9, 1)]);
        assert_eq!(starts, expected.chain([(0, 3, 2)]).collect::<Vec<_>>());
        assert!(runs.iter().all(|run| run.config.view_seed == Some(run.id.view_seed)));
        let seeds: BTreeSet<u64> = runs.iter().map(|run| run.config.seed).collect();
        assert_eq!(seeds.len(), runs.len(), "each run has draws of its own");
    }

    #[test]
    fn a_number_of_first_views_draws_them_for_each_object() {
        let runs = runs_of(
            "name = \"x\"\nobjects = [\"a.ply\", \"b.ply\"]\nfirst_views = 3\n\
             [[variant]]\n[[variant]]\nscan.planner = \"rse\"",
        );
        let views: Vec<usize> = runs.iter().map(|run| run.id.first_view).collect();
        assert_eq!((views.len(), &views[..3], &views[6..9]), (12, &views[3..6], &views[9..]));
        assert_ne!(views[..3], views[6..9]);
    }

    #[test]
    fn planners_share_noise_and_baselines_and_objects_do_not() {
        let runs = runs_of(
            "name = \"x\"\nobjects = [\"a.ply\", \"b.ply\"]\n[scan.noise]\nmodel = \"d435i\"\n\
             [[variant]]\n[[variant]]\nscan.planner = \"rse\"",
        );
        let seeds = |run: &Run| [run.config.seed, run.config.noise.seed, run.config.baseline_seed];
        assert_eq!((seeds(&runs[0]), seeds(&runs[2])), (seeds(&runs[1]), seeds(&runs[3])));
        for (a, b) in seeds(&runs[0]).into_iter().zip(seeds(&runs[2])) {
            assert!(a != b && a > 0 && b > 0);
        }
    }

    #[test]
    fn sensors_decide_camera_and_noise() {
        use nextview::sensor::Sensor;
        let runs = runs_of(
            "name = \"x\"\nobjects = [\"a.ply\"]\nscan.sensor = \"d405\"\n[[variant]]\n\
             [[variant]]\nsweep.sensor = [\"l515\", \"phoxi-s\"]",
        );
        for (run, sensor) in runs.iter().zip([Sensor::D405, Sensor::L515, Sensor::PhoxiS]) {
            assert_eq!(run.config.camera, sensor.intrinsics());
            assert_eq!(run.config.noise.depth_range(), sensor.depth_range());
            assert!(run.config.noise.seed > 0);
        }
        assert_eq!(runs.len(), 3);
    }

    #[test]
    fn stated_seeds_stay() {
        let text = "name = \"x\"\nobjects = [\"a.ply\"]\nseeds = [0, 1]\n[scan]\nview_seed = 5\n\
                    baseline_seed = 6\nnoise = { model = \"d435i\", seed = 7 }";
        for run in runs_of(text) {
            assert_eq!((run.config.view_seed, run.id.view_seed), (Some(5), 5));
            assert_eq!((run.config.baseline_seed, run.config.noise.seed), (6, 7));
        }
        let swept = runs_of("name = \"x\"\nobjects = [\"a.ply\"]\n[[variant]]\nsweep.view_seed = [1, 2]");
        assert_eq!(swept.iter().map(|run| run.id.view_seed).collect::<Vec<_>>(), [1, 2]);
        let of_another_campaign = runs_of(&text.replace("seeds = [0, 1]", "seed = 1"));
        assert_ne!(of_another_campaign[0].config.seed, runs_of(text)[0].config.seed);
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
            for run in spec.runs().unwrap().iter() {
                let config = run.config;
                if !name.starts_with("paper-") {
                    assert_eq!(config.stop.progress, 0.0, "no run stops early");
                    continue;
                }
                assert_eq!((config.candidates, config.views, config.size_m), (5000, Some(10), Some(0.2)));
                assert_eq!(config.stop.entropy_share, Some(0.0), "no run stops early");
            }
        }
    }
}
