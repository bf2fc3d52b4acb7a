//! Colours of vertices, base colours of materials and their textures.

use super::buffers::{elements, of_uri, view};
use super::json::{GltfDocument, Primitive, field};
use crate::SimError;
use crate::mesh::image::{Images, Resolve};
use crate::mesh::raw::RawMesh;
use crate::mesh::{Face, Material, srgb};
use nextview::sensor::ColorImage;
use std::borrow::Cow;

/// All materials of the document, in its order.
pub(super) fn add_materials(
    document: &GltfDocument,
    buffers: &[Cow<[u8]>],
    resolve: &Resolve,
    images: &mut Images,
    mesh: &mut RawMesh,
) -> Result<(), SimError> {
    for (i, material) in document.materials.iter().enumerate() {
        let base = &material.pbr_metallic_roughness;
        let [red, green, blue, _] = base.base_color_factor.unwrap_or([1.0; 4]);
        let reflectance = [red, green, blue];
        if let Some(share) = reflectance.iter().find(|share| !(0.0..=1.0).contains(*share)) {
            let problem = format!("has a base colour of {share}, expected 0 to 1");
            return Err(SimError::format(format!("materials[{i}]"), problem));
        }
        let texture = base.base_color_texture.as_ref();
        let image = texture.map(|texture| image(document, buffers, texture.index, resolve, images));
        mesh.materials.push(Material { reflectance, image: image.transpose()? });
    }
    Ok(())
}

fn image(
    document: &GltfDocument,
    buffers: &[Cow<[u8]>],
    texture: usize,
    resolve: &Resolve,
    images: &mut Images,
) -> Result<ColorImage, SimError> {
    let i = field(&document.textures, texture, "textures")?.source.ok_or_else(|| {
        SimError::format(format!("textures[{texture}]"), "has no source, expected a PNG or JPEG image")
    })?;
    let place = format!("images[{i}]");
    let image = field(&document.images, i, "images")?;
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) if uri.starts_with("data:") => images.get(&place, || of_uri(&place, uri, resolve)),
        (Some(uri), _) => images.get(uri, || resolve(uri)),
        (None, Some(at)) => images.get(&place, || Ok(view(document, buffers, at)?.to_vec())),
        (None, None) => Err(SimError::format(place, "has neither uri nor bufferView")),
    }
}

/// The colours of the vertices of a primitive, from vertex `first` on.
pub(super) fn add_colors(
    document: &GltfDocument,
    buffers: &[Cow<[u8]>],
    primitive: &Primitive,
    first: usize,
    mesh: &mut RawMesh,
) -> Result<(), SimError> {
    let Some(i) = primitive.attributes.color else { return Ok(()) };
    let shape = field(&document.accessors, i, "accessors")?.shape.as_str();
    let colors = match shape {
        "VEC4" => {
            shares::<4>(document, buffers, i, shape)?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
        }
        _ => shares::<3>(document, buffers, i, "VEC3")?,
    };
    check_count(i, colors.len(), mesh.vertices.len() - first)?;
    mesh.push_colors(first, colors.into_iter().map(srgb::to_color));
    Ok(())
}

/// The material of the triangles of a primitive; vertices and triangles begin at `first`.
pub(super) fn add_faces(
    document: &GltfDocument,
    buffers: &[Cow<[u8]>],
    primitive: &Primitive,
    first: [usize; 2],
    mesh: &mut RawMesh,
) -> Result<(), SimError> {
    let Some(material) = primitive.material else { return Ok(()) };
    let texture =
        field(&document.materials, material, "materials")?.pbr_metallic_roughness.base_color_texture.as_ref();
    let points = match texture {
        None => None,
        Some(texture) => {
            let attributes = &primitive.attributes;
            let accessor = match texture.tex_coord {
                0 => attributes.texture_0,
                1 => attributes.texture_1,
                _ => None,
            };
            let i = accessor.ok_or_else(|| {
                let n = texture.tex_coord;
                let problem =
                    format!("a primitive with its texture has no TEXCOORD_{n}, expected TEXCOORD_0 or 1");
                SimError::format(format!("materials[{material}]"), problem)
            })?;
            let points = shares::<2>(document, buffers, i, "VEC2")?;
            check_count(i, points.len(), mesh.vertices.len() - first[0])?;
            Some(points)
        }
    };
    mesh.faces.resize(first[1], Face::default());
    for triangle in &mesh.triangles[first[1]..] {
        // Here v points down.
        let point = |i: u32| points.as_ref().map_or([0.0; 2], |points| points[i as usize - first[0]]);
        let texture = triangle.map(|i| [point(i)[0], 1.0 - point(i)[1]]);
        mesh.faces.push(Face { material: Some(material as u32), texture });
    }
    Ok(())
}

fn check_count(accessor: usize, n: usize, n_vertices: usize) -> Result<(), SimError> {
    if n == n_vertices {
        return Ok(());
    }
    let problem = format!("has {n} elements, expected one for each of {n_vertices} vertices");
    Err(SimError::format(format!("accessors[{accessor}]"), problem))
}

/// The elements of accessor `i`: floats, or whole numbers that stand for 0 to 1.
fn shares<const N: usize>(
    document: &GltfDocument,
    buffers: &[Cow<[u8]>],
    i: usize,
    shape: &str,
) -> Result<Vec<[f32; N]>, SimError> {
    let accessor = field(&document.accessors, i, "accessors")?;
    let size = match accessor.component_type {
        5126 => 4,
        5121 => 1,
        5123 => 2,
        _ => 0,
    };
    if size == 0 || accessor.shape != shape {
        let problem = format!(
            "is {} of component type {}, expected {shape} of 5126 (float), 5121 or 5123",
            accessor.shape, accessor.component_type
        );
        return Err(SimError::format(format!("accessors[{i}]"), problem));
    }
    let share = |bytes: &[u8]| match *bytes {
        [a] => f32::from(a) / 255.0,
        [a, b] => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
        [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        _ => 0.0,
    };
    let element = |bytes: &[u8]| std::array::from_fn(|k| share(&bytes[k * size..(k + 1) * size]));
    Ok(elements(document, buffers, i, N * size)?.map(element).collect())
}
