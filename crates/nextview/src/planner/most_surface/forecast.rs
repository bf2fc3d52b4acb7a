use super::setting::Setting;
use crate::Cancelled;
use glam::DVec3;

/// Number of views of a forecast.
const N_AHEAD: usize = 5;

/// Number of evenly spread views from which those after the next one are taken.
const N_AROUND: usize = 24;

/// Returns the total number of voxels expected to be newly seen after `chosen` and after each view that would
/// follow if nothing were learned on the way: each time, the one expected to add most among [`N_AROUND`]
/// evenly spread views. Rays are `ray_spacing` voxels apart.
pub(super) fn n_expected(
    scene: &Setting<'_>,
    chosen: usize,
    open: &[usize],
    ray_spacing: f64,
) -> Result<Vec<f64>, Cancelled> {
    let shown = scene.shown(&spread(scene, chosen, open), ray_spacing)?;
    // A voxel that several views show counts with the highest of their probabilities: where one view shows no
    // surface, there is mostly none for the others either.
    let mut best = vec![0.0_f32; scene.estimate.len()];
    let (mut n_expected, mut next) = (Vec::new(), 0);
    loop {
        for &(item, p) in &shown[next] {
            best[item as usize] = best[item as usize].max(p);
        }
        n_expected.push(best.iter().map(|&p| p as f64).sum());
        if n_expected.len() == N_AHEAD.min(shown.len()) {
            return Ok(n_expected);
        }
        let added = |&(item, p): &(u32, f32)| (p - best[item as usize]).max(0.0) as f64;
        let gains: Vec<f64> = shown.iter().map(|view| view.iter().map(added).sum()).collect();
        next = (0..gains.len()).max_by(|&a, &b| gains[a].total_cmp(&gains[b]).then(b.cmp(&a))).unwrap_or(0);
    }
}

/// The chosen view, and open views whose directions from the middle of the box are far apart: each is as far
/// as possible from those before it.
fn spread(scene: &Setting<'_>, chosen: usize, open: &[usize]) -> Vec<usize> {
    let (lattice, block) = (scene.snapshot.lattice(), scene.snapshot.block());
    let center = lattice.bounds(&block).center();
    let toward = |view: usize| -> DVec3 {
        (scene.situation.views().pose(view).translation() - center).normalize_or_zero()
    };
    let mut views = vec![chosen];
    // By open view, the largest cosine with a direction taken.
    let mut nearest = vec![-1.0_f64; open.len()];
    while views.len() < N_AROUND.min(open.len()) {
        let last = toward(views[views.len() - 1]);
        for (nearest, &view) in nearest.iter_mut().zip(open) {
            *nearest = nearest.max(toward(view).dot(last));
        }
        let is_taken = |i: usize| views.contains(&open[i]);
        let farthest = (0..open.len())
            .filter(|&i| !is_taken(i))
            .min_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(a.cmp(&b)));
        let Some(farthest) = farthest else { break };
        views.push(open[farthest]);
    }
    views
}
