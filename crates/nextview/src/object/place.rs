use super::table::{KnownTable, TableTops};
use crate::geometry::Aabb;

/// The object's known place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Place {
    /// The box around it; nothing is mapped before there is one.
    pub bounds: Option<Aabb>,
    pub table: Option<KnownTable>,
}

impl Place {
    /// Returns the top of the table in each frame; `None` if there is no table, or before table and object
    /// are found.
    pub fn table_tops(&self) -> Option<TableTops> {
        self.table.zip(self.bounds).map(|(table, object)| TableTops { table, object })
    }
}
