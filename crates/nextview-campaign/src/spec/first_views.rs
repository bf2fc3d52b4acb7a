use super::values::check_distinct;
use crate::seeds::FirstViewDraw;
use nextview_scan::{Fault, ScanConfig};
use serde::de::{Error, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};
use toml::Value;

/// The first views of the scans of an object, one per scan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum FirstViews {
    /// Numbers of the views among the candidates.
    List(Vec<usize>),
    /// This number of distinct views, drawn for each object and set of candidates.
    Count(usize),
}

impl FirstViews {
    /// Fails unless there is at least one view and no duplicate.
    pub(super) fn check(&self) -> Result<(), Fault> {
        match self {
            Self::List(views) => check_distinct("first_views", views),
            Self::Count(0) => Err(Fault::data("first_views is 0, expected at least 1")),
            Self::Count(_) => Ok(()),
        }
    }

    /// The number of views.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::List(views) => views.len(),
            Self::Count(n) => *n,
        }
    }

    /// The view with this index for an object with these candidates, and its draw if it is drawn.
    pub(crate) fn of(
        &self,
        place: usize,
        config: &ScanConfig,
        campaign_seed: u64,
        object: &str,
        view_seed: u64,
    ) -> Option<(usize, Option<FirstViewDraw>)> {
        match self {
            Self::List(views) => Some((*views.get(place)?, None)),
            Self::Count(_) => {
                let draw = FirstViewDraw::new(campaign_seed, object, view_seed, config.candidates, place);
                Some((draw.among(config.candidates)?, Some(draw)))
            }
        }
    }
}

impl Default for FirstViews {
    fn default() -> Self {
        Self::List(vec![0])
    }
}

impl<'de> Deserialize<'de> for FirstViews {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let number = |value: &Value| value.as_integer().and_then(|number| usize::try_from(number).ok());
        let value = Value::deserialize(deserializer)?;
        let views = match &value {
            Value::Array(views) => views.iter().map(number).collect::<Option<Vec<usize>>>().map(Self::List),
            value => number(value).map(Self::Count),
        };
        let expected = "a list of view numbers, or the number of views to draw";
        views.ok_or_else(|| D::Error::invalid_value(Unexpected::Other(value.type_str()), &expected))
    }
}
