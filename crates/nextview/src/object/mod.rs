//! Where the object is: its box, the table that it stands on, and the bodies next to it.
//!
//! Start with [`ObjectBox`] and [`Table`], the settings of a [session](crate::session::SessionConfig).

mod connected_cells;
mod location;
mod locator;
mod object_box;
mod object_points;
mod other_body;
mod place;
mod planning_box;
mod table;

pub use object_box::ObjectBox;
pub use other_body::OtherBody;
pub use planning_box::{BOX_MARGIN_FACTOR, BOX_MARGIN_VOXELS, planning_box};
pub use table::{ON_TABLE, Table, TableTops};

pub(crate) use location::Location;
pub(crate) use locator::Locator;
pub(crate) use place::Place;
pub(crate) use table::{KnownTable, ShownTable};
