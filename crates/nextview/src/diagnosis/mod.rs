//! The likely reason when frames show nothing, or do not fit together: wrong axes, inverted poses, a wrong
//! unit, a camera that is too near.
//!
//! Start with [`suspect`]; [`suspect_poses`] also looks at where frames can be taken.

mod reading;
mod samples;
mod suspect;

pub use reading::Reading;
pub use suspect::{Suspicion, suspect, suspect_poses};
