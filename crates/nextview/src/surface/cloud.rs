use super::CloudPoint;
use crate::Error;
use crate::geometry::Lattice;
use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

/// Thins a cloud to the mean of the points in each cube with edges of `cell` metres (at least 0.0001), in the
/// order in which the cubes were first met. Points that are not finite, or more than [`Lattice::REACH`] cubes
/// from the origin along an axis, are skipped. To merge many frames, chain their points.
///
/// Normal and colour are means over the points that have one; if no point has one, or normals cancel out, the
/// result has none. [`MeasuredCells`](super::MeasuredCells) gives the expected error.
///
/// ```
/// use glam::DVec3;
/// use nextview::surface::{CloudPoint, downsample};
///
/// let points = [DVec3::new(0.1, 0.5, 0.5), DVec3::new(2.5, 0.5, 0.5), DVec3::new(0.3, 0.5, 0.5)];
/// let thinned = downsample(points, 1.0).unwrap();
/// assert_eq!(thinned, [DVec3::new(0.2, 0.5, 0.5), DVec3::new(2.5, 0.5, 0.5)].map(CloudPoint::from));
/// ```
pub fn downsample(
    points: impl IntoIterator<Item = impl Into<CloudPoint>>,
    cell: f64,
) -> Result<Vec<CloudPoint>, Error> {
    Ok(downsample_counted(points, cell)?.map(|(point, _)| point).collect())
}

/// As [`downsample`], with the number of points in each mean.
pub fn downsample_counted(
    points: impl IntoIterator<Item = impl Into<CloudPoint>>,
    cell: f64,
) -> Result<impl Iterator<Item = (CloudPoint, usize)>, Error> {
    let lattice = Lattice::new(cell)?;
    let mut slots: FxHashMap<IVec3, usize> = FxHashMap::default();
    let mut pools: Vec<CubePool> = Vec::new();
    let is_near = |point: &CloudPoint| {
        let cubes = lattice.to_voxels(point.position).abs();
        cubes.is_finite() && cubes.max_element() <= f64::from(Lattice::REACH)
    };
    for point in points.into_iter().map(Into::into).filter(is_near) {
        let slot = *slots.entry(lattice.key(point.position)).or_insert(pools.len());
        if slot == pools.len() {
            pools.push(CubePool::default());
        }
        pools[slot].add(&point);
    }
    Ok(pools.into_iter().map(|pool| (pool.mean(), pool.n)))
}

/// Sums over the points of a cube.
#[derive(Clone, Copy, Default)]
struct CubePool {
    n: usize,
    position: DVec3,
    normal: DVec3,
    n_colors: usize,
    color: DVec3,
}

/// The direction of a sum of normals shorter than this is only rounding.
const CANCELLED: f64 = 1e-6;

impl CubePool {
    fn add(&mut self, point: &CloudPoint) {
        self.n += 1;
        self.position += point.position;
        self.normal += point.normal.unwrap_or_default();
        if let Some(color) = point.color {
            self.n_colors += 1;
            self.color += DVec3::from_array(color.map(f64::from));
        }
    }

    fn mean(&self) -> CloudPoint {
        let length = self.normal.length();
        let color = self.color / self.n_colors as f64;
        CloudPoint {
            position: self.position / self.n as f64,
            normal: (length > CANCELLED).then(|| self.normal / length),
            color: (self.n_colors > 0).then(|| color.to_array().map(|value| value.round() as u8)),
            error: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn one_point_a_cell_at_the_mean(points in prop::collection::vec(prop::array::uniform3(-1.0..1.0), 0..80)) {
            let points: Vec<DVec3> = points.into_iter().map(DVec3::from_array).collect();
            let lattice = Lattice::new(0.4).unwrap();
            let mut expected: Vec<(IVec3, Vec<DVec3>)> = Vec::new();
            for &point in &points {
                let key = lattice.key(point);
                match expected.iter_mut().find(|(k, _)| *k == key) {
                    Some((_, group)) => group.push(point),
                    None => expected.push((key, vec![point])),
                }
            }
            let found = downsample(points, 0.4).unwrap();
            prop_assert_eq!(found.len(), expected.len());
            for (point, (_, group)) in found.iter().zip(&expected) {
                let mean = group.iter().sum::<DVec3>() / group.len() as f64;
                prop_assert!(point.position.distance(mean) < 1e-12);
            }
        }
    }

    #[test]
    fn takes_nothing_and_refuses_no_cell() {
        let none: [DVec3; 0] = [];
        assert_eq!(downsample(none, 0.1).unwrap(), []);
        assert_eq!(downsample([DVec3::NAN, DVec3::INFINITY], 0.1).unwrap(), []);
        assert_eq!(downsample([DVec3::splat(1e300), DVec3::splat(f64::MAX)], 0.1).unwrap(), []);
        assert!(downsample(none, 0.0).is_err());
    }

    #[test]
    fn normals_and_colours_are_means_of_those_there_are() {
        let at = |x: f64, normal: Option<DVec3>, color: Option<[u8; 3]>| CloudPoint {
            position: DVec3::new(x, 0.5, 0.5),
            normal,
            color,
            error: None,
        };
        let points = [
            at(0.1, Some(DVec3::X), Some([10, 0, 255])),
            at(0.2, None, None),
            at(0.3, Some(DVec3::Y), Some([21, 1, 255])),
            at(1.1, None, None),
            at(2.1, Some(DVec3::Z), None),
            at(2.2, Some(-DVec3::Z), Some([1, 2, 3])),
        ];
        let thinned = downsample(points, 1.0).unwrap();
        let diagonal = DVec3::new(1.0, 1.0, 0.0).normalize();
        assert!(thinned[0].normal.unwrap().distance(diagonal) < 1e-12);
        assert_eq!(thinned[0].color, Some([16, 1, 255]));
        assert_eq!((thinned[1].normal, thinned[1].color), (None, None));
        assert_eq!((thinned[2].normal, thinned[2].color), (None, Some([1, 2, 3])), "opposite normals cancel");
    }
}
