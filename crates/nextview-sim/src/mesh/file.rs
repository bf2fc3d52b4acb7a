use super::raw::RawMesh;
use super::{TriangleMesh, gltf, obj, off, ply, stl};
use crate::SimError;
use std::path::{Component, Path, PathBuf};

/// A mesh as a file states it, in a unit that the file may not name. [`to_metres`](Self::to_metres) makes it
/// a [`TriangleMesh`].
#[derive(Clone, Debug)]
pub struct FileMesh {
    path: PathBuf,
    /// In the file's unit.
    mesh: TriangleMesh,
    n_dropped: usize,
    has_metres: bool,
}

/// Reads a mesh file: PLY, OBJ, STL, OFF (text), glTF or GLB, as its extension says.
///
/// Polygons are cut into triangles that share their first corner. Normals, colours and textures are ignored.
/// glTF is turned from y up to z up; the other formats define no axes and are left as they are. The file is
/// read into memory as a whole.
///
/// Fails if the file cannot be read, breaks its format, or holds no valid surface; the error names the file
/// and the place.
pub fn load(path: &Path) -> Result<FileMesh, SimError> {
    let in_file = |error| SimError::InFile { path: path.to_owned(), error: Box::new(error) };
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let parse = parser(&extension).map_err(in_file)?;
    let raw = read(path).and_then(|bytes| parse(&bytes, path)).map_err(in_file)?;
    let (mesh, n_dropped) = raw.check().map_err(in_file)?;
    let has_metres = matches!(extension.as_str(), "gltf" | "glb");
    Ok(FileMesh { path: path.to_owned(), mesh, n_dropped, has_metres })
}

impl FileMesh {
    /// Longest side of the box around the mesh, in the file's unit.
    pub fn longest_side(&self) -> f64 {
        self.mesh.bounds().longest_side()
    }

    /// Number of faces left out because they have no area.
    pub fn n_dropped(&self) -> usize {
        self.n_dropped
    }

    /// The mesh in the file's unit.
    pub(super) fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// Whether the format defines the unit to be metres.
    pub(super) fn has_metres(&self) -> bool {
        self.has_metres
    }

    /// An error about this file.
    pub(super) fn error(&self, error: SimError) -> SimError {
        SimError::InFile { path: self.path.clone(), error: Box::new(error) }
    }
}

type Parser = fn(&[u8], &Path) -> Result<RawMesh, SimError>;

fn parser(extension: &str) -> Result<Parser, SimError> {
    Ok(match extension {
        "ply" => |bytes, _| ply::parse(bytes),
        "obj" => |bytes, _| obj::parse(bytes),
        "stl" => |bytes, _| stl::parse(bytes),
        "off" => |bytes, _| off::parse(bytes),
        "gltf" | "glb" => |bytes, path| gltf::parse(bytes, &|uri| read_beside(path, uri)),
        _ => return Err(SimError::UnknownFormat { extension: extension.to_owned() }),
    })
}

/// Reads a regular file; anything else (a directory, a pipe) may never end.
fn read(path: &Path) -> Result<Vec<u8>, SimError> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(SimError::NotAFile);
    }
    Ok(std::fs::read(path)?)
}

/// Reads the file that a relative URI names, from the folder of `path` or below: a mesh has no business
/// elsewhere.
fn read_beside(path: &Path, uri: &str) -> Result<Vec<u8>, SimError> {
    let relative = PathBuf::from(decode_percent(uri));
    if relative.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir)) {
        return Err(SimError::format(
            "uri",
            "leads out of the file's folder, expected a file beside the mesh",
        ));
    }
    read(&path.with_file_name("").join(relative))
}

/// Replaces `%20` and its like; invalid codes stay as they are.
fn decode_percent(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let [byte, tail @ ..] = rest {
        let code = tail.get(..2).filter(|_| *byte == b'%').and_then(|hex| str::from_utf8(hex).ok());
        let decoded = code.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        bytes.push(decoded.unwrap_or(*byte));
        rest = if decoded.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
