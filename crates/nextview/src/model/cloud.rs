use crate::Error;
use crate::geometry::Lattice;
use glam::{DVec3, IVec3};
use rustc_hash::FxHashMap;

/// Thins a cloud: the mean of the points in each cube with edges of `cell` metres (at least 0.0001), in the order in
/// which the cubes were first met. Points that are not finite are left out. The points of many frames are
/// merged by chaining them.
///
/// ```
/// use glam::DVec3;
/// use nextview::model::downsample;
///
/// let points = [DVec3::new(0.1, 0.5, 0.5), DVec3::new(2.5, 0.5, 0.5), DVec3::new(0.3, 0.5, 0.5)];
/// let thinned = downsample(points, 1.0).unwrap();
/// assert_eq!(thinned, [DVec3::new(0.2, 0.5, 0.5), DVec3::new(2.5, 0.5, 0.5)]);
/// ```
pub fn downsample(points: impl IntoIterator<Item = DVec3>, cell: f64) -> Result<Vec<DVec3>, Error> {
    let lattice = Lattice::new(cell)?;
    let mut slots: FxHashMap<IVec3, usize> = FxHashMap::default();
    let mut sums: Vec<(DVec3, usize)> = Vec::new();
    for point in points.into_iter().filter(|point| point.is_finite()) {
        let slot = *slots.entry(lattice.key(point)).or_insert(sums.len());
        if slot == sums.len() {
            sums.push((DVec3::ZERO, 0));
        }
        sums[slot].0 += point;
        sums[slot].1 += 1;
    }
    Ok(sums.into_iter().map(|(sum, n)| sum / n as f64).collect())
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
                prop_assert!(point.distance(mean) < 1e-12);
            }
        }
    }

    #[test]
    fn takes_nothing_and_refuses_no_cell() {
        assert_eq!(downsample([], 0.1).unwrap(), []);
        assert_eq!(downsample([DVec3::NAN, DVec3::INFINITY], 0.1).unwrap(), []);
        assert!(downsample([], 0.0).is_err());
    }
}
