//! Few sets that serve all items: minimum set cover, one of Karp's 21 NP-complete problems (1972).

mod bound;
mod greedy;
mod lists;
mod local_search;
mod reduction;

use super::Incidence;
use super::rows::Rows;
use crate::{Cancel, Cancelled};
use bound::fewest_possible;
use greedy::greedy;
use lists::Lists;
use local_search::improve;
use reduction::Core;

/// Maximum number of edges between items and sets for which greedy cover is improved: more are too many to
/// visit even once.
const MAX_EDGES: usize = 2_000_000;

/// Returns a small number of sets that together contain a candidate of every item, in increasing order.
///
/// `candidates` holds a row of set numbers for each item; an item without candidates requires nothing. The
/// result is never larger than greedy cover's and so within a factor 1 + ln(items) of the fewest (Chvátal
/// 1979). It is usually the fewest itself: dominated items and sets are dropped, which often leaves nothing
/// to decide, and a local search works on the rest. The work is bounded by counting steps, not time, so equal
/// inputs give equal sets.
///
/// ```
/// use nextview::Cancel;
/// use nextview::flow::{Incidence, fewest_sets};
///
/// let candidates = Incidence::from_rows(5, [vec![0, 1], vec![1, 2], vec![2, 3], vec![3, 4]]);
/// assert_eq!(fewest_sets(&candidates, &Cancel::default()), Ok(vec![1, 3]));
/// ```
///
/// Fails if `cancel` is set.
pub fn fewest_sets(candidates: &Incidence, cancel: &Cancel) -> Result<Vec<u32>, Cancelled> {
    let candidates = packed(candidates, cancel)?;
    let core = Core::of(&candidates, cancel)?;
    let (rest, is_fewest) = few_sets(&core, cancel)?;
    let mut sets = core.chosen;
    sets.extend(rest.iter().map(|&set| core.set_ids[set as usize]));
    if !is_fewest {
        let plain = greedy(&candidates, &candidates.transposed(cancel)?, cancel)?;
        sets = if sets.len() <= plain.len() { sets } else { plain };
    }
    sets.sort_unstable();
    Ok(sets)
}

/// A small cover of the core, and whether it is proved to be the smallest.
fn few_sets(core: &Core, cancel: &Cancel) -> Result<(Vec<u32>, bool), Cancelled> {
    let start = greedy(&core.candidates, &core.by_set, cancel)?;
    let n_edges: usize = core.candidates.iter().map(|row| row.len()).sum();
    if n_edges > MAX_EDGES {
        return Ok((start, false));
    }
    let (candidates, by_set) = (Lists::of(&core.candidates), Lists::of(&core.by_set));
    cancel.check()?;
    let fewest = fewest_possible(&candidates, &by_set, start.len());
    let sets = improve(&candidates, &by_set, start, fewest, cancel)?;
    let is_fewest = sets.len() <= fewest;
    Ok((sets, is_fewest))
}

/// The rows of the items that require a set.
fn packed(candidates: &Incidence, cancel: &Cancel) -> Result<Rows, Cancelled> {
    let mut rows = Rows::new(candidates.n_columns());
    let all = (0..candidates.n_rows()).map(|item| candidates.words_of(item));
    for row in all.filter(|row| row.columns().next().is_some()) {
        cancel.check()?;
        rows.push(row);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn few(candidates: &Incidence) -> Vec<u32> {
        fewest_sets(candidates, &Cancel::default()).unwrap()
    }

    #[test]
    fn nothing_to_serve_needs_no_set() {
        assert!(few(&Incidence::new(0, 0)).is_empty());
        assert!(few(&Incidence::new(3, 0)).is_empty());
        assert!(few(&Incidence::new(3, 7)).is_empty());
    }

    #[test]
    fn equal_sets_resolve_to_the_lowest() {
        assert_eq!(few(&Incidence::from_rows(9, [vec![3, 5, 8], vec![8, 5, 3]])), [3]);
    }

    /// Greedy takes the middle set first and then needs two more.
    #[test]
    fn beats_greedy_where_greedy_is_wrong() {
        let rows = [vec![0, 2], vec![0, 2], vec![0], vec![1, 2], vec![1, 2], vec![1]];
        let candidates = Incidence::from_rows(3, rows);
        assert_eq!(few(&candidates), [0, 1]);
    }
}
