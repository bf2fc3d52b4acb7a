//! The parts of a glTF 2.0 document that make up its shape and colours.

use crate::SimError;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;

/// Maximum number of list entries: a node takes 400 bytes of memory, however few the file spends on it.
const MAX_ENTRIES: usize = 200_000;

#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
#[derive(Default)]
pub(super) struct GltfDocument {
    #[serde(deserialize_with = "list")]
    pub extensions_required: Vec<String>,
    pub scene: Option<usize>,
    #[serde(deserialize_with = "list")]
    pub scenes: Vec<GltfScene>,
    #[serde(deserialize_with = "list")]
    pub nodes: Vec<GltfNode>,
    #[serde(deserialize_with = "list")]
    pub meshes: Vec<Mesh>,
    #[serde(deserialize_with = "list")]
    pub accessors: Vec<Accessor>,
    #[serde(deserialize_with = "list")]
    pub buffer_views: Vec<BufferView>,
    #[serde(deserialize_with = "list")]
    pub buffers: Vec<Buffer>,
    #[serde(deserialize_with = "list")]
    pub materials: Vec<GltfMaterial>,
    #[serde(deserialize_with = "list")]
    pub textures: Vec<Texture>,
    #[serde(deserialize_with = "list")]
    pub images: Vec<GltfImage>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct GltfMaterial {
    pub pbr_metallic_roughness: BaseColor,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct BaseColor {
    pub base_color_factor: Option<[f32; 4]>,
    pub base_color_texture: Option<TextureInfo>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub index: usize,
    /// Index of the primitive's texture coordinates.
    #[serde(default)]
    pub tex_coord: usize,
}

#[derive(Debug, Deserialize)]
pub(super) struct Texture {
    pub source: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct GltfImage {
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfScene {
    pub nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GltfNode {
    pub mesh: Option<usize>,
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub mode: Option<u32>,
    pub material: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
    #[serde(rename = "COLOR_0")]
    pub color: Option<usize>,
    #[serde(rename = "TEXCOORD_0")]
    pub texture_0: Option<usize>,
    #[serde(rename = "TEXCOORD_1")]
    pub texture_1: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(rename = "type")]
    pub shape: String,
    pub count: usize,
    pub sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
}

/// Reads a list of bounded length.
fn list<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    deserializer.deserialize_seq(List(PhantomData))
}

struct List<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for List<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of at most {MAX_ENTRIES} entries")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Vec<T>, A::Error> {
        let mut list = Vec::new();
        while let Some(entry) = entries.next_element()? {
            if list.len() == MAX_ENTRIES {
                return Err(A::Error::invalid_length(MAX_ENTRIES + 1, &self));
            }
            list.push(entry);
        }
        Ok(list)
    }
}

/// Element `i` of an array of the document.
pub(super) fn field<'a, T>(items: &'a [T], i: usize, name: &str) -> Result<&'a T, SimError> {
    items.get(i).ok_or_else(|| {
        SimError::format(format!("{name}[{i}]"), format!("does not exist, there are {}", items.len()))
    })
}
