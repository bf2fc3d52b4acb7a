use super::{PlannerName, PlannerProperties};
use crate::{Fault, ProvidedPlanner};
use serde::de::value::StringDeserializer;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// The planner that chooses the next view: one of the library, or one written in Python.
///
/// ```
/// use nextview_scan::{PlannerChoice, PlannerName, ScanConfig};
///
/// let config = ScanConfig { planner: PlannerName::Rse.into(), ..ScanConfig::default() };
/// assert_eq!(config.planner, PlannerName::Rse);
/// assert_eq!(config.planner.to_string(), "rse");
/// let text = "planner = \"python:my_planners:FromAbove\"";
/// // The library has no Python: a program that has one registers it.
/// assert!(ScanConfig::parse(text, None, None).is_err());
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlannerChoice {
    /// A planner of the library.
    BuiltIn(PlannerName),
    /// A planner written in Python.
    Provided(ProvidedPlanner),
}

impl PlannerChoice {
    /// The name, if the planner is one of the library.
    pub fn built_in(&self) -> Option<PlannerName> {
        match self {
            Self::BuiltIn(name) => Some(*name),
            Self::Provided(_) => None,
        }
    }

    /// What the planner needs, offers and reads.
    pub fn properties(&self) -> PlannerProperties {
        match self {
            Self::BuiltIn(name) => name.properties(),
            Self::Provided(_) => {
                PlannerProperties { section: Some("greedy"), ..PlannerProperties::default() }
            }
        }
    }

    /// Fails if a planner written in Python cannot be loaded.
    pub(super) fn check(&self) -> Result<(), Fault> {
        match self {
            Self::BuiltIn(_) => Ok(()),
            Self::Provided(planner) => planner.check(),
        }
    }
}

impl Default for PlannerChoice {
    fn default() -> Self {
        Self::BuiltIn(PlannerName::default())
    }
}

impl From<PlannerName> for PlannerChoice {
    fn from(name: PlannerName) -> Self {
        Self::BuiltIn(name)
    }
}

impl PartialEq<PlannerName> for PlannerChoice {
    fn eq(&self, name: &PlannerName) -> bool {
        self.built_in() == Some(*name)
    }
}

impl fmt::Display for PlannerChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuiltIn(name) => name.fmt(f),
            Self::Provided(planner) => planner.fmt(f),
        }
    }
}

impl Serialize for PlannerChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for PlannerChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        if text.starts_with(ProvidedPlanner::PREFIX) {
            return text.parse().map(Self::Provided).map_err(serde::de::Error::custom);
        }
        PlannerName::deserialize(StringDeserializer::new(text)).map(Self::BuiltIn)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for PlannerChoice {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "PlannerChoice".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "How the next view is chosen: by a planner of the library, or by one that is written in Python.",
            "anyOf": [generator.subschema_for::<PlannerName>(), generator.subschema_for::<ProvidedPlanner>()],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<PlannerChoice, String> {
        serde_json::from_value(text.into()).map_err(|error| error.to_string())
    }

    #[test]
    fn names_come_back_as_they_are() {
        for name in ["rse", "most-surface", "python:planners:FromAbove", "python:lab.planners:Outer.Inner"] {
            let planner = read(name).unwrap();
            assert_eq!(planner.to_string(), name);
            assert_eq!(serde_json::to_value(&planner).unwrap(), name);
            assert_eq!(planner.built_in().is_some(), !name.starts_with("python:"));
        }
    }

    #[test]
    fn what_is_no_name_is_refused() {
        assert!(read("fast").unwrap_err().contains("expected one of `most-surface`"));
        for name in ["python:", "python:planners", "python::FromAbove", "python:planners:", "python:a:b:c"] {
            let error = read(name).unwrap_err();
            assert_eq!(error, format!("unknown planner `{name}`, expected python:module:Class"));
        }
    }
}
