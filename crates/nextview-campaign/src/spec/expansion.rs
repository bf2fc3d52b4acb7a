use super::faults::without_place;
use super::label::{default_label, filled};
use super::paths::sets;
use super::sweep::{self, Sweep};
use super::values::check_distinct;
use super::{FaultList, Spec, VariantSpec};
use nextview_scan::{Fault, Faults, ScanConfig, merged};
use toml::{Table, Value};

/// A planner with its parameters, ready to run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variant {
    pub label: String,
    /// Object, seed and first view aside.
    pub config: ScanConfig,
    pub seeds: Vec<u64>,
    pub first_views: Vec<usize>,
}

/// Keys that are not for a variant to decide, and what decides them.
const DECIDED_ELSEWHERE: [(&str, &str); 3] =
    [("object", "objects"), ("seed", "seeds"), ("first_view", "first_views")];

/// All combinations of the values that a variant, which has this index, sweeps; the last key changes fastest.
/// Keys, seeds and first views are the specification's where the variant has none of its own.
pub(crate) fn expand(
    variant: &VariantSpec,
    index: usize,
    spec: &Spec,
    faults: &mut FaultList,
) -> Vec<Variant> {
    let mut expansion = Expansion { variant, index, spec, sweeps: Vec::new(), faults };
    expansion.check_lists();
    expansion.sweeps = expansion.sweeps();
    let tables = sweep::combined(merged(spec.scan.clone(), variant.scan.clone()), &expansion.sweeps);
    tables.into_iter().filter_map(|table| expansion.variant(table)).collect()
}

/// A variant on its way to the combinations of its swept values.
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

    fn first_views(&self) -> &[usize] {
        self.variant.first_views.as_ref().unwrap_or(&self.spec.first_views)
    }

    fn check_lists(&mut self) {
        if let Some(seeds) = &self.variant.seeds {
            self.check("seeds", check_distinct("seeds", seeds));
        }
        if let Some(views) = &self.variant.first_views {
            self.check("first_views", check_distinct("first_views", views));
        }
    }

    fn sweeps(&mut self) -> Vec<Sweep> {
        let (sweeps, faults) = sweep::of(&self.variant.sweep);
        for (key, fault) in faults {
            self.add(&format!("sweep.{key}"), fault);
        }
        sweeps
    }

    /// The variant of this configuration; none if it is none.
    fn variant(&mut self, table: Table) -> Option<Variant> {
        let config = match load(table) {
            Ok(config) => config,
            Err(faults) => {
                faults.iter().for_each(|fault| self.add_of_config(fault));
                return None;
            }
        };
        for view in self.first_views().to_vec() {
            let (key, result) = check_first_view(&config, view);
            match (key, result, self.variant.first_views.is_some()) {
                (_, Ok(()), _) => (),
                ("first_views", Err(fault), false) => self.faults.add("first_views", fault),
                ("first_views", Err(fault), true) => self.add("first_views", fault),
                (key, Err(fault), _) => self.add_of_config(&Fault { key: Some(key.to_owned()), ..fault }),
            }
        }
        let template = self.variant.label.clone().unwrap_or_else(|| default_label(&self.sweeps));
        let label = filled(&template, &config);
        let label = label.map_err(|fault| self.add("label", fault)).ok()?;
        let (seeds, first_views) = (self.seeds().to_vec(), self.first_views().to_vec());
        Some(Variant { label, config, seeds, first_views })
    }

    /// Adds a fault of the configuration where its key comes from: the sweep, the variant, or the
    /// specification.
    fn add_of_config(&mut self, fault: &Fault) {
        let key = fault.key.as_deref().unwrap_or_default();
        if self.sweeps.iter().any(|sweep| sweep.key == key) {
            self.add(&format!("sweep.{key}"), fault.clone());
        } else if sets(&self.variant.scan, key) {
            self.add(&format!("scan.{key}"), fault.clone());
        } else if sets(&self.spec.scan, key) {
            self.faults.add(&format!("scan.{key}"), fault.clone());
        } else {
            let key = self.any_key();
            self.add(&key, fault.clone());
        }
    }

    /// A key that the variant sets, to say where it stands.
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

/// The configuration; unless it says otherwise, all its seeds share their candidates.
fn load(mut table: Table) -> Result<ScanConfig, Faults> {
    let decided = DECIDED_ELSEWHERE.iter().filter(|(key, _)| table.contains_key(*key)).map(|(key, by)| {
        let message = format!("`{key}` is not for [scan], `scan` or `sweep`: `{by}` decides it");
        Fault { key: Some((*key).to_owned()), ..Fault::data(message) }
    });
    let recording = table.contains_key("recording").then(|| {
        let message = "`recording` is for single scans: a campaign simulates its objects";
        Fault { key: Some("recording".to_owned()), ..Fault::data(message) }
    });
    if let Some(faults) = Faults::of(decided.chain(recording).collect()) {
        return Err(faults);
    }
    table.entry("view_seed").or_insert(Value::Integer(0));
    let mut config = ScanConfig::from_table(table)?;
    let n_candidates = config.view_space.rule().map_or(usize::MAX, |_| config.candidates);
    config.views = Some(config.max_views(n_candidates));
    Ok(config)
}

/// Where a rule makes the candidates, their number is known before the run. Returns the key that decides,
/// too.
fn check_first_view(config: &ScanConfig, first_view: usize) -> (&'static str, Result<(), Fault>) {
    let n = config.candidates;
    let views = config.max_views(n);
    if config.view_space.rule().is_none() {
        ("first_views", Ok(()))
    } else if first_view >= n {
        let message = format!("first view {first_view} is none of the {n} candidates");
        ("first_views", Err(Fault::data(message)))
    } else if views == 0 || views > n {
        ("views", Err(Fault::data(format!("views is {views}, expected 1 to {n} (the candidates)"))))
    } else {
        ("views", Ok(()))
    }
}
