use crate::workload::Workload;
use std::fmt;

/// The repeated and timed work.
pub type TimedWork<'a> = Box<dyn FnMut() + 'a>;

/// A stage on one case of the workload.
pub struct Stage {
    /// Name of the work, e.g. `insertion A; per end voxel`; without commas, which separate the fields of
    /// result lines.
    pub name: &'static str,
    /// The case, e.g. `5 mm`.
    pub case: String,
    /// Number of units, such as images, in one run of the work: times are per unit.
    pub n_units: usize,
    /// Makes the input; not timed.
    prepare: Preparation,
}

type Preparation = Box<dyn for<'a> Fn(&'a Workload) -> TimedWork<'a> + Send + Sync>;

impl Stage {
    pub(super) fn new(
        name: &'static str,
        case: impl Into<String>,
        n_units: usize,
        prepare: impl for<'a> Fn(&'a Workload) -> TimedWork<'a> + Send + Sync + 'static,
    ) -> Self {
        Self { name, case: case.into(), n_units, prepare: Box::new(prepare) }
    }

    /// Prepares the work on a workload.
    pub fn prepare<'a>(&self, workload: &'a Workload) -> TimedWork<'a> {
        (self.prepare)(workload)
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.name, self.case)
    }
}

/// A voxel size as named in cases.
pub(super) fn name_of(voxel_size: f64) -> String {
    let mm = (voxel_size * 1e3).round();
    if mm >= 10.0 { format!("{} cm", mm / 10.0) } else { format!("{mm} mm") }
}
