use glam::{DVec3, IVec3};
use nextview::geometry::Lattice;
use nextview::surface::CloudPoint;
use nextview::{Cancel, Error};
use rustc_hash::FxHashMap;

/// Search distance, in cells. Between silhouettes, the surface of a distance field was up to 2.7 of its
/// voxels from the nearest point.
const REACH: i32 = 4;

/// Gives every point, such as a vertex of a mesh, the colour and the expected error of the nearest point of a
/// cloud that has at least one of them, unless it is farther away than four times `cell` metres (at least
/// 0.0001). The cloud must be thinned by cubes with edges of `cell`, as by
/// [`downsample`](nextview::surface::downsample); if a cube holds several such points, the last counts.
///
/// ```
/// use glam::DVec3;
/// use nextview::Cancel;
/// use nextview::surface::CloudPoint;
/// use nextview_model::take_nearest;
///
/// let red = CloudPoint { color: Some([255, 0, 0]), ..CloudPoint::from(DVec3::ZERO) };
/// let mut points = [DVec3::X * 0.01, DVec3::X].map(CloudPoint::from);
/// take_nearest(&mut points, &[red], 0.01, &Cancel::default()).unwrap();
/// assert_eq!(points.map(|point| point.color), [Some([255, 0, 0]), None]);
/// ```
///
/// If cancelled, some points may have their colours and others not.
pub fn take_nearest(
    points: &mut [CloudPoint],
    cloud: &[CloudPoint],
    cell: f64,
    cancel: &Cancel,
) -> Result<(), Error> {
    let lattice = Lattice::new(cell)?;
    let known = cloud.iter().filter(|point| point.color.is_some() || point.error.is_some());
    let cells: FxHashMap<IVec3, &CloudPoint> =
        known.map(|point| (lattice.key(point.position), point)).collect();
    for point in points {
        cancel.check()?;
        let found = (1..=REACH).find_map(|reach| {
            let (nearest, distance) = nearest_in(&cells, lattice.key(point.position), reach, point.position)?;
            // A nearer one may lie outside the searched cells.
            (distance <= reach as f64 * cell).then_some(nearest)
        });
        point.color = found.and_then(|found| found.color);
        point.error = found.and_then(|found| found.error);
    }
    Ok(())
}

/// Returns the nearest point in the cells up to `reach` cells away, and its distance.
fn nearest_in<'a>(
    cells: &FxHashMap<IVec3, &'a CloudPoint>,
    key: IVec3,
    reach: i32,
    to: DVec3,
) -> Option<(&'a CloudPoint, f64)> {
    let side = || -reach..=reach;
    let offsets = side().flat_map(|z| side().flat_map(move |y| side().map(move |x| IVec3::new(x, y, z))));
    let near = offsets.filter_map(|offset| cells.get(&key.saturating_add(offset)));
    let near = near.map(|point| (*point, point.position.distance(to)));
    near.min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::random::Random;

    /// The slow twin: all points.
    #[test]
    fn the_colour_is_that_of_the_nearest() {
        let mut random = Random::new(3, 0);
        let cloud: Vec<CloudPoint> = (0..400_u32)
            .map(|i| CloudPoint {
                color: (i % 3 > 0).then_some([i as u8, (i / 256) as u8, 0]),
                ..CloudPoint::from(random.in_cube())
            })
            .collect();
        let cloud = nextview::surface::downsample(cloud, 0.3).unwrap();
        let mut points: Vec<CloudPoint> = (0..200).map(|_| (random.in_cube() * 0.9).into()).collect();
        take_nearest(&mut points, &cloud, 0.3, &Cancel::default()).unwrap();
        for point in points {
            let colored = cloud.iter().filter(|other| other.color.is_some());
            let distance = |other: &&CloudPoint| other.position.distance(point.position);
            let nearest = colored.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            assert!(distance(&nearest) < 1.2, "dense enough");
            assert_eq!(point.color, nearest.color);
        }
    }

    #[test]
    fn nothing_near_is_no_colour() {
        let mut points = [CloudPoint { color: Some([1; 3]), ..DVec3::ZERO.into() }];
        take_nearest(&mut points, &[], 0.1, &Cancel::default()).unwrap();
        assert_eq!(points[0].color, None);
        assert!(take_nearest(&mut points, &[], 0.0, &Cancel::default()).is_err());
    }
}
