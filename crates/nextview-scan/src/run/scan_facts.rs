use crate::{ScanConfig, SourceConfig, TableRule};
use nextview_recording::ReadOptions;

/// What a configuration states about the frames and their content: advice must not repeat it.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScanFacts {
    /// Options for reading recorded frames; `None` for other frames.
    pub read: Option<ReadOptions>,
    /// The section that can state the place of object and table; `None` for a simulation.
    pub section: Option<&'static str>,
    /// Whether a table is stated or must be found.
    pub has_table: bool,
}

impl ScanFacts {
    /// What this configuration states.
    pub fn of(config: &ScanConfig) -> Self {
        let (section, height) = match &config.source {
            SourceConfig::Simulated => (None, None),
            SourceConfig::Recording(recording) => (Some("recording"), recording.table_z_m),
            SourceConfig::Live(live) => (Some("live"), live.table_z_m),
        };
        let is_on_table = config.object_box.table != TableRule::None || config.turntable.is_some();
        Self {
            read: config.source.recording().map(|recording| recording.read.clone()),
            section,
            has_table: height.is_some() || is_on_table,
        }
    }
}
