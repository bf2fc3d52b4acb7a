use crate::RunId;
use serde::Serialize;

/// An event of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CampaignEvent {
    /// It begins.
    Began {
        /// Objects of the campaign, or of the shard.
        n_objects: usize,
        /// Their runs.
        n_runs: usize,
        /// Those of them that were finished before.
        n_finished: usize,
    },
    /// A run is finished and its record is kept.
    RunFinished {
        /// Which one.
        run: RunId,
        /// The reason of a failure; none if it succeeded.
        failure: Option<String>,
    },
    /// All runs of an object are finished.
    ObjectFinished {
        /// Name of the object.
        object: String,
        /// Its runs, those that were finished before included.
        n_runs: usize,
        /// Those of them that failed.
        n_failed: usize,
    },
    /// Something worth knowing.
    Note(String),
}

/// Receives the events of a campaign, one after the other, from any of its threads.
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
