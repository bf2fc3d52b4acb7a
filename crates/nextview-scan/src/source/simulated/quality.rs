use crate::QualityMm;
use nextview_sim::quality::Quality;

/// A quality in the units of records.
pub(in crate::source) fn quality_mm(Quality { accuracy, completeness }: Quality) -> QualityMm {
    let [completeness_1mm, completeness_2mm, completeness_5mm] = completeness.within;
    QualityMm {
        accuracy_mean_mm: 1e3 * accuracy.mean,
        accuracy_median_mm: 1e3 * accuracy.median,
        accuracy_p95_mm: 1e3 * accuracy.p95,
        completeness_1mm,
        completeness_2mm,
        completeness_5mm,
        completeness_mean_mm: 1e3 * completeness.mean,
    }
}
