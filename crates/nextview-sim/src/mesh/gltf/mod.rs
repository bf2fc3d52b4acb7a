//! glTF 2.0 and GLB: the triangles of the scene, with its nodes' transforms and base colours. glTF has y up;
//! the result has z up, like the world.

mod buffers;
mod colors;
mod json;

use super::image::{Images, Resolve};
use super::limit;
use super::raw::RawMesh;
use crate::SimError;
use buffers::elements;
use glam::{DMat4, DQuat, DVec3};
use json::{GltfDocument, GltfNode, Primitive, field};
use nextview::text::plain;
use std::borrow::Cow;

pub(super) fn parse(bytes: &[u8], resolve: &Resolve) -> Result<RawMesh, SimError> {
    let (json, chunk) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let document: GltfDocument = serde_json::from_slice(&plain(json)?)
        .map_err(|error| SimError::format(format!("JSON line {}", error.line()), error.to_string()))?;
    check_extensions(&document)?;
    let buffers = buffers::load(&document, chunk, resolve)?;
    let n_bytes = bytes.len() + buffers.iter().map(|buffer| buffer.len()).sum::<usize>();
    let mut mesh = RawMesh::default();
    let materials = colors::add_materials(&document, &buffers, resolve, &mut Images::default(), &mut mesh);
    mesh.colors_or_fault(materials);
    for (node, world_from_node) in placed_nodes(&document)? {
        let Some(i) = node.mesh else { continue };
        for primitive in &field(&document.meshes, i, "meshes")?.primitives {
            // Nodes may share meshes: checked before any is read, so a small file cannot fill the memory.
            let [n_vertices, n_corners] = counts(&document, primitive)?;
            // A larger number than there are bytes is an error of the accessor.
            let n_vertices = mesh.vertices.len() + n_vertices.min(n_bytes);
            let n_triangles = mesh.triangles.len() + n_corners.min(n_bytes) / 3;
            limit::check(n_vertices, n_triangles, n_bytes as u64)?;
            add_primitive(&document, &buffers, primitive, world_from_node, &mut mesh)?;
        }
    }
    Ok(mesh)
}

/// The JSON text and the binary chunk of a GLB file.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), SimError> {
    let word = |at: usize| match bytes.get(at..at.checked_add(4)?) {
        Some(&[a, b, c, d]) => Some(u32::from_le_bytes([a, b, c, d])),
        _ => None,
    };
    if word(4) != Some(2) {
        let problem = format!("GLB version {:?}, expected 2", word(4));
        return Err(SimError::format("byte 4", problem));
    }
    let chunk = |at: usize, kind: &[u8; 4]| {
        let length = word(at)? as usize;
        (word(at + 4) == Some(u32::from_le_bytes(*kind))).then_some(())?;
        bytes.get(at + 8..(at + 8).checked_add(length)?)
    };
    let json = chunk(12, b"JSON").ok_or_else(|| {
        SimError::format("byte 12", "no complete JSON chunk; the file is truncated or not a GLB file")
    })?;
    let at = 20 + json.len();
    if bytes.len() < at + 8 {
        return Ok((json, None));
    }
    let binary = chunk(at, b"BIN\0").ok_or_else(|| {
        SimError::format(format!("byte {at}"), "no complete binary chunk; the file is truncated")
    })?;
    Ok((json, Some(binary)))
}

fn check_extensions(document: &GltfDocument) -> Result<(), SimError> {
    let is_needed = |name: &&String| {
        ["draco", "meshopt", "quantization", "gpu_instancing", "texture_transform"]
            .iter()
            .any(|part| name.contains(part))
    };
    match document.extensions_required.iter().find(is_needed) {
        Some(name) => {
            let problem = format!("requires {name}, which is not supported; export the mesh without it");
            Err(SimError::format("extensionsRequired", problem))
        }
        None => Ok(()),
    }
}

