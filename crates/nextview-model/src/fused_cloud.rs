use glam::{DVec3, IVec3};
use nextview::geometry::Lattice;
use nextview::surface::{CloudPoint, MeasuredCells, downsample_counted, fit_normals};
use nextview::{Cancel, Cancelled, Error};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Surfaces in neighbouring cells are the same if the cosine between their normals is above this.
const SAME_SURFACE: f64 = 0.7;

/// Fuses the points of all frames into one cloud: [thinned](nextview::surface::downsample) by cubes with
/// edges of `cell` metres (at least 0.0001), with [fitted normals](fit_normals), and each point in the middle
/// of the surface.
///
/// A noisy surface along the border of two cells leaves its outer points in one and its inner points in the
/// other, and neither mean is on the surface. Each point therefore moves along its normal to the mean of the
/// points in its cell and in the cells in front and behind, on the axis nearest to the normal, if these hold
/// the same surface: normals less than 45 degrees apart. Their weight falls with the squared sideways
/// distance, to zero at one cell, so curved surface is not flattened. This removes two fifths of the error
/// from a cloud of ten views of a D435i.
///
/// If the measured cells of all frames, of the same size, are given, points get the expected error of that
/// mean.
///
/// ```
/// use glam::DVec3;
/// use nextview::Cancel;
/// use nextview::surface::CloudPoint;
/// use nextview_model::fused_cloud;
///
/// // A wall at z = 1, the border of two layers of cells of a millimetre, measured 0.1 mm off to both sides.
/// let off = |i: i32| if i % 2 == 0 { 1e-4 } else { -1e-4 };
/// let at = |u: i32, v: i32| DVec3::new(f64::from(u) * 2e-4, f64::from(v) * 2e-4, 1.0 + off(u + v));
/// let point = |i: i32| CloudPoint { normal: Some(DVec3::Z), ..at(i % 100, i / 100).into() };
/// let cloud = fused_cloud((0..10_000).map(point), 1e-3, None, &Cancel::default()).unwrap();
/// let height = |point: &CloudPoint| (point.position.z - 1.0).abs();
/// assert!(cloud.iter().map(height).sum::<f64>() < 2e-5 * cloud.len() as f64);
/// ```
pub fn fused_cloud(
    points: impl IntoIterator<Item = impl Into<CloudPoint>>,
    cell: f64,
    measured: Option<&MeasuredCells>,
    cancel: &Cancel,
) -> Result<Vec<CloudPoint>, Error> {
    let lattice = Lattice::new(cell)?;
    let (mut cloud, counts): (Vec<CloudPoint>, Vec<usize>) = downsample_counted(points, cell)?.unzip();
    fit_normals(&mut cloud, cell, cancel)?;
    let keys = cloud.iter().map(|point| lattice.key(point.position));
    let means: FxHashMap<IVec3, Mean> = keys.zip(cloud.iter().copied().zip(counts)).collect();
    cloud.par_iter_mut().try_for_each(|point| {
        cancel.check()?;
        let key = lattice.key(point.position);
        let Some(normal) = point.normal else { return Ok(()) };
        let column = column(&means, key, point.position, normal, cell);
        point.position += normal * mean_height(&column, point.position, normal);
        let weights: Vec<(IVec3, f64)> = column.iter().map(|(key, _, weight)| (*key, *weight)).collect();
        let error = measured.and_then(|measured| measured.error_of(&weights, point.position, normal));
        point.error = error.map(|error| error as f32);
        Ok::<(), Cancelled>(())
    })?;
    Ok(cloud)
}

/// The mean of a cell, and its number of points.
type Mean = (CloudPoint, usize);

/// Returns the cells with the surface of a cell, each with its mean and the weight of its points: the cell
/// itself, and those in front and behind with the same surface, with less weight the farther their mean is
/// away sideways.
fn column(
    means: &FxHashMap<IVec3, Mean>,
    key: IVec3,
    position: DVec3,
    normal: DVec3,
    cell: f64,
) -> Vec<(IVec3, &Mean, f64)> {
    let size = normal.abs();
    // The first axis on ties.
    let axis = size.cmpge(DVec3::splat(size.max_element())).bitmask().trailing_zeros();
    let axis = IVec3::AXES[axis as usize];
    let weight = |step: IVec3, (mean, _): &Mean| {
        if step == IVec3::ZERO {
            return 1.0;
        }
        let is_same = mean.normal.is_some_and(|other| other.dot(normal) > SAME_SURFACE);
        let sideways = (mean.position - position).reject_from_normalized(normal);
        if is_same { (1.0 - sideways.length_squared() / (cell * cell)).max(0.0) } else { 0.0 }
    };
    let member = |step: IVec3| {
        let key = key.saturating_add(step);
        let mean = means.get(&key)?;
        Some((key, mean, weight(step, mean))).filter(|(_, _, weight)| *weight > 0.0)
    };
    [IVec3::ZERO, -axis, axis].into_iter().filter_map(member).collect()
}

