use super::table::KnownTable;
use crate::geometry::Aabb;

/// Where the object is, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Place {
    /// The box around it; nothing is mapped before there is one.
    pub bounds: Option<Aabb>,
    pub table: Option<KnownTable>,
}
