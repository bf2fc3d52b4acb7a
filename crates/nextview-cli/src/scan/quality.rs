use super::FinishedScan;
use super::model::FinalModel;
use glam::DVec3;
use nextview::geometry::Plane;
use nextview::model::{CloudPoint, SurfaceMesh};
use nextview_sim::quality::{Quality, TrueSurface};
use serde::{Deserialize, Serialize};

/// How good a final cloud or mesh is, beside the true surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct QualityMm {
    /// Distance from its points to the true surface.
    pub accuracy_mean_mm: f64,
    pub accuracy_median_mm: f64,
    pub accuracy_p95_mm: f64,
    /// Share of the true surface that is at most so far from it.
    pub completeness_1mm: f64,
    pub completeness_2mm: f64,
    pub completeness_5mm: f64,
    /// Distance from the true surface to it.
    pub completeness_mean_mm: f64,
}

/// That of a cloud and of a mesh; none where the truth is not known, or they hold nothing of the object.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct ModelQuality {
    pub cloud: Option<QualityMm>,
    pub mesh: Option<QualityMm>,
}

/// Points up to here above a table are the table's, metres: the paper's figure (section V.C).
const ON_TABLE: f64 = 0.002;

impl ModelQuality {
    pub fn new<M>(model: &FinalModel, scan: &FinishedScan<M>, truth: &TrueSurface) -> Self {
        let mesh = above(scan.table(), &model.mesh);
        Self { cloud: scan.quality(&model.cloud, truth), mesh: truth.of_mesh(&mesh).map(QualityMm::from) }
    }
}

impl<M> FinishedScan<M> {
    /// The quality of the scan's cloud, the table aside.
    pub(crate) fn quality(&self, cloud: &[CloudPoint], truth: &TrueSurface) -> Option<QualityMm> {
        let table = self.table();
        let positions = cloud.iter().map(|point| point.position);
        let points: Vec<DVec3> = positions.filter(|point| is_above(table, *point)).collect();
        truth.of_points(&points).map(QualityMm::from)
    }

    fn table(&self) -> Option<Plane> {
        self.steps.last().and_then(|step| step.report.table)
    }
}

fn is_above(table: Option<Plane>, point: DVec3) -> bool {
    table.is_none_or(|table| table.height(point) > ON_TABLE)
}

/// The part of a mesh that is not the table.
fn above(table: Option<Plane>, mesh: &SurfaceMesh) -> SurfaceMesh {
    let is_above =
        |triangle: &&[u32; 3]| triangle.iter().all(|&i| is_above(table, mesh.vertices[i as usize]));
    let triangles = mesh.triangles.iter().filter(is_above).copied().collect();
    SurfaceMesh { vertices: mesh.vertices.clone(), triangles }
}

impl From<Quality> for QualityMm {
    fn from(Quality { accuracy, completeness }: Quality) -> Self {
        let [completeness_1mm, completeness_2mm, completeness_5mm] = completeness.within;
        Self {
            accuracy_mean_mm: 1e3 * accuracy.mean,
            accuracy_median_mm: 1e3 * accuracy.median,
            accuracy_p95_mm: 1e3 * accuracy.p95,
            completeness_1mm,
            completeness_2mm,
            completeness_5mm,
            completeness_mean_mm: 1e3 * completeness.mean,
        }
    }
}

impl QualityMm {
    /// In words, for people.
    pub fn phrase(&self) -> String {
        format!(
            "mean {:.2} mm off, 95 % within {:.2} mm; {:.1} % of the surface within 2 mm",
            self.accuracy_mean_mm,
            self.accuracy_p95_mm,
            100.0 * self.completeness_2mm
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_no_part_of_the_model() {
        let table = Some(Plane::horizontal(0.1).unwrap());
        let height = |z: f64| DVec3::new(0.3, 0.2, z);
        assert!(
            is_above(table, height(0.103)) && !is_above(table, height(0.101)) && is_above(None, height(0.0))
        );
        let vertices = [0.0, 0.11, 0.12, 0.13].map(height).to_vec();
        let mesh = SurfaceMesh { vertices, triangles: vec![[0, 1, 2], [1, 2, 3]] };
        assert_eq!(above(table, &mesh).triangles, [[1, 2, 3]]);
        assert_eq!(above(None, &mesh), mesh);
    }
}
