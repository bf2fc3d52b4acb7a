use super::super::Incidence;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Greedy cover (Chvátal 1979): again and again the set that serves most of the unserved items, the lowest of
/// several; then without those that turned out to be superfluous.
///
/// Gains only fall, so a set that stays first with a fresh gain is the largest without a look at the others
/// (Minoux 1978).
pub(super) fn greedy(candidates: &Incidence, by_set: &Incidence) -> Vec<u32> {
    let mut unserved = all_with_candidates(candidates);
    let mut queue: BinaryHeap<(usize, Reverse<u32>)> =
        (0..by_set.n_rows()).map(|set| (by_set.row_len(set), Reverse(set as u32))).collect();
    let mut chosen = Vec::new();
    while let Some((stale, Reverse(set))) = queue.pop() {
        let gain = by_set.row_len_in(set as usize, &unserved);
        if gain == 0 {
            continue;
        }
        if gain < stale && queue.peek().is_some_and(|&next| next > (gain, Reverse(set))) {
            queue.push((gain, Reverse(set)));
            continue;
        }
        chosen.push(set);
        by_set.row(set as usize).for_each(|item| unserved[item as usize / 32] &= !(1 << (item % 32)));
    }
    without_superfluous(candidates.n_rows(), by_set, chosen)
}

fn all_with_candidates(candidates: &Incidence) -> Vec<u32> {
    let mut mask = vec![0; candidates.n_rows().div_ceil(32)];
    for item in (0..candidates.n_rows()).filter(|&item| candidates.row(item).next().is_some()) {
        mask[item / 32] |= 1 << (item % 32);
    }
    mask
}

/// Drops every set whose items are all served by others too, the last chosen first.
fn without_superfluous(n_items: usize, by_set: &Incidence, mut chosen: Vec<u32>) -> Vec<u32> {
    let mut n_serving = vec![0_u32; n_items];
    for &set in &chosen {
        by_set.row(set as usize).for_each(|item| n_serving[item as usize] += 1);
    }
    for i in (0..chosen.len()).rev() {
        let items = || by_set.row(chosen[i] as usize);
        if items().all(|item| n_serving[item as usize] > 1) {
            items().for_each(|item| n_serving[item as usize] -= 1);
            chosen.remove(i);
        }
    }
    chosen
}
