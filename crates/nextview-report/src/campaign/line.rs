//! A curve of a figure with its numbers.

use crate::plot::{self, CurveMarker};
use crate::text::fixed;
use nextview_campaign::statistics::{Curve, Interval, MeasuredRun, Sample, Study, StudyVariant};
use rayon::prelude::*;

/// The number of styles of curves.
pub(crate) const N_STYLES: usize = 6;

const MARKERS: [CurveMarker; N_STYLES] = [
    CurveMarker::Circle,
    CurveMarker::Diamond,
    CurveMarker::Circle,
    CurveMarker::TriangleDown,
    CurveMarker::Diamond,
    CurveMarker::Cross,
];

/// A curve with its numbers.
#[derive(Clone)]
pub(crate) struct CurveLine {
    pub name: String,
    pub class: String,
    pub marker: CurveMarker,
    pub means: Vec<f64>,
    pub intervals: Vec<Option<Interval>>,
}

impl CurveLine {
    /// The line of a variant, with the style with this index.
    pub fn of_variant(i: usize, variant: &StudyVariant, of: Curve) -> Self {
        let style = i % N_STYLES;
        Self::new(&variant.name, &format!("v{style}"), MARKERS[style], &variant.curve(of))
    }

    fn new(name: &str, class: &str, marker: CurveMarker, samples: &[Sample]) -> Self {
        Self {
            name: name.to_owned(),
            class: class.to_owned(),
            marker,
            means: samples.iter().filter_map(Sample::mean).collect(),
            intervals: samples.par_iter().map(Sample::interval).collect(),
        }
    }

    /// Returns its name with the last mean.
    pub fn title(&self) -> String {
        let last = self.means.last().copied().unwrap_or_default();
        format!("{}: {} %", self.name, fixed(100.0 * last, 1))
    }

    /// Returns the curve of the drawing.
    pub fn curve(&self, with_band: bool, label: &str) -> plot::PlotCurve {
        let band = self.intervals.iter().enumerate().filter(|_| with_band);
        plot::PlotCurve {
            class: self.class.clone(),
            label: shortened(label),
            marker: self.marker,
            points: self.means.iter().enumerate().map(|(i, &value)| (i + 1, value)).collect(),
            band: band.filter_map(|(i, v)| v.map(|v| (i + 1, v.low, v.high))).collect(),
        }
    }

    /// A thin curve behind others.
    pub fn ghost(&self) -> plot::PlotCurve {
        plot::PlotCurve { class: "other".to_owned(), marker: CurveMarker::None, ..self.curve(false, "") }
    }
}

/// Random views and the clairvoyant planner on the objects of the campaign; empty for the entropy.
pub(crate) fn baselines(study: &Study, of: Curve) -> Vec<CurveLine> {
    let share = move |run: &MeasuredRun| match of {
        Curve::VoxelCoverage => Some(run.reachable_voxels? as f64 / run.object_voxels?.max(1) as f64),
        Curve::ReachableCoverage => Some(1.0),
        Curve::Entropy => None,
    };
    let scaled = |curve: &Option<Vec<f64>>, share: f64| -> Option<Vec<f64>> {
        Some(curve.as_ref()?.iter().map(|coverage| share * coverage).collect())
    };
    // They are the same for all variants; the variant with the most objects says most.
    let Some(variant) = study.variants.iter().max_by_key(|variant| variant.n_objects()) else {
        return Vec::new();
    };
    let clairvoyant = variant.curve_by(|run| scaled(&run.clairvoyant_curve, share(run)?));
    let random = variant.curve_by(|run| scaled(&run.random_curve, share(run)?));
    let lines = [
        CurveLine::new("clairvoyant (baseline)", "clairvoyant", CurveMarker::Triangle, &clairvoyant),
        CurveLine::new("random (baseline)", "random", CurveMarker::Square, &random),
    ];
    lines.into_iter().filter(|line| !line.means.is_empty()).collect()
}

/// A label of at most 26 letters.
pub(crate) fn shortened(label: &str) -> String {
    if label.chars().count() <= 26 {
        return label.to_owned();
    }
    label.chars().take(25).chain(['…']).collect()
}
