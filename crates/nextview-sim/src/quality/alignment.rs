use super::true_surface::{distances, evenly};
use crate::accuracy::SurfaceDistance;
use glam::DVec3;
use nextview::geometry::Pose;
use nextview::registration::{self, Pair, SearchReach};
use rayon::prelude::*;
use std::convert::Infallible;

/// Maximum number of points used for alignment.
const N_POINTS: usize = 5000;

/// Initial and final maximum pair distances, as shares of the object's longest side: 40 and 2 mm for an
/// object of 0.2 m, whose first pose may be wrong by 2 cm.
const REACH: [f64; 2] = [0.2, 0.01];

/// Returns the rigid motion that brings the finite points of a model closest to the true surface: true world
/// from the model's world.
///
/// Point-to-plane ICP from the identity with the nearest points of the true surface, robust against distant
/// points, in at most [`registration::MAX_STEPS`] steps. The motion is the identity if it would not lower the
/// mean distance from the surface, and for a model without points.
pub fn align(points: &[DVec3], surface: &SurfaceDistance) -> Pose {
    let points = evenly(points, N_POINTS);
    let size = surface.bounds().longest_side();
    let reach = SearchReach { first: REACH[0] * size, last: REACH[1] * size };
    let pairs = |pose: &Pose, reach: f64| {
        let pair = |point: &DVec3| {
            let point = pose.transform_point(*point);
            let (known, normal) = surface.foot_within(point, reach)?;
            (normal != DVec3::ZERO).then_some(Pair { point, known, normal })
        };
        Ok(points.par_iter().map(pair).collect::<Vec<_>>().into_iter().flatten().collect())
    };
    let (aligned, _) =
        registration::align(Pose::IDENTITY, reach, pairs).unwrap_or_else(|never: Infallible| match never {});
    let away = |pose: &Pose| {
        let moved: Vec<DVec3> = points.iter().map(|point| pose.transform_point(*point)).collect();
        distances(surface, &moved).iter().sum::<f64>()
    };
    if away(&aligned) < away(&Pose::IDENTITY) { aligned } else { Pose::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::mesh::sample_surface;
    use glam::DQuat;
    use nextview::geometry::random::Random;

    fn moved(points: &[DVec3], pose: &Pose) -> Vec<DVec3> {
        points.iter().map(|point| pose.transform_point(*point)).collect()
    }

    #[test]
    fn undoes_a_rigid_motion_of_a_part_of_the_surface() {
        for name in ["bracket", "teapot", "torus-knot"] {
            let mesh = builtin::by_name(name).unwrap();
            let surface = SurfaceDistance::new(&mesh);
            let mut points = sample_surface(&mesh, 3000, 3);
            points.retain(|point| point.z > mesh.bounds().center().z - 0.01);
            let turn = DQuat::from_scaled_axis(DVec3::new(0.03, -0.02, 0.04));
            let wrong = Pose::new(turn, DVec3::new(0.012, -0.008, 0.01)).unwrap();
            let rest = align(&moved(&points, &wrong), &surface) * wrong;
            for point in &points {
                let off = rest.transform_point(*point).distance(*point);
                assert!(off < 1e-5, "{name}: {off}");
            }
        }
    }

    #[test]
    fn some_points_that_are_far_off_do_not_matter() {
        let mesh = builtin::by_name("bracket").unwrap();
        let mut points = sample_surface(&mesh, 2000, 3);
        let mut random = Random::new(4, 0);
        points.extend((0..400).map(|_| mesh.bounds().center() + 0.15 * random.in_cube()));
        let wrong = Pose::new(DQuat::from_rotation_y(0.02), DVec3::new(0.01, 0.0, 0.004)).unwrap();
        let rest = align(&moved(&points, &wrong), &SurfaceDistance::new(&mesh)) * wrong;
        let off = rest.transform_point(mesh.bounds().min).distance(mesh.bounds().min);
        assert!(off < 2e-4, "{off}");
    }

    #[test]
    fn what_is_right_and_what_is_nothing_stay() {
        let mesh = builtin::by_name("mug").unwrap();
        let surface = SurfaceDistance::new(&mesh);
        assert_eq!(align(&[], &surface), Pose::IDENTITY);
        let points = sample_surface(&mesh, 2000, 3);
        let motion = align(&points, &surface);
        let off = |point: &DVec3| motion.transform_point(*point).distance(*point);
        assert!(points.iter().map(off).fold(0.0, f64::max) < 1e-9);
        let far: Vec<DVec3> = points.iter().map(|point| point + DVec3::X).collect();
        assert_eq!(align(&far, &surface), Pose::IDENTITY, "nothing to pair with");
    }
}