/// All nodes of the scene (of all roots, if the file has no scene) with their transforms to a world with z
/// up.
fn placed_nodes(document: &GltfDocument) -> Result<Vec<(&GltfNode, DMat4)>, SimError> {
    let roots = match document.scenes.is_empty() {
        false => field(&document.scenes, document.scene.unwrap_or(0), "scenes")?.nodes.clone(),
        true => {
            let mut is_child = vec![false; document.nodes.len()];
            let children = document.nodes.iter().flat_map(|node| &node.children);
            children.for_each(|&i| is_child.get_mut(i).into_iter().for_each(|child| *child = true));
            (0..document.nodes.len()).filter(|&i| !is_child[i]).collect()
        }
    };
    let z_up = DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let mut reached = vec![false; document.nodes.len()];
    let mut open = Vec::new();
    reach(&roots, z_up, &mut reached, &mut open)?;
    let mut placed = Vec::new();
    while let Some((i, world_from_parent)) = open.pop() {
        let node = field(&document.nodes, i, "nodes")?;
        let world_from_node = world_from_parent * local_transform(node);
        reach(&node.children, world_from_node, &mut reached, &mut open)?;
        placed.push((node, world_from_node));
    }
    Ok(placed)
}

/// Opens nodes of one parent, the first on top; fails if one was reached before.
fn reach(
    nodes: &[usize],
    world_from_parent: DMat4,
    reached: &mut [bool],
    open: &mut Vec<(usize, DMat4)>,
) -> Result<(), SimError> {
    for &i in nodes.iter().rev() {
        field(reached, i, "nodes")?;
        if std::mem::replace(&mut reached[i], true) {
            let problem = "is reached twice, expected a tree of nodes";
            return Err(SimError::format(format!("nodes[{i}]"), problem));
        }
        open.push((i, world_from_parent));
    }
    Ok(())
}

fn local_transform(node: &GltfNode) -> DMat4 {
    match node.matrix {
        Some(matrix) => DMat4::from_cols_array(&matrix),
        None => {
            let rotation = node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
            // Zero length would give NaN everywhere; such a node has no orientation to apply.
            let rotation = if rotation.length() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
            let scale = node.scale.map_or(DVec3::ONE, DVec3::from_array);
            let translation = node.translation.map_or(DVec3::ZERO, DVec3::from_array);
            DMat4::from_scale_rotation_translation(scale, rotation, translation)
        }
    }
}

/// Numbers of vertices and corners that a primitive states.
fn counts(document: &GltfDocument, primitive: &Primitive) -> Result<[usize; 2], SimError> {
    let count = |i: usize| field(&document.accessors, i, "accessors").map(|accessor| accessor.count);
    let n_vertices = primitive.attributes.position.map_or(Ok(0), count)?;
    Ok([n_vertices, primitive.indices.map_or(Ok(n_vertices), count)?])
}

fn add_primitive(
    document: &GltfDocument,
    buffers: &[Cow<[u8]>],
    primitive: &Primitive,
    world_from_node: DMat4,
    mesh: &mut RawMesh,
) -> Result<(), SimError> {
    let mode = primitive.mode.unwrap_or(TRIANGLES);
    let (Some(position), TRIANGLES | STRIP | FAN) = (primitive.attributes.position, mode) else {
        return Ok(()); // points and lines have no surface
    };
    let first = mesh.vertices.len();
    let positions = read_positions(document, buffers, position)?;
    let corners = match primitive.indices {
        Some(i) => read_indices(document, buffers, i, positions.len())?,
        None => (0..positions.len() as u32).collect(),
    };
    mesh.vertices.extend(positions.into_iter().map(|p| world_from_node.transform_point3(p)));
    let first_triangle = mesh.triangles.len();
    mesh.triangles.extend(triangles(mode, &corners).map(|t| t.map(|i| first as u32 + i)));
    if mesh.color_fault.is_none() {
        let colors = colors::add_colors(document, buffers, primitive, first, mesh)
            .and_then(|()| colors::add_faces(document, buffers, primitive, [first, first_triangle], mesh));
        mesh.colors_or_fault(colors);
    }
    Ok(())
}

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

fn triangles(mode: u32, corners: &[u32]) -> Box<dyn Iterator<Item = [u32; 3]> + '_> {
    match mode {
        STRIP => Box::new(corners.windows(3).map(|c| [c[0], c[1], c[2]])),
        FAN => Box::new(corners.get(1..).unwrap_or_default().windows(2).map(|c| [corners[0], c[0], c[1]])),
        _ => Box::new(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]])),
    }
}

fn read_positions(document: &GltfDocument, buffers: &[Cow<[u8]>], i: usize) -> Result<Vec<DVec3>, SimError> {
    let accessor = field(&document.accessors, i, "accessors")?;
    if (accessor.component_type, accessor.shape.as_str()) != (5126, "VEC3") {
        let problem = format!(
            "positions are {} of component type {}, expected VEC3 of 5126 (float)",
            accessor.shape, accessor.component_type
        );
        return Err(SimError::format(format!("accessors[{i}]"), problem));
    }
    let float = |b: &[u8], at: usize| f32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]]) as f64;
    let point = |b: &[u8]| DVec3::new(float(b, 0), float(b, 4), float(b, 8));
    Ok(elements(document, buffers, i, 12)?.map(point).collect())
}

