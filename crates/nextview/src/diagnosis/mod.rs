//! Likely reasons why frames show nothing, or do not fit together: wrong axes, inverted poses, a wrong unit,
//! or a camera that is too near.
//!
//! Start with [`suspect`]; [`suspect_poses`] also checks where frames can be taken.

mod reading;
mod samples;
mod suspect;

pub use reading::Reading;
pub use suspect::{Suspicion, suspect, suspect_poses};
