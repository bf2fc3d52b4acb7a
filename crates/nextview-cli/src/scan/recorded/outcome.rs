use crate::scan::FinishedScan;
use crate::scan::finished::Measured;
use nextview::session::StepReport;
use nextview_recording::Recording;
use nextview_sim::accuracy::Accuracy;
use serde::Serialize;

/// The measures that only scans of recorded frames have.
#[derive(Debug, Serialize)]
pub(crate) struct RecordedOutcome {
    /// Names of the frames, in the order in which they were taken.
    pub frames: Vec<String>,
    /// Those of them that measured nothing in the box.
    pub blind_frames: Vec<String>,
    /// What was left out of the recording, and why.
    pub skipped: Vec<String>,
    /// What else is odd in it.
    pub notes: Vec<String>,
    /// Of all points measured in the box so far, after each frame; none where the truth is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Vec<Option<AccuracyMm>>>,
}

/// Distance of measured points from the true surface.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct AccuracyMm {
    pub accuracy_mean_mm: f64,
    pub accuracy_median_mm: f64,
    pub accuracy_p95_mm: f64,
}

impl From<Accuracy> for AccuracyMm {
    fn from(Accuracy { mean, median, p95 }: Accuracy) -> Self {
        Self { accuracy_mean_mm: 1e3 * mean, accuracy_median_mm: 1e3 * median, accuracy_p95_mm: 1e3 * p95 }
    }
}

impl RecordedOutcome {
    pub fn new(recording: &Recording, scan: &FinishedScan<Measured>) -> Self {
        let name = |report: &StepReport| {
            report.view.map_or_else(String::new, |view| recording.frames[view].name.clone())
        };
        let reports = || scan.steps.iter().map(|step| &step.report);
        let is_known = scan.steps.iter().any(|step| step.measures.truth.is_some());
        let accuracy = || scan.steps.iter().map(|step| step.measures.accuracy.map(AccuracyMm::from));
        Self {
            frames: reports().map(name).collect(),
            blind_frames: reports().filter(|report| report.update.n_hits == 0).map(name).collect(),
            skipped: recording.skipped.iter().map(|skipped| skipped.to_string()).collect(),
            notes: recording.notes.clone(),
            accuracy: is_known.then(|| accuracy().collect()),
        }
    }

    /// Label and value, for people.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let mut rows = Vec::new();
        if let Some(AccuracyMm { accuracy_mean_mm: mean, accuracy_median_mm: median, accuracy_p95_mm: p95 }) =
            self.accuracy.as_ref().and_then(|accuracy| *accuracy.last()?)
        {
            let value = format!("mean {mean:.2} mm, median {median:.2} mm, 95 % within {p95:.2} mm");
            rows.push(("distance to the truth", value));
        }
        if !self.skipped.is_empty() {
            rows.push(("left out", format!("{} (see above)", self.skipped.len())));
        }
        if !self.blind_frames.is_empty() {
            rows.push(("nothing in the box", self.blind_frames.join(", ")));
        }
        rows
    }
}
