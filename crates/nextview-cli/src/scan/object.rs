use super::{ScanConfig, TableRule};
use crate::Failure;
use nextview::geometry::Lattice;
use nextview_sim::mesh::{FileMesh, TriangleMesh, Unit, UnitSource};
use nextview_sim::scene::Scene;
use nextview_sim::{SimError, builtin, mesh};
use std::fmt;
use std::path::Path;

/// The object to scan, in metres.
pub(crate) struct Object {
    /// Short name, for headings and file names.
    pub name: String,
    pub mesh: TriangleMesh,
    /// How the file's numbers became metres, where that was not stated.
    pub note: Option<String>,
}

impl fmt::Display for Object {
    /// Name, size and number of triangles.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.mesh.bounds().size() * 1e3;
        let n = self.mesh.triangles().len();
        write!(f, "{}: {:.0} x {:.0} x {:.0} mm, {n} triangles", self.name, size.x, size.y, size.z)
    }
}

impl Object {
    pub fn load(config: &ScanConfig) -> Result<Self, Failure> {
        match config.object.strip_prefix("builtin:") {
            Some(name) => Self::builtin(name, config),
            None => Self::file(Path::new(&config.object), config),
        }
    }

    fn builtin(name: &str, config: &ScanConfig) -> Result<Self, Failure> {
        let mesh = builtin::by_name(name).ok_or_else(|| {
            let known = builtin::names().collect::<Vec<_>>().join(", ");
            let hint =
                format!("there are {known}, and random-SEED with a whole number from 0 to {}", u64::MAX);
            Failure::usage(format!("no built-in object '{name}'")).with_hint(hint)
        })?;
        let scale = config.size_m.map_or(1.0, |size| size / mesh.bounds().longest_side());
        Ok(Self { name: name.to_owned(), mesh: mesh.scaled(scale)?, note: None })
    }

    fn file(path: &Path, config: &ScanConfig) -> Result<Self, Failure> {
        let unit = config.size_m.map_or(config.unit.into(), Unit::LongestSide);
        let (mesh, scaling) = read(path)?.to_metres(unit)?;
        let note =
            (scaling.source == UnitSource::Guessed).then(|| format!("note: {scaling}; say so with --unit"));
        Ok(Self { name: short_name(&config.object), mesh, note })
    }

    /// The object before the configured camera.
    pub fn scene(&self, config: &ScanConfig) -> Result<Scene, Failure> {
        let scene = Scene::new(self.mesh.clone(), config.camera).map_err(|error| match error {
            SimError::TooLargeForCamera { .. } => self.wrong_size(error, config),
            error => error.into(),
        })?;
        Ok(if config.object_box.table == TableRule::None { scene } else { scene.with_table()? })
    }

    /// The configured voxel size, or else one that suits the object; fails if that is out of proportion.
    pub fn voxel_size(&self, config: &ScanConfig) -> Result<f64, Failure> {
        let longest = self.mesh.bounds().longest_side();
        match config.voxel_size_m {
            Some(size) if size > 0.5 * longest => Err(Failure::usage(format!(
                "the voxel size is {size} m, expected at most half the object's longest side, {longest:.4} m"
            ))
            .with_hint("--voxel-size-m is in metres")),
            Some(size) => Ok(size),
            None if longest < 40.0 * Lattice::MIN_VOXEL_SIZE => {
                let problem = format!(
                    "the object's longest side is {longest} m, too small for voxels of at least {} m; \
                     pass its unit as --unit m or its true size as --size-m 0.2",
                    Lattice::MIN_VOXEL_SIZE
                );
                Err(self.wrong_size(problem, config))
            }
            None => Ok(suitable_voxel_size(longest)),
        }
    }

    /// An object of this size is the file's fault, unless the user stated the size.
    fn wrong_size(&self, problem: impl fmt::Display, config: &ScanConfig) -> Failure {
        match config.size_m {
            Some(_) => Failure::usage(problem),
            None => Failure::data(problem).in_file(Path::new(&config.object)),
        }
    }
}

/// About a fortieth of an object's longest side, metres: 1, 2 or 5 times a power of ten, the nearest in ratio.
pub(super) fn suitable_voxel_size(longest_side: f64) -> f64 {
    let wanted = longest_side / 40.0;
    let power = 10_f64.powf(wanted.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    let ratio = |step: &f64| (step / wanted).ln().abs();
    let nearest = steps.into_iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    // Through text, so that 0.005 is the number a user would write.
    format!("{:.0e}", nearest.unwrap_or(wanted)).parse().unwrap_or(wanted)
}

fn read(path: &Path) -> Result<FileMesh, Failure> {
    let name = path.to_string_lossy();
    mesh::load(path).map_err(|error| match builtin::by_name(&name).is_some() {
        true => Failure::data(error).with_hint(format!("the built-in object is builtin:{name}")),
        false => error.into(),
    })
}

/// The object's name without `builtin:`, folders and extension.
pub(crate) fn short_name(object: &str) -> String {
    let name = object.strip_prefix("builtin:").unwrap_or(object);
    Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
