use super::Aabb;
use crate::{Cancel, Cancelled};
use glam::DVec3;
use std::array;

/// Maximum number of items in a leaf.
const LEAF: usize = 8;

/// A bounding volume hierarchy: items are halved recursively, with boxes around each part. An item is N
/// vectors; the first is its position.
#[derive(Clone, Debug, Default)]
pub(crate) struct BoxTree<const N: usize> {
    /// Items with their numbers. Those of a part are contiguous.
    items: Vec<([DVec3; N], usize)>,
    /// Bounding boxes of each of the N vectors in a part. The halves of part i are parts 2 i + 1 and 2 i + 2.
    parts: Vec<[Aabb; N]>,
}

/// A search in a tree.
pub(crate) trait Search<const N: usize> {
    /// Returns the rank of a part: the half with the lower rank is searched first.
    fn rank(&self, part: &[Aabb; N]) -> f64;

    /// Returns the rank above which a part is skipped.
    fn limit(&self) -> f64;

    /// Receives an item with its number.
    fn offer(&mut self, item: &[DVec3; N], number: usize);
}

impl<const N: usize> BoxTree<N> {
    /// Builds a tree of finite items, numbered from 0, unless cancelled.
    pub fn new(items: impl IntoIterator<Item = [DVec3; N]>, cancel: &Cancel) -> Result<Self, Cancelled> {
        let mut tree = Self { items: items.into_iter().zip(0..).collect(), parts: Vec::new() };
        arrange(&mut tree.items, 0, &mut tree.parts, cancel)?;
        Ok(tree)
    }

    /// Whether there are no items.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Offers the items of all parts that are not skipped.
    pub fn search(&self, search: &mut impl Search<N>) {
        self.search_part(&self.items, 0, search);
    }

    fn search_part(&self, items: &[([DVec3; N], usize)], part: usize, search: &mut impl Search<N>) {
        if items.len() <= LEAF {
            items.iter().for_each(|(item, number)| search.offer(item, *number));
            return;
        }
        let (before, behind) = items.split_at(items.len() / 2);
        let halves = [(before, 2 * part + 1), (behind, 2 * part + 2)];
        let mut halves = halves.map(|(half, part)| (search.rank(&self.parts[part]), half, part));
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (rank, half, part) in halves {
            if rank <= search.limit() {
                self.search_part(half, part, search);
            }
        }
    }
}

/// Halves the items recursively along the longest side of the box around their positions.
fn arrange<const N: usize>(
    items: &mut [([DVec3; N], usize)],
    part: usize,
    parts: &mut Vec<[Aabb; N]>,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    if items.is_empty() {
        return Ok(());
    }
    cancel.check()?;
    let around = |i: usize| Aabb::around(items.iter().map(|(item, _)| item[i])).expect("there are items");
    let boxes: [Aabb; N] = array::from_fn(around);
    if parts.len() <= part {
        parts.resize(part + 1, boxes);
    }
    parts[part] = boxes;
    if items.len() <= LEAF {
        return Ok(());
    }
    let (middle, axis) = (items.len() / 2, boxes[0].size().max_position());
    items.select_nth_unstable_by(middle, |(a, _), (b, _)| a[0][axis].total_cmp(&b[0][axis]));
    let (before, behind) = items.split_at_mut(middle);
    arrange(before, 2 * part + 1, parts, cancel)?;
    arrange(behind, 2 * part + 2, parts, cancel)
}
