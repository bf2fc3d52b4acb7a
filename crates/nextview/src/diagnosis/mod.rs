//! The likely reason when frames show nothing, or do not fit together: wrong axes, inverted poses, a wrong
//! unit, a camera that is too near.
//!
//! Start with [`suspect`].

mod reading;
mod samples;
mod suspect;

pub use reading::Reading;
pub use suspect::{Suspicion, suspect};
