use super::super::rows::Rows;
use crate::{Cancel, Cancelled};

/// Greedy cover (Chvátal 1979): repeatedly takes the set that serves most unserved items, the lowest number
/// on ties, and finally drops superfluous sets.
pub(super) fn greedy(candidates: &Rows, by_set: &Rows, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
    let mut gains = by_set.lens();
    let mut by_gain = vec![Vec::new(); 1 + gains.iter().max().map_or(0, |&gain| gain as usize)];
    (0..by_set.n_rows()).for_each(|set| by_gain[gains[set] as usize].push(set as u32));
    let mut is_served = vec![false; candidates.n_rows()];
    let mut chosen = Vec::new();
    // Gains only fall. No set thus joins the sets of a gain once their turn has come, and one pass in
    // increasing order meets each while it is the lowest.
    for gain in (1..by_gain.len()).rev() {
        let mut sets = std::mem::take(&mut by_gain[gain]);
        sets.sort_unstable();
        for set in sets {
            cancel.check()?;
            let gain_now = gains[set as usize] as usize;
            if gain_now < gain {
                by_gain[gain_now].push(set);
                continue;
            }
            chosen.push(set);
            by_set.row(set as usize).columns().for_each(|item| {
                if !std::mem::replace(&mut is_served[item as usize], true) {
                    let others = candidates.row(item as usize).columns();
                    others.for_each(|other| gains[other as usize] -= 1);
                }
            });
        }
    }
    Ok(without_superfluous(candidates.n_rows(), by_set, &chosen))
}

/// Drops every set whose items are all served by others, the last chosen first.
fn without_superfluous(n_items: usize, by_set: &Rows, chosen: &[u32]) -> Vec<u32> {
    let mut n_serving = vec![0_u32; n_items];
    let items = |set: u32| by_set.row(set as usize).columns();
    chosen.iter().for_each(|&set| items(set).for_each(|item| n_serving[item as usize] += 1));
    let is_needed = |&set: &u32| {
        let needed = items(set).any(|item| n_serving[item as usize] == 1);
        if !needed {
            items(set).for_each(|item| n_serving[item as usize] -= 1);
        }
        needed
    };
    let mut needed: Vec<u32> = chosen.iter().rev().copied().filter(is_needed).collect();
    needed.reverse();
    needed
}
