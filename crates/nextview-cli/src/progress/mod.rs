//! Progress on stderr.

mod bar;
mod campaign;
#[cfg(test)]
mod screen;

pub(crate) use bar::Progress;
pub(crate) use campaign::CampaignProgress;
