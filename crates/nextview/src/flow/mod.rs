//! Assignment of items to sets: the largest total quality first, then as few sets as possible.
//!
//! The problem is a flow source → item → channel → set → sink in which each item is served once and nothing
//! else is bounded. [`BestSets`] finds the largest total quality in one pass over the offers, with every set
//! that can be part of it. [`fewest_sets`] then picks a small number of sets that still serve every item at
//! its best.
//!
//! Conversely, [`best_coverage`] takes a given number of sets of largest joint value.
//!
//! There is no flow network here: it would only be needed if channels or sets had limits. One, with a
//! textbook min-cost-flow solver, is an oracle in the tests.

mod best;
mod cover;
mod coverage;
mod incidence;
mod row;
mod rows;

pub use best::BestSets;
pub use cover::fewest_sets;
pub(crate) use coverage::tidied;
pub use coverage::{Coverage, Selection, SetValues, best_coverage, good_coverage};
pub use incidence::Incidence;
