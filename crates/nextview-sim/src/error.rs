use glam::DVec3;
use std::path::PathBuf;

/// Errors of a mesh, a mesh file or a simulated camera.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// An error in this file, described by the source.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// The error.
        #[source]
        error: Box<SimError>,
    },
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}; give the path of a readable mesh file")]
    Io(#[from] std::io::Error),
    /// The path names a directory, a device or a pipe.
    #[error("is not a regular file; give the path of a mesh file")]
    NotAFile,
    /// The file name's extension names no format that can be read.
    #[error("{}, expected .ply, .obj, .stl, .off, .gltf or .glb", unknown(extension))]
    UnknownFormat {
        /// The extension, without the dot; empty if there is none.
        extension: String,
    },
    /// The content does not follow the format.
    #[error("{place}: {problem}")]
    Format {
        /// The line, byte offset or field.
        place: String,
        /// The fault, the value found and the content expected.
        problem: String,
    },
    /// No face of the mesh has an area.
    #[error(
        "the mesh has no face with an area ({n_degenerate} degenerate faces), expected at least one triangle"
    )]
    NoFaces {
        /// Faces whose corners coincide or lie on one line.
        n_degenerate: usize,
    },
    /// A vertex is NaN, infinite or absurdly far away.
    #[error("vertex {vertex} (counted from 0) is {position}, expected numbers between -1e30 and 1e30")]
    BadVertex {
        /// Index of the vertex, from 0.
        vertex: usize,
        /// Its coordinates.
        position: DVec3,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} (counted from 0) refers to vertex {index}, but there are only {n_vertices}")]
    IndexOutOfRange {
        /// Index of the triangle, from 0.
        triangle: usize,
        /// Its vertex index, from 0.
        index: u32,
        /// Number of vertices of the mesh.
        n_vertices: usize,
    },
    /// The file states no unit and its size fits several.
    #[error(
        "the file has no unit and its longest side is {}, which may be metres or millimetres; \
         state the `unit` as m or mm, or the true size as `size_m`",
        short(*longest_side)
    )]
    AmbiguousUnit {
        /// Longest side of the box around the mesh, in the file's unit.
        longest_side: f64,
    },
    /// The object is too large for the camera.
    #[error(
        "the object's longest side is {} m, too large for a camera that sees up to {range} m; \
         if its unit is not the metre, state the `unit`, or its true size as `size_m`",
        short(*longest_side)
    )]
    TooLargeForCamera {
        /// Longest side of the object, metres.
        longest_side: f64,
        /// Range of the camera, metres.
        range: f64,
    },
    /// A parameter of the library is outside its range.
    #[error(transparent)]
    Parameter(#[from] nextview::Error),
}

/// Describes an unknown extension, which may be empty.
fn unknown(extension: &str) -> String {
    match extension {
        "" => "unknown mesh format, its name has no extension".to_owned(),
        _ => format!("unknown mesh format {extension:?}"),
    }
}

/// Rounds a length to four digits for messages. The coordinates of most files have single precision.
fn short(length: f64) -> f64 {
    format!("{length:.3e}").parse().unwrap_or(length)
}

impl SimError {
    pub(crate) fn format(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Format { place: place.into(), problem: problem.into() }
    }

    pub(crate) fn parameter(name: &'static str, value: impl ToString, expected: &'static str) -> Self {
        nextview::Error::InvalidParameter { name, value: value.to_string(), expected }.into()
    }
}
