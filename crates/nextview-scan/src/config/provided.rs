//! Planners written in Python, provided by a program that embeds it.

use crate::Fault;
use nextview::planner::{GreedyConfig, ViewPlanner};
use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;

/// Makes planners from Python classes; see [`provide_planners`].
pub trait PlannerProvider: Send + Sync {
    /// Fails if there is no such class, or if it makes no planners.
    fn check(&self, planner: &ProvidedPlanner) -> Result<(), Fault>;

    /// Builds a planner for one scan with this seed. The configuration is for classes that are gains.
    fn build(
        &self,
        planner: &ProvidedPlanner,
        config: GreedyConfig,
        seed: u64,
    ) -> Result<Box<dyn ViewPlanner>, Fault>;
}

static PROVIDER: OnceLock<Box<dyn PlannerProvider>> = OnceLock::new();

/// Registers the provider of Python planners for this process; later calls have no effect.
///
/// Without a provider, as in the program `nextview`, a configuration that names such a planner is rejected;
/// records of its scans remain readable.
pub fn provide_planners(provider: Box<dyn PlannerProvider>) {
    _ = PROVIDER.set(provider);
}

/// The name of a planner or a gain written in Python: `python:module:Class`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProvidedPlanner {
    module: String,
    class: String,
}

impl ProvidedPlanner {
    /// The prefix of such names.
    pub(crate) const PREFIX: &'static str = "python:";

    /// The dotted name of the module.
    pub fn module(&self) -> &str {
        &self.module
    }

    /// The name of the class in the module; dotted for a nested class.
    pub fn class(&self) -> &str {
        &self.class
    }

    pub(crate) fn check(&self) -> Result<(), Fault> {
        self.provider()?.check(self).map_err(of_planner)
    }

    pub(crate) fn build(&self, config: GreedyConfig, seed: u64) -> Result<Box<dyn ViewPlanner>, Fault> {
        self.provider()?.build(self, config, seed).map_err(of_planner)
    }

    fn provider(&self) -> Result<&'static dyn PlannerProvider, Fault> {
        PROVIDER.get().map(Box::as_ref).ok_or_else(|| {
            let fault = Fault::request(format!(
                "the planner {self} is written in Python, which this program cannot run"
            ));
            of_planner(fault).with_remedy("scan from Python: nextview.scan, nextview.Scan or nextview.bench")
        })
    }
}

fn of_planner(fault: Fault) -> Fault {
    Fault { key: Some("planner".to_owned()), ..fault }
}

impl fmt::Display for ProvidedPlanner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{}{}:{}", Self::PREFIX, self.module, self.class))
    }
}

impl FromStr for ProvidedPlanner {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let parts = name.strip_prefix(Self::PREFIX).and_then(|rest| rest.split_once(':'));
        match parts {
            Some((module, class)) if !module.is_empty() && !class.is_empty() && !class.contains(':') => {
                Ok(Self { module: module.to_owned(), class: class.to_owned() })
            }
            _ => Err(format!("unknown planner `{name}`, expected python:module:Class")),
        }
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for ProvidedPlanner {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ProvidedPlanner".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "The name of a planner, or of a gain, that is written in Python: `python:module:Class`.",
            "type": "string",
            "pattern": "^python:[^:]+:[^:]+$",
        })
    }
}
