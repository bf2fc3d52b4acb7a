//! The assignment of seeds of [`random_object`](super::random_object). The ranges are disjoint: no named
//! object is one that a planner was trained on.

use std::ops::{Range, RangeInclusive};

/// Training of the prior of the planner most-surface. Its committed weights were trained on 0..200.
pub const PRIOR: Range<u64> = 0..1 << 32;

/// Objects on which the training of the prior reports its loss; never trained on.
pub const PRIOR_HELD_OUT: Range<u64> = 1 << 32..1 << 33;

/// Data sets for NBV-Net: a block of 2^24 seeds per data set seed.
pub const NBV_NET: Range<u64> = 1 << 60..1 << 61;

/// Training of the policy of the planner kaba: training objects first, comparison objects from the middle on.
pub const KABA: Range<u64> = 1 << 61..1 << 62;

/// Data sets for NBV regression, in blocks like those for NBV-Net.
pub const NBV_REGRESSION: Range<u64> = 1 << 62..3 << 61;

/// Data sets for PC-NBV, in blocks like those for NBV-Net.
pub const PC_NBV: Range<u64> = 3 << 61..1 << 63;

/// Objects with a name: `builtin:random-N` is the object of seed 2^63 + N.
pub const NAMED: RangeInclusive<u64> = 1 << 63..=u64::MAX;

/// Returns the seed of the object named `random-N`; `None` if N is 2^63 or more.
pub fn named(n: u64) -> Option<u64> {
    NAMED.start().checked_add(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_ranges_share_a_seed() {
        let training = [PRIOR, PRIOR_HELD_OUT, NBV_NET, KABA, NBV_REGRESSION, PC_NBV];
        let mut ranges: Vec<(u64, u64)> = training.iter().map(|range| (range.start, range.end - 1)).collect();
        ranges.push((*NAMED.start(), *NAMED.end()));
        ranges.sort_unstable();
        assert!(ranges.iter().all(|(first, last)| first <= last), "{ranges:?}");
        assert!(ranges.windows(2).all(|pair| pair[0].1 < pair[1].0), "{ranges:?}");
    }

    #[test]
    fn names_reach_all_of_their_range_and_nothing_else() {
        assert_eq!((named(0), named(17)), (Some(1 << 63), Some((1 << 63) + 17)));
        assert_eq!((named((1 << 63) - 1), named(1 << 63)), (Some(u64::MAX), None));
    }
}
