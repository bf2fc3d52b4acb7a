use super::CloudPoint;
use crate::geometry::{Lattice, Moments};
use crate::{Cancel, Error};
use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::ops::Add;

/// Minimum number of points for a plane: a corner of a sheet still has four.
const LEAST_POINTS: f64 = 4.0;

/// Replaces the normals of a cloud by those of planes through each point and its neighbours, where such a
/// plane exists, keeping the side. Points without a normal stay without. The cloud must be thinned by cubes
/// with edges of `cell` metres (at least 0.0001), as by [`downsample`](super::downsample); neighbours are the
/// points in the 26 cubes around that do not face the other way.
///
/// Pixel normals are from planes through three points less than a millimetre apart, often less than the depth
/// noise: on a ball of 0.2 m in front of a D435i, their means are off by 26 degrees (median), and by 2
/// degrees after this.
///
/// If cancelled, some normals may be fitted and others not.
pub fn fit_normals(cloud: &mut [CloudPoint], cell: f64, cancel: &Cancel) -> Result<(), Error> {
    let lattice = Lattice::new(cell)?;
    let with_normal = cloud.iter().filter_map(|point| Some((point.position, point.normal?)));
    let cells: FxHashMap<IVec3, (DVec3, DVec3)> =
        with_normal.map(|(position, normal)| (lattice.key(position), (position, normal))).collect();
    cloud.par_iter_mut().try_for_each(|point| {
        cancel.check()?;
        let Some(normal) = point.normal else { return Ok(()) };
        let near = around(lattice.key(point.position)).filter_map(|key| cells.get(&key));
        let same_side = near.filter(|(_, other)| other.dot(normal) > 0.0);
        // Relative to the point, so that sums far from the origin lose no precision.
        let moments = same_side.map(|(position, _)| Moments::of(position - point.position));
        let moments = moments.fold(Moments::NONE, Moments::add);
        if let Some(fitted) = moments.normal().filter(|_| moments.n >= LEAST_POINTS) {
            point.normal = Some(if fitted.dot(normal) < 0.0 { -fitted } else { fitted });
        }
        Ok(())
    })
}

/// Returns a cell and the 26 around it.
fn around(key: IVec3) -> impl Iterator<Item = IVec3> {
    (0..27).map(move |i| key.saturating_add(IVec3::new(i % 3, i / 3 % 3, i / 9) - 1))
}

#[cfg(test)]
mod tests {
    use super::super::downsample;
    use super::*;
    use crate::geometry::random::Random;
    use crate::geometry::sphere;

    /// Slightly displaced points of a ball of 0.1 m, with very wrong normals.
    fn rough_ball(offset: DVec3) -> Vec<CloudPoint> {
        let mut random = Random::new(5, 0);
        let mut point = |direction: DVec3| CloudPoint {
            normal: Some((direction + 0.8 * random.in_cube()).normalize()),
            ..(offset + direction * 0.1 + 0.0003 * random.in_cube()).into()
        };
        downsample((0..60_000).map(|i| point(sphere::fibonacci(i, 60_000))), 0.002).unwrap()
    }

    #[test]
    fn rough_normals_become_smooth() {
        let offset = DVec3::new(3.0, -2.0, 1.0);
        let mut cloud = rough_ball(offset);
        fit_normals(&mut cloud, 0.002, &Cancel::default()).unwrap();
        let cosine = |point: &CloudPoint| point.normal.unwrap().dot((point.position - offset).normalize());
        let good = cloud.iter().filter(|point| cosine(point) > 0.98).count();
        assert!(good as f64 > 0.95 * cloud.len() as f64, "{good} of {}", cloud.len());
        assert!(cloud.iter().all(|point| (point.normal.unwrap().length() - 1.0).abs() < 1e-9));
    }

    #[test]
    fn the_sides_of_a_thin_plate_stay_two() {
        let grid = (0..900).map(|i| DVec3::new((i % 30) as f64, (i / 30) as f64, 0.5) * 0.01);
        let side = |z: f64| {
            let normal = DVec3::new(0.3, 0.2, z).normalize();
            grid.clone()
                .map(move |p| CloudPoint { normal: Some(normal), ..(p + 0.006 * z * DVec3::Z).into() })
        };
        let mut cloud: Vec<CloudPoint> = side(1.0).chain(side(-1.0)).collect();
        fit_normals(&mut cloud, 0.01, &Cancel::default()).unwrap();
        for (i, point) in cloud.iter().enumerate() {
            let expected = if i < 900 { DVec3::Z } else { -DVec3::Z };
            assert!(point.normal.unwrap().distance(expected) < 1e-6, "{point:?}");
        }
    }

    #[test]
    fn what_tells_no_plane_keeps_its_normal() {
        let lone = CloudPoint { normal: Some(DVec3::X), ..DVec3::ZERO.into() };
        let mut cloud = [lone, DVec3::ONE.into()];
        fit_normals(&mut cloud, 0.01, &Cancel::default()).unwrap();
        assert_eq!(cloud, [lone, DVec3::ONE.into()]);
        assert!(fit_normals(&mut cloud, 0.0, &Cancel::default()).is_err());
    }
}
