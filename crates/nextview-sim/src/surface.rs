//! Coverage of the true surface by measured points.

use crate::mesh::{TriangleMesh, surface_samples};
use fixedbitset::FixedBitSet;
use glam::{DVec3, IVec3};
use nextview::geometry::Aabb;
use nextview::sensor::Frame;
use rustc_hash::FxHashMap;

/// Distances beyond this, metres, are not distinguished.
const FAR: f64 = 0.005;

/// Surface coverage: the share of samples of the true surface, uniform by area, with a measured point nearby.
#[derive(Clone, Debug)]
pub struct SurfaceCoverage {
    samples: Vec<DVec3>,
    /// Squared distance to the nearest measured point, infinite beyond `FAR`.
    nearest_sq: Vec<f64>,
    /// The samples in and around every cell of size `FAR`: looking up a point takes one cell, not 27.
    cells: FxHashMap<IVec3, Vec<u32>>,
    /// Points outside, on the walls behind the object, are not near any sample.
    bounds: Aabb,
}

impl SurfaceCoverage {
    /// Creates the coverage of a mesh without measured points.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let samples = surface_samples(mesh);
        let mut cells: FxHashMap<IVec3, Vec<u32>> = FxHashMap::default();
        for (i, sample) in samples.iter().enumerate() {
            for offset in neighbor_offsets() {
                cells.entry(cell(*sample) + offset).or_default().push(i as u32);
            }
        }
        let mut bounds = mesh.bounds();
        bounds.min -= FAR;
        bounds.max += FAR;
        Self { nearest_sq: vec![f64::INFINITY; samples.len()], samples, cells, bounds }
    }

    /// Adds the points measured by a frame.
    pub fn add(&mut self, frame: &Frame) {
        self.add_points(frame.points_in(self.bounds));
    }

    /// Forgets all measured points.
    pub fn clear(&mut self) {
        self.nearest_sq.fill(f64::INFINITY);
    }

    /// Adds measured points.
    pub fn add_points(&mut self, points: impl IntoIterator<Item = DVec3>) {
        for point in points {
            for &i in self.cells.get(&cell(point)).into_iter().flatten() {
                let distance_sq = self.samples[i as usize].distance_squared(point);
                let nearest = &mut self.nearest_sq[i as usize];
                if distance_sq <= FAR * FAR && distance_sq < *nearest {
                    *nearest = distance_sq;
                }
            }
        }
    }

    /// Returns the samples, by number, with a measured point within `distance` metres, which must be at most
    /// 0.005.
    pub fn within(&self, distance: f64) -> FixedBitSet {
        assert!(distance <= FAR, "distances above {FAR} m are not kept");
        let mut within = FixedBitSet::with_capacity(self.samples.len());
        let near = self.nearest_sq.iter().enumerate().filter(|&(_, &d)| d <= distance * distance);
        near.for_each(|(sample, _)| within.insert(sample));
        within
    }

    /// Returns the share, 0..=1, of samples with a measured point within `distance` metres.
    pub fn share_within(&self, distance: f64) -> f64 {
        self.within(distance).count_ones(..) as f64 / self.samples.len() as f64
    }

    /// Returns the shares within 1, 2 and 5 mm.
    pub fn shares(&self) -> [f64; 3] {
        [0.001, 0.002, 0.005].map(|distance| self.share_within(distance))
    }
}

fn cell(point: DVec3) -> IVec3 {
    (point / FAR).floor().as_ivec3()
}

fn neighbor_offsets() -> impl Iterator<Item = IVec3> {
    (-1..=1).flat_map(|z| (-1..=1).flat_map(move |y| (-1..=1).map(move |x| IVec3::new(x, y, z))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::mesh::{N_SAMPLES, sample_surface};

    #[test]
    fn equals_the_distance_to_every_point() {
        let mesh = builtin::by_name("bracket").unwrap();
        let mut coverage = SurfaceCoverage::new(&mesh);
        let points: Vec<DVec3> =
            sample_surface(&mesh, 400, 9).iter().map(|p| *p + DVec3::new(0.001, 0.0, -0.0015)).collect();
        coverage.add_points(points.iter().copied());
        for distance in [0.001, 0.002, 0.005] {
            let near = |s: &&DVec3| points.iter().any(|p| p.distance(**s) <= distance);
            let expected = coverage.samples.iter().filter(near).count() as f64 / N_SAMPLES as f64;
            assert_eq!(coverage.share_within(distance), expected);
        }
    }

    #[test]
    fn the_surface_itself_covers_all_of_it() {
        let mesh = builtin::by_name("mug").unwrap();
        let mut coverage = SurfaceCoverage::new(&mesh);
        assert_eq!(coverage.share_within(0.005), 0.0);
        coverage.add_points(surface_samples(&mesh));
        assert_eq!(coverage.share_within(0.001), 1.0);
    }
}