fn read_indices(
    document: &GltfDocument,
    buffers: &[Cow<[u8]>],
    i: usize,
    n_vertices: usize,
) -> Result<Vec<u32>, SimError> {
    let accessor = field(&document.accessors, i, "accessors")?;
    let error = |problem: String| SimError::format(format!("accessors[{i}]"), problem);
    let size = match (accessor.component_type, accessor.shape.as_str()) {
        (5121, "SCALAR") => 1,
        (5123, "SCALAR") => 2,
        (5125, "SCALAR") => 4,
        (kind, shape) => {
            return Err(error(format!(
                "indices are {shape} of {kind}, expected SCALAR of 5121, 5123 or 5125"
            )));
        }
    };
    let index = |bytes: &[u8]| bytes.iter().rev().fold(0_u32, |sum, &byte| sum << 8 | byte as u32);
    let indices: Vec<u32> = elements(document, buffers, i, size)?.map(index).collect();
    match indices.iter().position(|&index| index as usize >= n_vertices) {
        Some(k) => Err(error(format!(
            "index {k} refers to vertex {}, but there are {n_vertices} vertices",
            indices[k]
        ))),
        None => Ok(indices),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::image::png_bytes;
    use crate::mesh::srgb;

    /// Three corners in a column-major transform, with indices of one byte.
    fn data() -> Vec<u8> {
        let mut bytes: Vec<u8> =
            [0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        bytes.extend([0, 1, 2]);
        bytes
    }

    fn document(buffer: &str) -> String {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
            "nodes": [{{"children": [1], "translation": [0, 0, 5]}},
                      {{"mesh": 0, "scale": [2, 2, 2], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]}},
                      {{"mesh": 0}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 0}}, "indices": 1}},
                                        {{"attributes": {{"POSITION": 0}}, "mode": 1}}]}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
                          {{"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 3}}],
            "buffers": [{buffer}]}}"#
        )
    }

    fn glb() -> Vec<u8> {
        let mut json = document(r#"{"byteLength": 39}"#).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bytes = b"glTF".to_vec();
        bytes.extend(2_u32.to_le_bytes());
        bytes.extend((12 + 8 + json.len() as u32 + 8 + 40).to_le_bytes());
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(json);
        bytes.extend(40_u32.to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(data());
        bytes.push(0);
        bytes
    }

    fn no_files(_: &str) -> Result<Vec<u8>, SimError> {
        Err(SimError::NotAFile)
    }

    #[test]
    fn places_the_triangle_from_every_kind_of_buffer() {
        let beside = document(r#"{"byteLength": 39, "uri": "data.bin"}"#);
        let inline = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC";
        let inline = document(&format!(
            r#"{{"byteLength": 39, "uri": "data:application/octet-stream;base64,{inline}"}}"#
        ));
        let from_file = |uri: &str| if uri == "data.bin" { Ok(data()) } else { no_files(uri) };
        for bytes in [glb(), beside.into_bytes(), inline.into_bytes()] {
            let mesh = parse(&bytes, &from_file).unwrap();
            assert_eq!(mesh.triangles, [[0, 1, 2]]);
            // Rotated by 90 degrees about z, doubled, moved along z; then from y up to z up.
            let expected =
                [DVec3::new(0.0, -5.0, 0.0), DVec3::new(0.0, -5.0, 2.0), DVec3::new(-2.0, -5.0, 0.0)];
            for (vertex, expected) in mesh.vertices.iter().zip(expected) {
                assert!(vertex.distance(expected) < 1e-12, "{vertex} is not {expected}");
            }
        }
    }

    #[test]
    fn base_colours_are_those_of_vertices_factor_and_texture() {
        // Three texture coordinates of two bytes, three colours of one byte and padding, and an image.
        let mut bytes = data();
        bytes.push(0);
        bytes.extend([0_u16, 0, 0xffff, 0, 0, 0].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([255, 255, 255, 0, 255, 0, 255, 0, 255, 255, 255, 0]);
        let image = png_bytes(2, 1, png::ColorType::Rgb, &[255, 255, 0, 0, 0, 255]);
        let n = image.len();
        bytes.extend(image);
        let text = document(&format!(r#"{{"byteLength": {}, "uri": "data.bin"}}"#, bytes.len()))
            .replace(r#""NORMAL": 0}"#, r#""NORMAL": 0, "TEXCOORD_0": 2, "COLOR_0": 3}, "material": 0"#)
            .replace(
                r#""accessors": ["#,
                r#""materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1],
                    "baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
                    "images": [{"bufferView": 4, "mimeType": "image/png"}], "accessors": ["#,
            )
            .replace(
                r#""type": "SCALAR"}"#,
                r#""type": "SCALAR"},
                {"bufferView": 2, "componentType": 5123, "normalized": true, "count": 3, "type": "VEC2"},
                {"bufferView": 3, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3"}"#,
            )
            .replace(
                r#""byteLength": 3}"#,
                &format!(
                    r#""byteLength": 3}}, {{"buffer": 0, "byteOffset": 40, "byteLength": 12}},
                    {{"buffer": 0, "byteOffset": 52, "byteLength": 12, "byteStride": 4}},
                    {{"buffer": 0, "byteOffset": 64, "byteLength": {n}}}"#
                ),
            );
        let read = |text: &str| parse(text.as_bytes(), &|_| Ok(bytes.clone()));
        let (mesh, ..) = read(&text).unwrap().check(1000).unwrap();
        let color = |weights| mesh.color(0, weights).unwrap();
        assert_eq!(color([0.75, 0.25, 0.0]), srgb::to_color([0.5, 0.75, 0.0]));
        assert_eq!(color([0.5, 0.0, 0.5]), srgb::to_color([0.25, 0.5, 0.5]), "the border repeats");
        let error = |from: &str, to: &str| {
            let (mesh, _, fault) = read(&text.replacen(from, to, 1)).unwrap().check(1000).unwrap();
            assert_eq!(mesh.appearance(), None);
            fault.unwrap().to_string()
        };
        assert!(error("\"material\": 0", "\"material\": 1").starts_with("materials[1]: does not exist"));
        assert!(error("{\"index\": 0", "{\"index\": 3").starts_with("textures[3]: does not exist"));
        assert!(error("{\"source\": 0}", "{}").starts_with("textures[0]: has no source"));
        assert!(
            error("\"bufferView\": 4,", "\"uri\": \"a.png\",").starts_with("texture \"a.png\": image: is no")
        );
        assert!(error("\"bufferView\": 4,", "").starts_with("images[0]: has neither"));
        assert!(error("\"TEXCOORD_0\": 2,", "").contains("TEXCOORD_0"));
        assert!(error("VEC2", "VEC4").starts_with("accessors[2]: is VEC4 of component type 5123"));
    }

    #[test]
    fn says_where_it_is_broken() {
        let good =
            String::from_utf8(document(r#"{"byteLength": 39, "uri": "data.bin"}"#).into_bytes()).unwrap();
        let check = |from: &str, to: &str, expected: &str| {
            let bytes = good.replacen(from, to, 1).into_bytes();
            let error = parse(&bytes, &|_| Ok(data())).unwrap_err().to_string();
            assert!(error.contains(expected), "{error:?} does not contain {expected:?}");
        };
        check("{", "[", "JSON line 1");
        check("\"scene\": 0", "\"scene\": 7", "scenes[7]: does not exist, there are 1");
        check("\"children\": [1]", "\"children\": [0]", "nodes[0]: is reached twice");
        check("\"mesh\": 0, \"scale\"", "\"mesh\": 3, \"scale\"", "meshes[3]");
        check("\"count\": 3", "\"count\": 1152921504606846976", "accessors[0]: has 1152921504606846976");
        check("VEC3", "VEC2", "accessors[0]: positions are VEC2");
        check("\"byteLength\": 39", "\"byteLength\": 40", "buffers[0]: has 39 bytes, expected 40");
        check("\"byteOffset\": 36", "\"byteOffset\": 99", "accessors[1]: lies outside its buffer");
        check("\"byteOffset\": 36", "\"byteOffset\": 30", "accessors[1]: index 0 refers to vertex 128");
        check("data.bin", "data:,", "base64");
        check("{", "{\"extensionsRequired\": [\"KHR_draco_mesh_compression\"],", "extensionsRequired");
        let cut = parse(&glb()[..glb().len() - 8], &no_files).unwrap_err().to_string();
        assert!(cut.contains("truncated"), "{cut}");
        assert!(parse(b"glTF\x01\0\0\0", &no_files).unwrap_err().to_string().contains("version"));
    }
}
