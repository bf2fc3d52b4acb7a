//! The seeds of a run: each is a hash of the campaign's seed, the object and the repetition. No two objects
//! share their draws, and the errors of one object are independent of those of another.
//!
//! Variants are not part of the hash: planners face the same noise and are measured against the same random
//! views, so their differences are paired.

use nextview::geometry::random::Random;
use serde::{Deserialize, Serialize};

/// The object and the repetition of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Repetition<'a> {
    /// Seed of the campaign.
    pub campaign_seed: u64,
    /// Name of the object in the results.
    pub object: &'a str,
    /// Seed in the specification's list.
    pub seed: u64,
    /// Seed of the set of candidates.
    pub view_seed: u64,
    /// Number of the first view.
    pub first_view: usize,
}

impl Repetition<'_> {
    /// Returns the seed of the planner's random draws.
    pub fn planner_seed(&self) -> u64 {
        self.derived("planner")
    }

    /// Returns the seed of the random views that define skill 0.
    pub fn baseline_seed(&self) -> u64 {
        self.derived("baseline")
    }

    /// Seed of the errors of depths and poses. These also depend on the pose of each frame: runs with other
    /// candidates or first views need no other seed, and can share the truth of their object.
    pub fn noise_seed(&self) -> u64 {
        hash(&format!("noise {} {} {}", self.campaign_seed, self.seed, self.object))
    }

    fn derived(&self, purpose: &str) -> u64 {
        let Self { campaign_seed, object, seed, view_seed, first_view } = self;
        hash(&format!("{purpose} {campaign_seed} {seed} {view_seed} {first_view} {object}"))
    }
}

/// A drawn first view. Its number counts the candidates as configured. It is resolved when the candidates are
/// counted, since those below a table or out of reach do not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FirstViewDraw {
    /// Seed of all draws for the object and the set of candidates.
    pub seed: u64,
    /// Number of candidates as configured.
    pub candidates: usize,
    /// Index of the draw, from 0.
    pub place: usize,
}

impl FirstViewDraw {
    /// The draw with this index for an object and a set of candidates.
    pub(crate) fn new(
        campaign_seed: u64,
        object: &str,
        view_seed: u64,
        candidates: usize,
        place: usize,
    ) -> Self {
        let seed = hash(&format!("first-views {campaign_seed} {view_seed} {object}"));
        Self { seed, candidates, place }
    }

    /// The number among the first `n_candidates` candidates, with later draws in place of those not among
    /// them; `None` if there are too few candidates. Draws for the same object and set are distinct.
    pub(crate) fn among(self, n_candidates: usize) -> Option<usize> {
        let mut random = Random::new(self.seed, 0);
        let mut open: Vec<usize> = (0..self.candidates).collect();
        let draws = (0..self.candidates).map(|_| open.swap_remove(random.index(open.len())));
        draws.filter(|&view| view < n_candidates).nth(self.place)
    }
}

/// The 64-bit hash FNV-1a (Fowler, Noll & Vo) of a text, mixed by the finaliser of SplitMix64 (Steele et al.
/// 2014), without its lowest 11 bits: every JSON reader keeps 53 bits of a number, not all keep 64.
fn hash(text: &str) -> u64 {
    let fnv = text
        .bytes()
        .fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3));
    let x = fnv.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (x ^ (x >> 31)) >> 11
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    const MUG: Repetition<'_> =
        Repetition { campaign_seed: 0, object: "mug", seed: 0, view_seed: 0, first_view: 0 };

    /// Computed by the Python program in docs/bench.md.
    #[test]
    fn seeds_are_pinned() {
        let seeds = [MUG.planner_seed(), MUG.baseline_seed(), MUG.noise_seed()];
        assert_eq!(seeds, PINNED, "a seed must mean the same numbers in every release");
        let views = [0, 1, 2].map(|place| FirstViewDraw::new(0, "mug", 0, 1000, place).among(1000));
        assert_eq!(views, PINNED_VIEWS.map(Some));
    }

    const PINNED: [u64; 3] = [6_401_230_271_834_487, 2_199_457_667_406_090, 7_837_220_535_057_186];
    const PINNED_VIEWS: [usize; 3] = [129, 130, 530];

    #[test]
    fn objects_repetitions_and_uses_have_seeds_of_their_own() {
        let mut seeds = BTreeSet::new();
        let mut n = 0;
        for object in ["mug", "mug 0", "0 mug", "Mug", "tasse à café", ""] {
            for (campaign_seed, seed, view_seed, first_view) in
                [(0, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (0, 0, 0, 10)]
            {
                let repetition = Repetition { campaign_seed, object, seed, view_seed, first_view };
                seeds.extend([repetition.planner_seed(), repetition.baseline_seed()]);
                n += 2;
            }
        }
        assert_eq!(seeds.len(), n);
        assert!(seeds.iter().all(|&seed| seed < 1 << 53));
    }

    #[test]
    fn noise_is_shared_by_first_views_and_candidates_but_not_by_repetitions_and_objects() {
        let noise = MUG.noise_seed();
        assert_eq!(Repetition { first_view: 3, view_seed: 2, ..MUG }.noise_seed(), noise);
        for other in [
            Repetition { seed: 1, ..MUG },
            Repetition { campaign_seed: 1, ..MUG },
            Repetition { object: "cup", ..MUG },
        ] {
            assert_ne!(other.noise_seed(), noise);
        }
    }

    /// Each bit of the seeds of many objects is set in about half of them.
    #[test]
    fn all_bits_vary() {
        let seeds: Vec<u64> =
            (0..4000).map(|i| Repetition { object: &format!("{i}"), ..MUG }.planner_seed()).collect();
        for bit in 0..53 {
            let n = seeds.iter().filter(|&seed| seed >> bit & 1 == 1).count();
            // Standard deviation 32.
            assert!((1850..2150).contains(&n), "bit {bit}: {n} of 4000");
        }
    }

    #[test]
    fn drawn_first_views_are_distinct_candidates_that_exist() {
        let views = |object: &str, n_candidates: usize| -> Vec<usize> {
            (0..21)
                .map_while(|place| FirstViewDraw::new(0, object, 0, 20, place).among(n_candidates))
                .collect()
        };
        for n_candidates in [0, 1, 7, 20] {
            let mut found = views("mug", n_candidates);
            found.sort_unstable();
            assert_eq!(found, (0..n_candidates).collect::<Vec<_>>());
        }
        assert_ne!(views("mug", 20), views("cup", 20));
        let left: Vec<usize> = views("mug", 20).into_iter().filter(|&view| view < 7).collect();
        assert_eq!(views("mug", 7), left, "those that exist keep their order");
    }
}
