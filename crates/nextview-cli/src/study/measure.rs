//! What is read off a run: one number each.

use super::statistics::percentile;
use crate::bench::{Measures, RunRecord};
use crate::scan::ScanConfig;

/// A number that a run has, or a mean over runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure {
    /// With the unit it is shown in.
    pub name: &'static str,
    /// How many of the shown units one of the run's is.
    pub factor: f64,
    pub decimals: usize,
    /// Which way is better.
    pub better: Better,
    /// None where the run did not measure it.
    pub of: fn(&Done<'_>) -> Option<f64>,
}

/// Which way a number is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Better {
    Higher,
    Lower,
}

/// A run that was not given up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Done<'a> {
    pub config: &'a ScanConfig,
    pub measures: &'a Measures,
}

impl Measure {
    /// The number as it is shown, without its unit.
    pub fn show(&self, value: f64) -> String {
        // Plus zero turns a negative zero into zero.
        format!("{:.*}", self.decimals, self.factor * value + 0.0)
    }

    /// A difference as it is shown: with one digit more, and its sign.
    pub fn show_difference(&self, value: f64) -> String {
        format!("{:+.*}", self.decimals + 1, self.factor * value + 0.0).replace('-', "−")
    }
}

impl<'a> Done<'a> {
    /// The run, if it was not given up.
    pub fn of(run: &'a RunRecord) -> Option<Self> {
        let measures = super::campaign::measures(run).filter(|measures| !measures.steps.is_empty())?;
        Some(Self { config: &run.config, measures })
    }

    /// Voxel coverage, seen, or entropy after each view; after a scan that stopped early, the last value stays.
    pub fn curve(&self, of: Curve) -> Option<Vec<f64>> {
        let values = self.measures.steps.iter().map(|step| match of {
            Curve::VoxelCoverage => Some(step.voxel_coverage),
            Curve::Seen => step.seen,
            Curve::Entropy => Some(step.entropy_share),
        });
        let mut values = values.collect::<Option<Vec<f64>>>()?;
        let last = *values.last()?;
        values.resize(self.config.views.max(values.len()), last);
        Some(values)
    }

    /// Views until this share of the reachable object voxels was seen; one more than the run could take where it was not.
    pub fn views_to(&self, share: f64) -> Option<f64> {
        let curve = self.curve(Curve::Seen)?;
        Some((curve.iter().position(|&seen| seen >= share).unwrap_or(curve.len()) + 1) as f64)
    }

    /// Whether this share of the reachable object voxels was seen.
    pub fn reaches(&self, share: f64) -> bool {
        self.measures.steps.iter().any(|step| step.seen.is_some_and(|seen| seen >= share))
    }

    /// Milliseconds for each view that was planned; the first is given.
    pub fn plan_times(&self) -> impl Iterator<Item = f64> + use<'a> {
        self.measures.steps.iter().skip(1).map(|step| step.plan_time_ms)
    }

    /// Seconds for all decisions and for writing the images into the map.
    fn planning_time(&self) -> f64 {
        let mapping = self.measures.steps.iter().map(|step| step.map_time_ms);
        self.plan_times().chain(mapping).sum::<f64>() / 1e3
    }

    /// Seconds that a simulated robot is on the way; none in campaigns of old.
    fn moving_time(&self) -> Option<f64> {
        self.measures.steps.last()?.move_time_s
    }

    /// Seconds that it stands at views.
    fn sensing_time(&self) -> f64 {
        self.config.motion.sensing_time_s * self.measures.steps.len() as f64
    }
}

/// What is drawn over the number of views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Curve {
    VoxelCoverage,
    Seen,
    Entropy,
}

pub(crate) const VOXEL_COVERAGE: Measure = Measure {
    name: "voxel coverage, %",
    factor: 100.0,
    decimals: 1,
    better: Better::Higher,
    of: |run| run.measures.steps.last().map(|step| step.voxel_coverage),
};

