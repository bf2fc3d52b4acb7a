use super::scan_copy::ScanCopy;
use nextview::session::NextView;
use nextview_scan::{Measured, ScanConfig, ScanRecord, ScanState, short_name};

/// The source of a [scene](crate::live::LiveScene): a copy of a scan's current state, so that no frame waits
/// while the scene is made.
pub struct SceneSource {
    pub(super) copy: ScanCopy,
    pub(super) record: ScanRecord,
    pub(super) config: ScanConfig,
    pub(super) next: Option<NextView>,
}

impl SceneSource {
    /// Copies a scan and the next view, if there is one. Takes milliseconds.
    pub fn of_scan(scan: &ScanState<'_>, config: &ScanConfig, next: Option<NextView>) -> Self {
        let record = scan.record(config, Measured::Nothing).unwrap_or_else(|_| ScanRecord {
            object: short_name(&config.object),
            stop_reason: scan.stop_reason,
            steps: scan.steps.clone(),
            ..ScanRecord::default()
        });
        Self { copy: ScanCopy::of(scan), record, config: config.clone(), next }
    }
}
