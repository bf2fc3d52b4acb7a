use crate::RunId;
use serde::Serialize;

/// An event of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CampaignEvent {
    /// The campaign begins.
    Began {
        /// Number of objects of the campaign, or of the shard.
        n_objects: usize,
        /// Number of their runs.
        n_runs: usize,
        /// Number of runs finished before.
        n_finished: usize,
    },
    /// A run is finished and its record is stored.
    RunFinished {
        /// The run.
        run: RunId,
        /// The reason for a failure; `None` if it succeeded.
        failure: Option<String>,
    },
    /// All runs of an object are finished.
    ObjectFinished {
        /// Name of the object.
        object: String,
        /// Number of its runs, including those finished before.
        n_runs: usize,
        /// Number of failed runs.
        n_failed: usize,
    },
    /// A message for the user.
    Note(String),
}

/// Receives the events of a campaign, one at a time, from any of its threads.
pub type Listener<'a> = &'a (dyn Fn(CampaignEvent) + Sync);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_can_be_sent() {
        let ended = CampaignEvent::ObjectFinished { object: "mug".to_owned(), n_runs: 5, n_failed: 1 };
        let json = serde_json::to_string(&[ended, CampaignEvent::Note("x".to_owned())]).unwrap();
        assert_eq!(json, r#"[{"object-finished":{"object":"mug","n_runs":5,"n_failed":1}},{"note":"x"}]"#);
    }
}
