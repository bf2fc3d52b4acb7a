//! One file per format.

mod bop;
mod colmap;
mod foundation_pose;
mod nerfstudio;
mod obj;
mod open3d;
mod out;
mod pcd;
mod tum;

use crate::Format;
use crate::scanned::Scanned;
use nextview_scan::Fault;
use out::Out;

pub use out::NamedFile;

/// All files of a format.
pub(crate) fn files(format: Format, scanned: &Scanned) -> Result<Vec<NamedFile>, Fault> {
    let mut out = Out::default();
    match format {
        Format::Bop => bop::write(scanned, &mut out)?,
        Format::Colmap => colmap::write(scanned, &mut out)?,
        Format::FoundationPose => foundation_pose::write(scanned, &mut out)?,
        Format::Nerfstudio => nerfstudio::write(scanned, &mut out)?,
        Format::Obj => obj::write(scanned, &mut out)?,
        Format::Open3d => open3d::write(scanned, &mut out),
        Format::Pcd => pcd::write(scanned, &mut out),
        Format::Tum => tum::write(scanned, &mut out),
    }
    Ok(out.files)
}
