//! The mesh with a texture from the colour images.

use crate::scanned::Scanned;
use crate::view::UndistortedView;
use nextview::Cancel;
use nextview::surface::CloudPoint;
use nextview_model::{Photo, texture_mesh, write_mtl, write_obj};
use nextview_recording::encode_color;
use nextview_scan::Fault;

/// Names and contents of the files, whose stem is `name`: `.obj`, `.mtl` and `.png`, which refer to each
/// other.
pub(crate) fn files(scanned: &Scanned, name: &str) -> Result<[(String, Vec<u8>); 3], Fault> {
    let photo =
        |view: &UndistortedView| Some(Photo { frame: view.frame.clone(), color: view.color.clone()? });
    let photos: Vec<Photo> = scanned.views.iter().filter_map(photo).collect();
    // Result files have 0 0 0 for a missing colour.
    let colored = |point: &CloudPoint| CloudPoint { color: point.color.filter(|c| *c != [0; 3]), ..*point };
    let points: Vec<CloudPoint> = scanned.object.points.iter().map(colored).collect();
    let mesh = texture_mesh(&points, &scanned.object.triangles, &photos, &Cancel::default())?;
    let image = format!("{name}.png");
    let (mut obj, mut mtl) = (Vec::new(), Vec::new());
    write_obj(&mut obj, &mesh, name)?;
    write_mtl(&mut mtl, name, &image)?;
    Ok([(format!("{name}.obj"), obj), (format!("{name}.mtl"), mtl), (image, encode_color(&mesh.texture))])
}
