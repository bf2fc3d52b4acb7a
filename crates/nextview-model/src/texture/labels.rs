//! Assigns a photo to each triangle.

use super::sight::PhotoSight;
use nextview::{Cancel, Cancelled};
use rayon::prelude::*;

/// Number of rounds in which qualities spread to neighbours, and in which triangles follow their neighbours.
const N_ROUNDS: usize = 10;

/// Value of a neighbour with the same photo, as a share of the best quality.
const TOGETHER: f32 = 0.5;

/// Returns the photo of each triangle; `None` if no photo sees it.
///
/// It first takes the best quality averaged over neighbours, for large charts; then, in rounds, the photo
/// that suits the neighbours best. The first photo wins ties.
pub(super) fn best_photos(
    sights: &[PhotoSight],
    neighbors: &[Vec<u32>],
    cancel: &Cancel,
) -> Result<Vec<Option<usize>>, Cancelled> {
    let spread = |sight: &PhotoSight| spread(&sight.quality, neighbors, cancel);
    let spread: Vec<Vec<f32>> = sights.par_iter().map(spread).collect::<Result<_, _>>()?;
    let seen = |i: usize| (0..sights.len()).filter(move |photo| sights[*photo].quality[i] > 0.0);
    let best =
        |i: usize| seen(i).reduce(|best, next| if spread[next][i] > spread[best][i] { next } else { best });
    let mut labels: Vec<Option<usize>> = (0..neighbors.len()).map(best).collect();
    let most: Vec<f32> =
        (0..neighbors.len()).map(|i| labels[i].map_or(1.0, |best| spread[best][i])).collect();
    for _ in 0..N_ROUNDS {
        cancel.check()?;
        let mut n_changed = 0;
        for i in 0..neighbors.len() {
            let Some(current) = labels[i] else { continue };
            let worth = |photo: usize| {
                let n_same =
                    neighbors[i].iter().filter(|other| labels[**other as usize] == Some(photo)).count();
                spread[photo][i] / most[i] + TOGETHER * n_same as f32
            };
            let others = neighbors[i].iter().filter_map(|other| labels[*other as usize]);
            let others = others.filter(|photo| sights[*photo].quality[i] > 0.0);
            let better = |best, next| if worth(next) > worth(best) { next } else { best };
            let chosen = others.fold(current, better);
            n_changed += usize::from(chosen != current);
            labels[i] = Some(chosen);
        }
        if n_changed == 0 {
            break;
        }
    }
    Ok(labels)
}

/// Returns qualities averaged over ever more neighbours.
fn spread(quality: &[f32], neighbors: &[Vec<u32>], cancel: &Cancel) -> Result<Vec<f32>, Cancelled> {
    let mut spread = quality.to_vec();
    for _ in 0..N_ROUNDS {
        cancel.check()?;
        let next = (0..spread.len()).map(|i| {
            let around: f32 = neighbors[i].iter().map(|other| spread[*other as usize]).sum();
            (spread[i] + around) / (1 + neighbors[i].len()) as f32
        });
        spread = next.collect();
    }
    Ok(spread)
}