pub(crate) const SEEN: Measure = Measure {
    name: "seen of reachable, %",
    factor: 100.0,
    decimals: 1,
    better: Better::Higher,
    of: |run| run.measures.steps.last().and_then(|step| step.seen),
};

/// What a run saw beyond the mean of random views from the same start.
pub(crate) const SEEN_BEYOND_RANDOM: Measure = Measure {
    name: "seen beyond random, points",
    of: |run| Some((SEEN.of)(run)? - *run.measures.random_curve.as_ref()?.last()?),
    ..SEEN
};

pub(crate) const SKILL: Measure =
    Measure { name: "skill", factor: 1.0, decimals: 2, better: Better::Higher, of: |run| run.measures.skill };

pub(crate) const SURFACE: Measure = Measure {
    name: "surface within 2 mm, %",
    factor: 100.0,
    decimals: 1,
    better: Better::Higher,
    of: |run| run.measures.steps.last().map(|step| step.surface_2mm),
};

pub(crate) const SURFACE_5MM: Measure = Measure {
    name: "surface within 5 mm, %",
    of: |run| run.measures.steps.last().map(|step| step.surface_5mm),
    ..SURFACE
};

/// Of the final cloud, as the next.
pub(crate) const ACCURACY: Measure = Measure {
    name: "accuracy of the cloud, mm",
    factor: 1.0,
    decimals: 2,
    better: Better::Lower,
    of: |run| run.measures.cloud.map(|cloud| cloud.accuracy_mean_mm),
};

pub(crate) const COMPLETENESS: Measure = Measure {
    name: "completeness of the cloud within 2 mm, %",
    of: |run| run.measures.cloud.map(|cloud| cloud.completeness_2mm),
    ..SURFACE
};

pub(crate) const VIEWS_TO_95: Measure = Measure {
    name: "views to 95 %",
    factor: 1.0,
    decimals: 1,
    better: Better::Lower,
    of: |run| run.views_to(0.95),
};

pub(crate) const PATH: Measure = Measure {
    name: "path length, m",
    factor: 1.0,
    decimals: 2,
    better: Better::Lower,
    of: |run| run.measures.steps.last().map(|step| step.path_length_m),
};

/// Of a run, the median over its views.
pub(crate) const PLAN_TIME: Measure = Measure {
    name: "planning time a view, ms",
    factor: 1.0,
    decimals: 1,
    better: Better::Lower,
    of: |run| percentile(&run.plan_times().collect::<Vec<_>>(), 0.5),
};

/// The mean, as in the paper's tables.
pub(crate) const COMPUTING_TIME: Measure = Measure {
    name: "computing time a view, s",
    factor: 1e-3,
    decimals: 3,
    better: Better::Lower,
    of: |run| super::statistics::mean(&run.plan_times().collect::<Vec<_>>()),
};

pub(crate) const MEMORY: Measure = Measure {
    name: "extra memory, MB",
    factor: 1.0,
    decimals: 1,
    better: Better::Lower,
    of: |run| run.measures.extra_memory_mb,
};

pub(crate) const PLANNING: Measure = Measure {
    name: "planning, s",
    factor: 1.0,
    decimals: 2,
    better: Better::Lower,
    of: |run| run.moving_time().map(|_| run.planning_time()),
};

pub(crate) const MOVING: Measure =
    Measure { name: "moving, s", decimals: 1, of: |run| run.moving_time(), ..PLANNING };

pub(crate) const SENSING: Measure = Measure {
    name: "sensing, s",
    decimals: 1,
    of: |run| run.moving_time().map(|_| run.sensing_time()),
    ..PLANNING
};

pub(crate) const RUNNING_TIME: Measure = Measure {
    name: "total, minutes",
    factor: 1.0 / 60.0,
    of: |run| Some(run.planning_time() + run.moving_time()? + run.sensing_time()),
    ..PLANNING
};
