use super::turn::turn;
use crate::source::session_config::suitable_voxel_size;
use crate::{Fault, ScanConfig, SizeOf, TableRule, short_name};
use glam::DVec3;
use nextview::geometry::{Lattice, Pose};
use nextview_sim::mesh::{FileMesh, TriangleMesh, Unit, UnitSource};
use nextview_sim::scene::Scene;
use nextview_sim::{SimError, builtin, mesh};
use std::fmt;
use std::path::Path;

/// The object to scan, in metres.
pub struct Object {
    /// Short name, for headings and file names.
    pub name: String,
    pub mesh: TriangleMesh,
    /// Notes on the conversion of the file's numbers to metres if the unit was guessed, and on missing
    /// colours if the file's are broken.
    pub notes: Vec<String>,
    /// How it was turned since the previous scan; `None` if there is none.
    pub now_from_before: Option<Pose>,
}

impl fmt::Display for Object {
    /// Writes name, size and number of triangles.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.mesh.bounds().size() * 1e3;
        let n = self.mesh.triangles().len();
        let s = if n == 1 { "" } else { "s" };
        write!(f, "{}: {:.0} x {:.0} x {:.0} mm, {n} triangle{s}", self.name, size.x, size.y, size.z)
    }
}

impl Object {
    /// Loads the configured mesh and places it on its table.
    pub fn load(config: &ScanConfig) -> Result<Self, Fault> {
        let object = match config.object.strip_prefix("builtin:") {
            Some(name) => Self::builtin(name, config),
            None => Self::file(Path::new(&config.object), config),
        }?;
        let Some(results) = &config.after else { return Ok(object) };
        let now_from_before = turn(&object.mesh, results, config.noise.seed)?;
        let mesh = object.mesh.transformed(&now_from_before)?;
        Ok(Self { mesh, now_from_before: Some(now_from_before), ..object })
    }

    fn builtin(name: &str, config: &ScanConfig) -> Result<Self, Fault> {
        let mesh = builtin::by_name(name).ok_or_else(|| {
            let known = builtin::names().collect::<Vec<_>>().join(", ");
            let hint = format!(
                "the built-in objects are {known}, and random-N with a whole number N from 0 to {}",
                i64::MAX
            );
            Fault::request(format!("no built-in object '{name}'")).with_remedy(hint)
        })?;
        let scale = config.size_m.map_or(1.0, |size| size / mesh.bounds().longest_side());
        let mesh = sized(mesh.scaled(scale)?, config)?;
        Ok(Self { name: name.to_owned(), mesh, notes: Vec::new(), now_from_before: None })
    }

    fn file(path: &Path, config: &ScanConfig) -> Result<Self, Fault> {
        let unit = config.size_m.map_or(config.unit.into(), Unit::LongestSide);
        let file = read(path)?;
        let (mesh, scaling) = file.to_metres(unit)?;
        let unit_note =
            (scaling.source == UnitSource::Guessed).then(|| format!("{scaling}; set `unit` to be sure"));
        let color_note = file.color_fault().map(|fault| format!("the mesh is used without colours: {fault}"));
        let notes = unit_note.into_iter().chain(color_note).collect();
        let (name, mesh) = (short_name(&config.object), sized(mesh, config)?);
        Ok(Self { name, mesh, notes, now_from_before: None })
    }

    /// The object in front of the configured camera.
    pub fn scene(&self, config: &ScanConfig) -> Result<Scene, Fault> {
        let scene = Scene::new(self.mesh.clone(), config.camera).map_err(|error| match error {
            SimError::TooLargeForCamera { .. } => self.wrong_size(error, config),
            error => error.into(),
        })?;
        let scene = match config.size_of {
            SizeOf::Radius => scene.with_center(DVec3::ZERO),
            SizeOf::LongestSide | SizeOf::ShortestSide => scene,
        };
        Ok(if config.object_box.table == TableRule::None { scene } else { scene.with_table()? })
    }

    /// The configured voxel size, or one that suits the object. Fails if that is out of proportion.
    pub fn voxel_size(&self, config: &ScanConfig) -> Result<f64, Fault> {
        let longest = self.mesh.bounds().longest_side();
        match config.voxel_size_m {
            Some(size) if size > 0.5 * longest => Err(Fault::request(format!(
                "the voxel size is {size} m, expected at most half the object's longest side, {longest:.4} m"
            ))
            .with_remedy("`voxel_size_m` is in metres")),
            Some(size) => Ok(size),
            None if longest < 40.0 * Lattice::MIN_VOXEL_SIZE => {
                // Rounded to a thousandth of the smallest voxel; smaller differences are single-precision
                // noise of the file.
                let longest = (1e7 * longest).round() / 1e7;
                let problem = format!(
                    "the object's longest side is {longest} m, too small for voxels of at least {} m",
                    Lattice::MIN_VOXEL_SIZE
                );
                Err(self
                    .wrong_size(problem, config)
                    .with_remedy("state its `unit`, or its true size as `size_m`"))
            }
            None => Ok(suitable_voxel_size(longest)),
        }
    }

    /// Blames an object of this size on the file, unless the user stated the size.
    fn wrong_size(&self, problem: impl fmt::Display, config: &ScanConfig) -> Fault {
        match config.size_m {
            Some(_) => Fault::request(problem),
            None => Fault::data(problem).in_file(Path::new(&config.object)),
        }
    }
}

/// Scales a mesh to the stated length, as selected by `size_of`.
fn sized(mesh: TriangleMesh, config: &ScanConfig) -> Result<TriangleMesh, Fault> {
    let bounds = mesh.bounds();
    let (origin, length) = match config.size_of {
        SizeOf::LongestSide => return Ok(mesh),
        SizeOf::ShortestSide => (bounds.center(), bounds.size().min_element()),
        SizeOf::Radius => {
            let centroid = mesh.centroid();
            let corners = (0..mesh.triangles().len()).flat_map(|triangle| mesh.corners(triangle));
            (centroid, corners.map(|corner| corner.distance(centroid)).fold(0.0, f64::max))
        }
    };
    let scale = config.size_m.unwrap_or(length) / length;
    if !scale.is_finite() {
        let fault =
            Fault::request(format!("the object's {} is {length} m: it cannot be scaled", config.size_of));
        return Err(fault.with_remedy("`size_of` = longest-side works for every object"));
    }
    Ok(mesh.translated(-origin)?.scaled(scale)?)
}

fn read(path: &Path) -> Result<FileMesh, Fault> {
    let name = path.to_string_lossy();
    mesh::load(path).map_err(|error| match builtin::by_name(&name).is_some() {
        true => Fault::data(error).with_remedy(format!("the built-in object is builtin:{name}")),
        false => error.into(),
    })
}
