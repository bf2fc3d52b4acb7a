//! Progress on stderr.

mod bar;
mod campaign;

pub(crate) use bar::Progress;
pub(crate) use campaign::CampaignProgress;
