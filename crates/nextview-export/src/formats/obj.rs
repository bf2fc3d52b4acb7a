//! The mesh with a texture, as Wavefront OBJ.

use super::out::Out;
use crate::scanned::Scanned;
use crate::textured;
use nextview_scan::Fault;

pub(super) fn write(scanned: &Scanned, out: &mut Out) -> Result<(), Fault> {
    textured::files(scanned, "mesh")?.into_iter().for_each(|(name, bytes)| out.add(name, bytes));
    Ok(())
}
