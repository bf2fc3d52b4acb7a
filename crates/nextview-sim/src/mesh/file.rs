use super::raw::RawMesh;
use super::{TriangleMesh, gltf, limit, obj, off, ply, stl};
use crate::SimError;
use nextview::surface::CloudPoint;
use std::cell::RefCell;
use std::path::{Component, Path, PathBuf};

/// A mesh as stored in a file, in a unit that the file may not name. [`to_metres`](Self::to_metres) converts
/// it to a [`TriangleMesh`].
#[derive(Debug)]
pub struct FileMesh {
    path: PathBuf,
    /// The mesh in the file's unit.
    mesh: TriangleMesh,
    n_dropped: usize,
    color_fault: Option<SimError>,
    has_metres: bool,
}

/// Reads a mesh file: PLY, OBJ, STL, OFF (text), glTF or GLB, chosen by its extension.
///
/// Polygons are cut into triangles that share their first corner. Colours come from PLY's and OBJ's vertices,
/// from OBJ's materials (`Kd`, `map_Kd`), and from glTF's vertices and materials (base colour and its
/// texture). Images are PNG or JPEG, next to the mesh or below its folder. If any of these is missing or
/// broken, the mesh has no colours at all, and [`FileMesh::color_fault`] gives the reason. Normals are
/// ignored. glTF is rotated from y up to z up; the other formats define no axes and are left unchanged. The
/// whole file is read into memory.
///
/// Fails if the file cannot be read, breaks its format, holds no valid surface, or describes a mesh of more
/// than 20 times its size and 100 MB. The error names the file and the place.
pub fn load(path: &Path) -> Result<FileMesh, SimError> {
    let in_file = |error| SimError::InFile { path: path.to_owned(), error: Box::new(error) };
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let parse = parser(&extension).map_err(in_file)?;
    let files = Files { mesh: path, read: RefCell::default() };
    let parsed = files.read(path).and_then(|bytes| parse(&bytes, &files));
    let checked = parsed.and_then(|raw| raw.check(files.n_bytes()));
    let (mesh, n_dropped, color_fault) = checked.map_err(in_file)?;
    let has_metres = matches!(extension.as_str(), "gltf" | "glb");
    Ok(FileMesh { path: path.to_owned(), mesh, n_dropped, color_fault, has_metres })
}

/// Reads the points of a PLY file, a mesh or a cloud, with their normals, colours and expected errors (column
/// `error_m`), and its triangles, in the file's unit. Fails under the same conditions as [`load`].
pub fn load_points(path: &Path) -> Result<(Vec<CloudPoint>, Vec<[u32; 3]>), SimError> {
    let files = Files { mesh: path, read: RefCell::default() };
    let parsed = files.read(path).and_then(|bytes| ply::parse_points(&bytes));
    let checked = parsed.and_then(|(points, mesh)| {
        limit::check(points.len(), mesh.triangles.len(), files.n_bytes())?;
        match points.iter().position(|point| !point.position.is_finite()) {
            None => Ok((points, mesh.triangles)),
            Some(vertex) => Err(SimError::BadVertex { vertex, position: points[vertex].position }),
        }
    });
    checked.map_err(|error| SimError::InFile { path: path.to_owned(), error: Box::new(error) })
}

impl FileMesh {
    /// Returns the longest side of the box around the mesh, in the file's unit.
    pub fn longest_side(&self) -> f64 {
        self.mesh.bounds().longest_side()
    }

    /// Returns the number of faces left out because they have no area.
    pub fn n_dropped(&self) -> usize {
        self.n_dropped
    }

    /// Returns the reason why the mesh has no colours although the file has some.
    pub fn color_fault(&self) -> Option<&SimError> {
        self.color_fault.as_ref()
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

type Parser = fn(&[u8], &Files<'_>) -> Result<RawMesh, SimError>;

fn parser(extension: &str) -> Result<Parser, SimError> {
    Ok(match extension {
        "ply" => |bytes, _| ply::parse(bytes),
        "obj" => |bytes, files| obj::parse(bytes, &|name| files.read_beside(Path::new(name))),
        "stl" => |bytes, _| stl::parse(bytes),
        "off" => |bytes, _| off::parse(bytes),
        "gltf" | "glb" => {
            |bytes, files| gltf::parse(bytes, &|uri| files.read_beside(&PathBuf::from(decode_percent(uri))))
        }
        _ => return Err(SimError::UnknownFormat { extension: extension.to_owned() }),
    })
}

/// The file of a mesh and the files it names.
struct Files<'a> {
    mesh: &'a Path,
    /// The files read, and their sizes.
    read: RefCell<Vec<(PathBuf, u64)>>,
}

impl Files<'_> {
    /// Reads a regular file; anything else (a directory, a pipe) may never end.
    fn read(&self, path: &Path) -> Result<Vec<u8>, SimError> {
        let kind = std::fs::metadata(path)?;
        if !kind.is_file() {
            return Err(SimError::NotAFile);
        }
        if kind.len() > limit::MAX_BYTES {
            let problem = format!("has {} bytes, expected at most {}", kind.len(), limit::MAX_BYTES);
            return Err(SimError::format("file", problem));
        }
        let whole = path.canonicalize()?;
        let mut read = self.read.borrow_mut();
        if read.iter().any(|(other, _)| *other == whole) {
            return Err(SimError::format(
                "uri",
                "names a file that was already read, expected each file once",
            ));
        }
        let bytes = std::fs::read(path)?;
        read.push((whole, bytes.len() as u64));
        Ok(bytes)
    }

    /// Total size of all files read, bytes.
    fn n_bytes(&self) -> u64 {
        self.read.borrow().iter().map(|(_, n_bytes)| n_bytes).sum()
    }

    /// Reads a file named by the mesh, in the folder of the mesh or below; no other place is allowed.
    fn read_beside(&self, relative: &Path) -> Result<Vec<u8>, SimError> {
        if relative.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir)) {
            return Err(SimError::format(
                "uri",
                "leads outside the mesh's folder, expected a file next to the mesh",
            ));
        }
        self.read(&self.mesh.with_file_name("").join(relative))
    }
}

/// Decodes percent escapes such as `%20`; invalid codes stay unchanged.
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
