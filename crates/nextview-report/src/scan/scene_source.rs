use super::scan_copy::ScanCopy;
use nextview::session::NextView;
use nextview_scan::{FinishedScan, Measured, ScanConfig, ScanRecord, short_name};

/// What a [scene](crate::live::LiveScene) shows: a scan as it stands, copied, so that no frame has to wait
/// while the scene is made.
pub struct SceneSource {
    pub(super) copy: ScanCopy,
    pub(super) record: ScanRecord,
    pub(super) config: ScanConfig,
    pub(super) next: Option<NextView>,
}

impl SceneSource {
    /// Of a scan and the view to take next, if there is one. Takes milliseconds.
    pub fn of_scan(scan: &FinishedScan<'_>, config: &ScanConfig, next: Option<NextView>) -> Self {
        let record = scan.record(config, Measured::Nothing).unwrap_or_else(|_| ScanRecord {
            object: short_name(&config.object),
            stop_reason: scan.stop_reason,
            steps: scan.steps.clone(),
            ..ScanRecord::default()
        });
        Self { copy: ScanCopy::of(scan), record, config: config.clone(), next }
    }
}
