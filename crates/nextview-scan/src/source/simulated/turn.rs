use crate::{Fault, PlacementRecord, ScanRecord};
use glam::{DQuat, DVec3};
use nextview::geometry::Pose;
use nextview::geometry::random::Random;
use nextview::placement::{Rest, rests};
use nextview_sim::mesh::TriangleMesh;
use nextview_sim::quality::TrueSurface;
use std::f64::consts::PI;
use std::path::Path;

/// Random stream of the turn about the vertical, separate from that of the noise.
const STREAM: u64 = 17;

/// Simulates a person who turns the object as requested by the results in a folder: into the nearest stable
/// pose, at a random angle about the vertical, at its old position and height.
pub(super) fn turn(mesh: &TriangleMesh, results: &Path, seed: u64) -> Result<Pose, Fault> {
    let Some(PlacementRecord { down, .. }) = ScanRecord::read(results)?.next_placement else {
        let fault = Fault::data("requests no other placement of the object").in_file(results);
        return Err(
            fault.with_remedy("all of the object was seen, or its table is unknown: leave out `after`")
        );
    };
    let asked = DVec3::from_array(down);
    let nearer = |a: &Rest, b: &Rest| a.down.dot(asked).total_cmp(&b.down.dot(asked));
    let rest = rests(mesh.vertices(), center_of_mass(mesh)).into_iter().max_by(nearer);
    let down = rest.map_or(asked, |rest| rest.down);
    let chance = DQuat::from_rotation_z(Random::new(seed, STREAM).range(-PI, PI));
    let rotation = (chance * DQuat::from_rotation_arc(down, DVec3::NEG_Z)).normalize();
    let (to, from) = (mesh.bounds(), mesh.transformed(&Pose::new(rotation, DVec3::ZERO)?)?.bounds());
    let offset = (to.center() - from.center()).with_z(to.min.z - from.min.z);
    Ok(Pose::new(rotation, offset)?)
}

/// Mean distance in metres by which a found turn misplaces the true surface. For a symmetric object, every
/// pose that maps it onto itself counts as right.
pub(super) fn turn_error(surface: &TrueSurface, true_turn: &Pose, found: &Pose) -> f64 {
    let found_from_true = *found * true_turn.inverse();
    let distances =
        surface.samples().iter().map(|point| surface.distance().at(found_from_true.transform_point(*point)));
    distances.sum::<f64>() / surface.samples().len() as f64
}

/// The centre of mass of the volume enclosed by a mesh; the middle of its box if there is none.
fn center_of_mass(mesh: &TriangleMesh) -> DVec3 {
    let middle = mesh.bounds().center();
    let (mut volume, mut sum) = (0.0, DVec3::ZERO);
    for [a, b, c] in (0..mesh.triangles().len()).map(|i| mesh.corners(i).map(|corner| corner - middle)) {
        let part = a.cross(b).dot(c) / 6.0;
        (volume, sum) = (volume + part, sum + part * (a + b + c) / 4.0);
    }
    let center = middle + sum / volume;
    if center.is_finite() && mesh.bounds().contains(center) { center } else { middle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nextview::geometry::Aabb;

    fn brick(size: DVec3) -> TriangleMesh {
        let corners = Aabb { min: DVec3::ZERO, max: size }.corners();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        TriangleMesh::new(corners.to_vec(), triangles.collect()).unwrap()
    }

    #[test]
    fn the_center_of_mass_of_a_brick_is_its_middle() {
        let mesh = brick(DVec3::new(1.0, 2.0, 3.0));
        assert!(center_of_mass(&mesh).distance(mesh.bounds().center()) < 1e-9);
        // A second, smaller brick on one side shifts the centre there.
        let small = brick(DVec3::ONE).translated(DVec3::new(1.0, 0.0, 0.0)).unwrap();
        let vertices = [mesh.vertices(), small.vertices()].concat();
        let triangles = small.triangles().iter().map(|corners| corners.map(|i| i + 8));
        let triangles = mesh.triangles().iter().copied().chain(triangles).collect();
        let both = TriangleMesh::new(vertices, triangles).unwrap();
        assert!(center_of_mass(&both).distance(DVec3::new(4.5, 6.5, 9.5) / 7.0) < 1e-9);
    }

    #[test]
    fn a_turn_that_puts_a_brick_onto_itself_is_right() {
        let mesh = brick(DVec3::new(0.1, 0.06, 0.04));
        let mesh = mesh.translated(-mesh.bounds().center()).unwrap();
        let surface = TrueSurface::new(&mesh);
        let pose = |angle: f64, x: f64| Pose::new(DQuat::from_rotation_x(angle), DVec3::X * x).unwrap();
        let error = |found: Pose| turn_error(&surface, &pose(0.3, 0.0), &(found * pose(0.3, 0.0)));
        assert!(error(pose(PI, 0.0)) < 1e-9);
        assert!(error(pose(0.0, 0.001)) > 1e-4 && error(pose(0.0, 0.001)) < 1e-3);
        assert!(error(pose(0.5 * PI, 0.0)) > 2e-3);
    }
}
