use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The quantities behind a choice, by name; the names include the units.
///
/// Each planner chooses its own. They are for people and records: the library does not read them.
///
/// ```
/// use nextview::planner::Explanation;
///
/// let explanation = Explanation::from([("local_share", 0.25), ("flow_quality_nats", 130.0)]);
/// assert_eq!(explanation.get("local_share"), Some(0.25));
/// assert_eq!(explanation.iter().next(), Some(("flow_quality_nats", 130.0)));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct Explanation(BTreeMap<String, f64>);

impl Explanation {
    /// Returns the quantity with this name, if there is one.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    /// Returns all quantities with their names, in alphabetical order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(name, value)| (name.as_str(), *value))
    }
}

impl<const N: usize> From<[(&str, f64); N]> for Explanation {
    fn from(quantities: [(&str, f64); N]) -> Self {
        Self(quantities.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
    }
}
