//! Reads the models in a scan's results.

use crate::Fault;
use nextview::geometry::Plane;
use nextview::object::ON_TABLE;
use nextview::surface::CloudPoint;
use nextview_sim::mesh::load_points;
use std::path::Path;

/// A model from a PLY file of a scan's results, even if saved again by another tool: points in metres with
/// normals, colours and expected errors, and triangles if there are any.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedModel {
    /// Points; attributes without a column or a value in the file are `None`.
    pub points: Vec<CloudPoint>,
    /// Three vertex indices each.
    pub triangles: Vec<[u32; 3]>,
}

impl SavedModel {
    /// Reads a PLY file.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let (points, triangles) = load_points(path)?;
        Ok(Self { points, triangles })
    }

    /// The part above the table: for a mesh, its triangles with their points; for a cloud, its points.
    pub fn above(self, table: Option<Plane>) -> Self {
        let is_above = |point: &CloudPoint| table.is_none_or(|t| t.height(point.position) > ON_TABLE);
        if self.triangles.is_empty() {
            return Self { points: self.points.into_iter().filter(is_above).collect(), ..self };
        }
        let are_above = |triangle: &&[u32; 3]| triangle.iter().all(|&i| is_above(&self.points[i as usize]));
        let triangles: Vec<[u32; 3]> = self.triangles.iter().filter(are_above).copied().collect();
        let mut new_index = vec![None; self.points.len()];
        let mut points = Vec::new();
        let mut renumbered = |i: u32| {
            *new_index[i as usize].get_or_insert_with(|| {
                points.push(self.points[i as usize]);
                points.len() as u32 - 1
            })
        };
        let triangles = triangles.into_iter().map(|triangle| triangle.map(&mut renumbered)).collect();
        Self { points, triangles }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use nextview_model::write_mesh;

    fn points() -> Vec<CloudPoint> {
        let point = |i: u8| CloudPoint {
            position: DVec3::new(f64::from(i), 0.5, -0.25),
            normal: Some(DVec3::Z),
            color: Some([i, 100, 255]),
            error: (i > 0).then(|| f32::from(i) / 1e3),
        };
        (0..4).map(point).collect()
    }

    fn read_back(name: &str, points: &[CloudPoint], triangles: &[[u32; 3]]) -> Result<SavedModel, Fault> {
        let path = std::env::temp_dir().join(format!("nextview-{name}-{}.ply", std::process::id()));
        let mut bytes = Vec::new();
        write_mesh(&mut bytes, points, None, triangles).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let read = SavedModel::read(&path);
        std::fs::remove_file(&path).unwrap();
        read
    }

    #[test]
    fn what_a_scan_writes_reads_back() {
        let triangles = vec![[0, 1, 2], [1, 2, 3]];
        let model = read_back("saved-mesh", &points(), &triangles).unwrap();
        assert_eq!(model, SavedModel { points: points(), triangles });
        let plain: Vec<CloudPoint> = points().iter().map(|point| point.position.into()).collect();
        assert_eq!(read_back("saved-cloud", &plain, &[]).unwrap().points, plain);
        let fault = read_back("saved-broken", &points(), &[[0, 1, 4]]).unwrap_err().to_string();
        assert!(fault.contains("a face refers to vertex 4, but there are 4 vertices"), "{fault}");
    }

    #[test]
    fn what_lies_on_the_table_is_left_out() {
        let table = Some(Plane::new(DVec3::X, DVec3::X).unwrap());
        let mesh = SavedModel { points: points(), triangles: vec![[0, 2, 3], [3, 2, 2]] }.above(table);
        assert_eq!((mesh.points, mesh.triangles), (vec![points()[3], points()[2]], vec![[0, 1, 1]]));
        let cloud = SavedModel { points: points(), triangles: Vec::new() };
        assert_eq!(cloud.above(table).points, points()[2..]);
    }
}
