use super::faults::without_place;
use super::label::{default_label, filled};
use super::paths::sets;
use super::sweep::{self, Sweep};
use super::values::check_distinct;
use super::{FaultList, FirstViews, Spec, VariantSpec};
use nextview_scan::{Fault, Faults, ScanConfig, ViewRule, merged};
use toml::{Table, Value};

/// A planner with its parameters, ready to run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variant {
    pub label: String,
    /// The configuration without object, seeds and first view.
    pub config: ScanConfig,
    pub seeds: Vec<u64>,
    pub view_seeds: Vec<u64>,
    pub first_views: FirstViews,
    /// Whether the configuration states the seed of the noise, which is then not derived.
    pub has_noise_seed: bool,
    /// Whether the configuration states the seed of the random baseline.
    pub has_baseline_seed: bool,
}

/// Keys that a variant cannot set, and what sets them.
const DECIDED_ELSEWHERE: [(&str, &str); 3] =
    [("object", "objects"), ("seed", "seeds"), ("first_view", "first_views")];

/// The key of the set of candidates, which `view_seeds` may set.
const VIEW_SEED: &str = "view_seed";

/// All combinations of the values swept by the variant with this index; the last key changes fastest. Missing
/// keys, seeds, sets of candidates and first views come from the specification. At most `most` combinations
/// are allowed.
pub(crate) fn expand(
    variant: &VariantSpec,
    index: usize,
    spec: &Spec,
    most: usize,
    faults: &mut FaultList,
) -> Vec<Variant> {
    let mut expansion = Expansion { variant, index, spec, sweeps: Vec::new(), faults };
    expansion.check_lists();
    expansion.sweeps = expansion.sweeps();
    if sweep::n_combinations(&expansion.sweeps) > most {
        expansion.refuse_combinations(most);
        return Vec::new();
    }
    let tables = sweep::combined(merged(spec.scan.clone(), variant.scan.clone()), &expansion.sweeps);
    tables.into_iter().filter_map(|table| expansion.variant(table)).collect()
}

/// A variant during expansion into the combinations of its swept values.
struct Expansion<'a> {
    variant: &'a VariantSpec,
    index: usize,
    spec: &'a Spec,
    sweeps: Vec<Sweep>,
    faults: &'a mut FaultList,
}

