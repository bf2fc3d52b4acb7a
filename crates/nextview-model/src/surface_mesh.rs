use glam::DVec3;
use nextview::surface::CloudPoint;

/// A surface made of triangles, in metres and world coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// The vertices.
    pub vertices: Vec<DVec3>,
    /// Three indices into the vertices each, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl SurfaceMesh {
    /// Returns the vertices with outward normals: the area-weighted mean of the triangles around each. An
    /// unused vertex has none. Panics if a triangle refers to a nonexistent vertex.
    pub fn points(&self) -> Vec<CloudPoint> {
        let mut sums = vec![DVec3::ZERO; self.vertices.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|i| self.vertices[i as usize]);
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|&i| sums[i as usize] += normal);
        }
        let point = |(&position, sum): (&DVec3, DVec3)| CloudPoint {
            normal: sum.try_normalize(),
            ..CloudPoint::from(position)
        };
        self.vertices.iter().zip(sums).map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_nets;
    use glam::{IVec3, UVec3};
    use nextview::geometry::{Lattice, VoxelBlock};

    #[test]
    fn normals_of_a_ball_are_radial() {
        let lattice = Lattice::new(0.01).unwrap();
        let block = VoxelBlock::new(IVec3::splat(-13), UVec3::splat(26)).unwrap();
        let ball = surface_nets(&lattice, &block, |i| Some(lattice.center(block.key(i)).length() - 0.1));
        let points = ball.points();
        assert!(points.len() > 500);
        for point in points {
            let cosine = point.normal.unwrap().dot(point.position.normalize());
            assert!(cosine > 0.995, "{cosine} at {}", point.position);
        }
    }

    #[test]
    fn a_vertex_of_no_triangle_has_no_normal() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mesh = SurfaceMesh { vertices, triangles: vec![[0, 1, 2]] };
        let normals: Vec<_> = mesh.points().iter().map(|point| point.normal).collect();
        assert_eq!(normals, [Some(DVec3::Z), Some(DVec3::Z), Some(DVec3::Z), None]);
        assert_eq!(SurfaceMesh::default().points(), []);
    }
}
