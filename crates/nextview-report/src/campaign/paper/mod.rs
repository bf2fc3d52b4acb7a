//! The paper's published numbers against the same quantities of a campaign.

mod axis;
mod by_parameter;
mod object_table;
mod published;
mod running_time;
mod tables;

pub(super) use object_table::section as object_table;
pub(super) use tables::section as tables;