impl Expansion<'_> {
    fn seeds(&self) -> &[u64] {
        self.variant.seeds.as_ref().unwrap_or(&self.spec.seeds)
    }

    fn view_seeds(&self) -> Option<&Vec<u64>> {
        self.variant.view_seeds.as_ref().or(self.spec.view_seeds.as_ref())
    }

    fn first_views(&self) -> &FirstViews {
        self.variant.first_views.as_ref().unwrap_or(&self.spec.first_views)
    }

    fn refuse_combinations(&mut self, most: usize) {
        let (n, factors) = (sweep::n_combinations(&self.sweeps), sweep::factors(&self.sweeps));
        let n = if n == usize::MAX { "more than can be counted".to_owned() } else { n.to_string() };
        let message = format!("sweep gives {n} variants ({factors}), expected at most {most} more variants");
        let fault =
            Fault::data(message).with_remedy("sweep fewer values, or split it into several campaigns");
        self.add("sweep", fault);
    }

    fn check_lists(&mut self) {
        if let Some(seeds) = &self.variant.seeds {
            self.check("seeds", check_distinct("seeds", seeds));
        }
        if let Some(seeds) = &self.variant.view_seeds {
            self.check("view_seeds", check_distinct("view_seeds", seeds));
        }
        if let Some(views) = &self.variant.first_views {
            self.check("first_views", views.check());
        }
    }

    fn sweeps(&mut self) -> Vec<Sweep> {
        let (sweeps, faults) = sweep::of(&self.variant.sweep);
        for (key, fault) in faults {
            self.add(&format!("sweep.{key}"), fault);
        }
        sweeps
    }

    /// The variant with this configuration; `None` if it is invalid.
    fn variant(&mut self, table: Table) -> Option<Variant> {
        let has_view_seed = table.contains_key(VIEW_SEED);
        let has_noise_seed = sets(&table, "noise.seed");
        let has_baseline_seed = table.contains_key("baseline_seed");
        let config = match load(table) {
            Ok(config) => config,
            Err(faults) => {
                faults.iter().for_each(|fault| self.add_of_config(fault));
                return None;
            }
        };
        if let Err(fault) = check_views(&config) {
            self.add_of_config(&Fault { key: Some("views".to_owned()), ..fault });
        }
        if let Err(fault) = check_first_views(&config, self.first_views()) {
            self.add_of_list("first_views", self.variant.first_views.is_some(), fault);
        }
        if let Err(fault) = check_view_seeds(&config, self.view_seeds(), has_view_seed) {
            self.add_of_list("view_seeds", self.variant.view_seeds.is_some(), fault);
        }
        let template = self.variant.label.clone().unwrap_or_else(|| default_label(&self.sweeps));
        let label = filled(&template, &config);
        let label = label.map_err(|fault| self.add("label", fault)).ok()?;
        let (seeds, first_views) = (self.seeds().to_vec(), self.first_views().clone());
        let view_seeds = self.view_seeds().cloned().unwrap_or_else(|| vec![config.view_seed()]);
        Some(Variant { label, config, seeds, view_seeds, first_views, has_noise_seed, has_baseline_seed })
    }

    /// Adds a fault of a list at its place: in the variant, or else in the specification.
    fn add_of_list(&mut self, key: &str, is_own: bool, fault: Fault) {
        if is_own { self.add(key, fault) } else { self.faults.add(key, fault) }
    }

    /// Adds a fault of the configuration at the source of its key: the sweep, the variant, or the
    /// specification.
    fn add_of_config(&mut self, fault: &Fault) {
        let key = fault.key.as_deref().unwrap_or_default();
        let is_part = |sweep: &&Sweep| {
            key.strip_prefix(&sweep.key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        if let Some(sweep) = self.sweeps.iter().find(is_part) {
            let key = format!("sweep.{}", sweep.key);
            self.add(&key, fault.clone());
        } else if sets(&self.variant.scan, key) {
            self.add(&format!("scan.{key}"), fault.clone());
        } else if sets(&self.spec.scan, key) {
            self.faults.add(&format!("scan.{key}"), fault.clone());
        } else {
            let key = self.any_key();
            self.add(&key, fault.clone());
        }
    }

    /// A key that the variant sets, to report its place.
    fn any_key(&self) -> String {
        let Self { variant: VariantSpec { label, scan, sweep, .. }, .. } = self;
        let first = |name: &str, table: &Table| Some(format!("{name}.{}", table.keys().next()?));
        let label = label.as_ref().map(|_| "label".to_owned());
        label.or_else(|| first("scan", scan)).or_else(|| first("sweep", sweep)).unwrap_or_default()
    }

    fn check(&mut self, key: &str, result: Result<(), Fault>) {
        if let Err(fault) = result {
            self.add(key, fault);
        }
    }

    /// Adds a fault about this key of the variant.
    fn add(&mut self, key: &str, fault: Fault) {
        let name = match &self.variant.label {
            Some(label) => format!("variant {} ({label:?})", self.index + 1),
            None => format!("variant {}", self.index + 1),
        };
        self.faults.add(&format!("variant.{}.{key}", self.index), without_place(fault).within(name));
    }
}

/// The configuration; by default, all its seeds share their candidates.
fn load(mut table: Table) -> Result<ScanConfig, Faults> {
    let decided = DECIDED_ELSEWHERE.iter().filter(|(key, _)| table.contains_key(*key)).map(|(key, by)| {
        let message = format!("`{key}` cannot be set in [scan], `scan` or `sweep`: `{by}` sets it");
        Fault { key: Some((*key).to_owned()), ..Fault::data(message) }
    });
    let given = ["recording", "live"].into_iter().filter(|key| table.contains_key(*key));
    let single = given.map(|key| {
        let message = format!("`{key}` is for single scans: a campaign simulates its objects");
        Fault { key: Some(key.to_owned()), ..Fault::data(message) }
    });
    if let Some(faults) = Faults::of(decided.chain(single).collect()) {
        return Err(faults);
    }
    table.entry(VIEW_SEED).or_insert(Value::Integer(0));
    let mut config = ScanConfig::from_table(table)?;
    let n_candidates = config.view_space.rule().map_or(usize::MAX, |_| config.candidates);
    config.views = Some(config.max_views(n_candidates));
    Ok(config)
}

/// Candidates made by a rule have a known number before the run.
fn check_views(config: &ScanConfig) -> Result<(), Fault> {
    let (n, views) = (config.candidates, config.max_views(config.candidates));
    if config.view_space.rule().is_some() && (views == 0 || views > n) {
        return Err(Fault::data(format!("views is {views}, expected 1 to {n} (the candidates)")));
    }
    Ok(())
}

fn check_first_views(config: &ScanConfig, first_views: &FirstViews) -> Result<(), Fault> {
    let (n, has_rule) = (config.candidates, config.view_space.rule().is_some());
    match first_views {
        FirstViews::List(views) => {
            let outside = views.iter().find(|&&view| has_rule && view >= n);
            let fault = |view| Fault::data(format!("first view {view} is not among the {n} candidates"));
            outside.map_or(Ok(()), |view| Err(fault(view)))
        }
        FirstViews::Count(_) if !has_rule => {
            let file = &config.view_space.0;
            let message =
                format!("first_views is a number, but the number of candidates in {file} is not known yet");
            Err(Fault::data(message).with_remedy("list the first views by their numbers"))
        }
        FirstViews::Count(count) if *count > n => {
            Err(Fault::data(format!("first_views is {count}, expected 1 to {n} (the candidates)")))
        }
        FirstViews::Count(_) => Ok(()),
    }
}

/// Several sets of candidates need a rule that draws them, and a single key that sets them.
fn check_view_seeds(
    config: &ScanConfig,
    view_seeds: Option<&Vec<u64>>,
    has_view_seed: bool,
) -> Result<(), Fault> {
    let Some(view_seeds) = view_seeds else { return Ok(()) };
    if has_view_seed {
        let fault = Fault::data("view_seeds conflicts with a `view_seed` in [scan], `scan` or `sweep`");
        return Err(fault.with_remedy("remove one of them"));
    }
    if view_seeds.len() > 1 && config.view_space.rule() != Some(ViewRule::Shell) {
        let (n, space) = (view_seeds.len(), &config.view_space.0);
        let message =
            format!("view_seeds has {n} sets, but the candidates of {space} do not depend on a seed");
        return Err(Fault::data(message));
    }
    Ok(())
}