/// Returns the mean height of the points of these cells above a point with this normal.
///
/// Heights are along the mean of both normals, which is perpendicular to the chord of an arc: they are zero
/// on a ball without noise.
fn mean_height(column: &[(IVec3, &Mean, f64)], position: DVec3, normal: DVec3) -> f64 {
    let (sum, n) = column.iter().fold((0.0, 0.0), |(sum, n), (_, (mean, count), weight)| {
        let n_here = *count as f64 * weight;
        let between = (normal + mean.normal.unwrap_or(normal)).normalize();
        (sum + n_here * between.dot(mean.position - position), n + n_here)
    });
    sum / n
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic_frames::of_depth;
    use nextview::geometry::{Aabb, random::Random};
    use nextview::sensor::{DepthNoise, Frame, SurfaceNoise};

    /// Four to five pixels wide.
    const CELL: f64 = 0.043;
    const NOISE: f64 = 0.001;

    /// Frames of a wall at this depth, with noise in each pixel.
    fn noisy(n: usize, depth: f64) -> Vec<Frame> {
        let frame = |i: usize| {
            let mut random = Random::new(i as u64, 0);
            // Three numbers in -1..1 have the variance 1.
            let mut noise = || (0..4).map(|_| random.in_cube().element_sum()).sum::<f64>() / 2.0;
            let noise: Vec<f64> = (0..160 * 120).map(|_| noise()).collect();
            of_depth(160, 120, |u, v| (depth + NOISE * noise[(v * 160 + u) as usize]) as f32)
        };
        (0..n).map(frame).collect()
    }

    fn rms(values: impl Iterator<Item = f64>) -> f64 {
        let (sum, n) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value * value, n + 1.0));
        f64::sqrt(sum / n)
    }

    #[test]
    fn a_wall_along_the_border_of_cells_is_as_accurate_as_one_within_them_and_its_error_is_known() {
        let depth = DepthNoise { constant: NOISE, ..DepthNoise::default() };
        let error = SurfaceNoise { depth, ..SurfaceNoise::default() };
        for wall in [0.473, 0.4945, 0.4735] {
            let bounds = Aabb::cube(DVec3::Z * wall, 0.16);
            let frames = noisy(6, wall);
            let mut measured = MeasuredCells::new(CELL, error).unwrap();
            frames.iter().for_each(|frame| measured.add(frame, bounds, &Cancel::default()).unwrap());
            let points =
                frames.iter().flat_map(|frame| nextview::surface::frame_points(frame, None, bounds).unwrap());
            let cloud = fused_cloud(points, CELL, Some(&measured), &Cancel::default()).unwrap();
            let off = rms(cloud.iter().map(|point| point.position.z - wall));
            let expected = rms(cloud.iter().map(|point| f64::from(point.error.unwrap())));
            assert!((0.7..1.4).contains(&(off / expected)), "{wall}: {off} {expected}");
        }
    }

    #[test]
    fn curved_surface_without_noise_hardly_moves() {
        let radius = 6.0 * CELL;
        let views =
            nextview::view::generate::fibonacci_sphere(DVec3::splat(0.3 * CELL), radius, 40_000).unwrap();
        let points: Vec<CloudPoint> = (0..views.len())
            .map(|i| {
                let position = views.pose(i).translation();
                let normal = (position - DVec3::splat(0.3 * CELL)) / radius;
                CloudPoint { normal: Some(normal), ..position.into() }
            })
            .collect();
        let off = |cloud: &[CloudPoint]| {
            rms(cloud.iter().map(|point| point.position.distance(DVec3::splat(0.3 * CELL)) - radius))
        };
        let plain = off(&nextview::surface::downsample(points.clone(), CELL).unwrap());
        let fused = off(&fused_cloud(points, CELL, None, &Cancel::default()).unwrap());
        // With heights along the points' normals, the error would be twice as large.
        assert!(fused < 1.25 * plain, "{fused} {plain}");
    }

    #[test]
    fn the_sides_of_a_thin_plate_stay_where_they_are() {
        let side = |z: f64| {
            let at = move |i: i32| DVec3::new(f64::from(i % 30), f64::from(i / 30), 0.4 * z) * CELL / 3.0;
            let point = move |i| CloudPoint { normal: Some(DVec3::Z * z), ..at(i).into() };
            (0..900).map(point)
        };
        let cloud = fused_cloud(side(1.0).chain(side(-1.0)), CELL, None, &Cancel::default()).unwrap();
        for point in cloud {
            let side = point.normal.unwrap().z.signum();
            assert!((point.position.z - side * 0.4 * CELL / 3.0).abs() < 1e-9, "{point:?}");
        }
    }

    #[test]
    fn points_without_normals_are_only_thinned() {
        let points = [0.1, 0.3, 1.5].map(|x| CloudPoint::from(DVec3::splat(x * CELL)));
        let expected = nextview::surface::downsample(points, CELL).unwrap();
        assert_eq!(fused_cloud(points, CELL, None, &Cancel::default()).unwrap(), expected);
        assert!(fused_cloud(points, 0.0, None, &Cancel::default()).is_err());
    }
}
