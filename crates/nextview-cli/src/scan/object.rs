use super::ScanConfig;
use crate::Failure;
use nextview_sim::mesh::TriangleMesh;
use nextview_sim::{builtin, mesh};
use std::path::Path;

/// The object to scan, in metres.
pub(super) struct Object {
    /// Short name, for headings and file names.
    pub name: String,
    pub mesh: TriangleMesh,
    /// How the file's numbers became metres, where that was not stated.
    pub note: Option<String>,
}

impl Object {
    pub fn load(config: &ScanConfig) -> Result<Self, Failure> {
        let object = match config.object.strip_prefix("builtin:") {
            Some(name) => Self::builtin(name)?,
            None => Self::file(Path::new(&config.object), config)?,
        };
        Ok(object)
    }

    fn builtin(name: &str) -> Result<Self, Failure> {
        let mesh = builtin::by_name(name).ok_or_else(|| {
            let known = builtin::names().join(", ");
            Failure::usage(format!("no built-in object '{name}'")).with_hint(format!("known: {known}"))
        })?;
        Ok(Self { name: name.to_owned(), mesh, note: None })
    }

    fn file(path: &Path, config: &ScanConfig) -> Result<Self, Failure> {
        let _ = (path, config, mesh::load);
        unreachable!()
    }

    /// About a fortieth of the object's longest side: 1, 2 or 5 times a power of ten, the nearest in ratio.
    pub fn suitable_voxel_size(&self) -> f64 {
        let wanted = self.mesh.bounds().longest_side() / 40.0;
        let power = 10_f64.powf(wanted.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
        let ratio = |step: &f64| (step / wanted).ln().abs();
        let nearest = steps.into_iter().min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        // Through text, so that 0.005 is the number a user would write.
        format!("{:.0e}", nearest.unwrap_or(wanted)).parse().unwrap_or(wanted)
    }
}
