use super::UnitName;
use nextview::geometry::Pose;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The CAD model of the scanned part and the demands on views of its surfaces. The planner inspection plans
/// by it, and an inspection of the results reports how far the demands were met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ReferenceConfig {
    /// A mesh file with triangles counter-clockwise seen from outside.
    pub mesh: PathBuf,
    /// Unit of the file. Default: auto.
    #[serde(default)]
    pub unit: UnitName,
    /// Pose of the part. By default, it is found in the frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub world_from_reference: Option<Pose>,
    /// Maximum angle between the line of sight and the surface normal, above 0 and below 90. Default: 60.
    #[serde(default = "default_angle")]
    pub angle_deg: f64,
    /// Minimum number of pixels per square millimetre in one picture, at least 0. Default: 0.
    #[serde(default)]
    pub points_per_mm2: f64,
    /// The surfaces to see. By default, all of the part.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<ReferenceSurface>,
}

/// A surface of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ReferenceSurface {
    /// Name of the surface.
    pub name: String,
    /// The box around the surface in CAD coordinates, given by its lowest and highest corners.
    pub box_m: [f64; 6],
    /// Maximum angle between the line of sight and the surface normal. Default: that of the whole part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Minimum number of pixels per square millimetre in one picture. Default: that of the whole part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points_per_mm2: Option<f64>,
}

fn default_angle() -> f64 {
    60.0
}

impl ReferenceConfig {
    /// A reference with this file and defaults.
    pub fn of(mesh: PathBuf) -> Self {
        Self {
            mesh,
            unit: UnitName::default(),
            world_from_reference: None,
            angle_deg: default_angle(),
            points_per_mm2: 0.0,
            surfaces: Vec::new(),
        }
    }
}

#[cfg(feature = "simulated")]
mod known {
    use super::{ReferenceConfig, ReferenceSurface};
    use crate::Fault;
    use glam::DVec3;
    use nextview::geometry::Aabb;
    use nextview::planner::ViewPlanner;
    use nextview_sim::inspection::{InspectionViews, SurfaceDemand, SurfaceDemands};
    use nextview_sim::mesh::{self, TriangleMesh};

    impl ReferenceConfig {
        /// Loads the CAD model in metres, with a note on the conversion of the file's numbers. A closed mesh
        /// that is inside out is flipped, and the note says so.
        pub fn load(&self) -> Result<(TriangleMesh, String), Fault> {
            let (mesh, scaling) = mesh::load(&self.mesh)?.to_metres(self.unit.into())?;
            Ok(match mesh.is_inside_out() {
                true => {
                    let note = "its triangles run clockwise seen from outside, and are reversed";
                    (mesh.turned_over(), format!("{scaling}; {note}"))
                }
                false => (mesh, scaling.to_string()),
            })
        }

        /// The demands on views of its surfaces.
        pub fn demands(&self, mesh: &TriangleMesh) -> Result<SurfaceDemands, Fault> {
            let demands = self.keyed_demands().skip(usize::from(!self.surfaces.is_empty()));
            SurfaceDemands::new(mesh, demands.map(|(_, demand)| demand).collect())
                .map_err(|error| Fault::from(error).within("reference"))
        }

        /// One demand for the whole part and one for each of its surfaces, by key.
        pub(in super::super) fn keyed_demands(&self) -> impl Iterator<Item = (String, SurfaceDemand)> + '_ {
            let demand = |name: &str, bounds, angle: Option<f64>, density: Option<f64>| SurfaceDemand {
                name: name.to_owned(),
                bounds,
                max_angle: angle.unwrap_or(self.angle_deg).to_radians(),
                min_density: 1e6 * density.unwrap_or(self.points_per_mm2),
            };
            let of_surface = move |(i, surface): (usize, &ReferenceSurface)| {
                let [x0, y0, z0, x1, y1, z1] = surface.box_m;
                let bounds = Aabb { min: DVec3::new(x0, y0, z0), max: DVec3::new(x1, y1, z1) };
                let (angle, density) = (surface.angle_deg, surface.points_per_mm2);
                (format!("reference.surfaces[{i}]"), demand(&surface.name, Some(bounds), angle, density))
            };
            let whole = ("reference".to_owned(), demand("all", None, None, None));
            [whole].into_iter().chain(self.surfaces.iter().enumerate().map(of_surface))
        }

        /// The planner that plans views to meet the demands.
        pub(crate) fn planner(&self) -> Result<Box<dyn ViewPlanner>, Fault> {
            let (mesh, _) = self.load()?;
            let demands = self.demands(&mesh)?;
            Ok(Box::new(InspectionViews::new(mesh, demands, self.world_from_reference)?))
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::ScanConfig;

    #[test]
    fn all_numbers_out_of_range_are_named() {
        let text = "[reference]\nmesh = \"cad.stl\"\nangle_deg = 95\n[[reference.surfaces]]\nname = \"seat\"\n\
                    box_m = [0, 0, 0, 1, 1, 1]\npoints_per_mm2 = -1\n";
        let message = ScanConfig::parse(text, None, None).unwrap_err().to_string();
        for part in ["`reference.angle_deg` is 95", "`reference.surfaces[0].points_per_mm2` is -1"] {
            assert!(message.contains(part), "{part} in {message}");
        }
    }
}
