use crate::deviation::{Deviation, PointVerdict};
use crate::patches::Patches;
use crate::record::DefectRecord;
use glam::DVec3;

/// Minimum number of points in a reported defect.
const FEWEST: usize = 12;

/// Quantile of the points' deviations that is a defect's deviation: the largest one would be that of noise.
const QUANTILE: f64 = 0.9;

/// Groups of points that deviate to the same side, each within a patch of another, by descending deviation.
pub(crate) fn defects(
    positions: &[DVec3],
    deviations: &[Deviation],
    tolerance: f64,
    patches: &Patches<'_>,
) -> Vec<DefectRecord> {
    let side = |i: usize| {
        (deviations[i].verdict(tolerance) == PointVerdict::Deviates).then_some(deviations[i].mean > 0.0)
    };
    let mut is_taken = vec![false; positions.len()];
    let mut defects = Vec::new();
    for first in 0..positions.len() {
        if is_taken[first] || side(first).is_none() {
            continue;
        }
        is_taken[first] = true;
        let mut group = vec![first];
        let mut next = 0;
        while next < group.len() {
            for i in patches.around(positions[group[next]]) {
                if !is_taken[i] && side(i) == side(first) {
                    is_taken[i] = true;
                    group.push(i);
                }
            }
            next += 1;
        }
        if group.len() >= FEWEST {
            defects.push(defect(&group, positions, deviations));
        }
    }
    defects.sort_by(|a, b| b.deviation_mm.abs().total_cmp(&a.deviation_mm.abs()));
    defects
}

fn defect(group: &[usize], positions: &[DVec3], deviations: &[Deviation]) -> DefectRecord {
    let center = group.iter().map(|i| positions[*i]).sum::<DVec3>() / group.len() as f64;
    let low = group.iter().fold(DVec3::INFINITY, |low, i| low.min(positions[*i]));
    let high = group.iter().fold(DVec3::NEG_INFINITY, |high, i| high.max(positions[*i]));
    let mut sorted = group.to_vec();
    sorted.sort_by(|a, b| deviations[*a].mean.abs().total_cmp(&deviations[*b].mean.abs()));
    let at = deviations[sorted[(QUANTILE * (sorted.len() - 1) as f64).round() as usize]];
    DefectRecord {
        center_m: center.to_array(),
        size_m: (high - low).to_array(),
        deviation_mm: 1e3 * at.mean,
        standard_error_mm: 1e3 * at.error,
        n_points: group.len(),
    }
}
