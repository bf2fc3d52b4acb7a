use super::utility;
use super::{Choice, Plan, Situation, ViewPlanner};
use crate::Error;
use crate::geometry::Pose;
use glam::DVec3;
use std::f64::consts::PI;

/// Takes views from all around the object, whatever they show. Pose estimators want such reference views,
/// with one near every direction.
///
/// The next view is the one whose direction, seen from the middle of the box, is farthest from those of all
/// frames so far, or of the visited views if only a map is known. Only views that show the middle of the box
/// are taken. After any number of views, the largest angle between a candidate's direction and the nearest
/// one taken is at most twice that of the best choice of the same size (Gonzalez 1985, *Clustering to
/// minimize the maximum intercluster distance*).
///
/// The score is the angle to the nearest direction, radians; pi before the first view.
///
/// ```
/// use glam::{DVec3, IVec3, UVec3};
/// use nextview::Cancel;
/// use nextview::geometry::{Lattice, VoxelBlock};
/// use nextview::map::Snapshot;
/// use nextview::planner::{EvenViews, Situation, ViewPlanner};
/// use nextview::sensor::Intrinsics;
/// use nextview::view::generate;
///
/// let block = VoxelBlock::new(IVec3::splat(-2), UVec3::splat(4)).unwrap();
/// let snapshot = Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None);
/// let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 10).unwrap();
/// let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
/// let situation = Situation::new(&snapshot, &views, &camera, &cancel).with_visited(&[0]).unwrap();
/// // After the first of a spiral from pole to pole, the last comes next.
/// assert_eq!(EvenViews.plan(&situation).unwrap().choice.unwrap().view, 9);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EvenViews;

impl ViewPlanner for EvenViews {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let middle = situation.snapshot().lattice().bounds(&situation.snapshot().block()).center();
        let taken = directions_taken(situation, middle);
        let shows_middle = |view: &usize| shows(situation, *view, middle);
        let rate = |view: usize| {
            let direction = direction(&situation.views().pose(view), middle);
            let angle =
                taken.iter().map(|taken| direction.dot(*taken).clamp(-1.0, 1.0).acos()).fold(PI, f64::min);
            Choice::new(view, angle)
        };
        let choice = utility::best(situation.open_views().into_iter().filter(shows_middle).map(rate));
        let choice = choice.map(|choice| {
            let explanation = Some([("angle_deg", choice.score.to_degrees())].into());
            Choice { explanation, ..choice }
        });
        Ok(Plan { choice, ..Plan::default() })
    }

    fn seeks_surface(&self) -> bool {
        false
    }
}

fn directions_taken(situation: &Situation<'_>, middle: DVec3) -> Vec<DVec3> {
    match situation.frames() {
        [] => {
            situation.visited().iter().map(|&view| direction(&situation.views().pose(view), middle)).collect()
        }
        frames => frames.iter().map(|frame| direction(&frame.world_from_camera(), middle)).collect(),
    }
}

/// From the middle to the camera, unit; zero for a camera in the middle.
fn direction(world_from_camera: &Pose, middle: DVec3) -> DVec3 {
    (world_from_camera.translation() - middle).normalize_or_zero()
}

/// Whether the point is in the image of a view, at a depth that the camera measures.
fn shows(situation: &Situation<'_>, view: usize, point: DVec3) -> bool {
    let in_camera = situation.views().pose(view).inverse().transform_point(point);
    let pixel = situation.intrinsics().project(in_camera);
    let range = situation.depth_range();
    pixel.is_some_and(|pixel| situation.intrinsics().contains(pixel))
        && (range.min..=range.max).contains(&in_camera.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cancel;
    use crate::geometry::{Lattice, VoxelBlock};
    use crate::map::Snapshot;
    use crate::sensor::{DepthImage, DepthRange, Frame, Intrinsics};
    use crate::view::{ViewSpace, generate, look_at};
    use glam::{IVec3, UVec3};

    fn box_around(middle: IVec3) -> Snapshot {
        let block = VoxelBlock::new(middle - 4, UVec3::splat(8)).unwrap();
        Snapshot::from_fn(Lattice::new(0.01).unwrap(), block, |_| None)
    }

    /// The views that a scan takes one after the other, from the first on.
    fn taken(views: &ViewSpace, first: usize, n_views: usize) -> Vec<usize> {
        let (snapshot, camera, cancel) = (box_around(IVec3::ZERO), Intrinsics::d435i(), Cancel::default());
        let mut visited = vec![first];
        while visited.len() < n_views {
            let situation =
                Situation::new(&snapshot, views, &camera, &cancel).with_visited(&visited).unwrap();
            let Some(choice) = EvenViews.plan(&situation).unwrap().choice else { break };
            visited.push(choice.view);
        }
        visited
    }

    fn angle(views: &ViewSpace, a: usize, b: usize) -> f64 {
        views.pose(a).translation().angle_between(views.pose(b).translation())
    }

    /// The largest angle between any candidate and the nearest of these.
    fn largest_angle(views: &ViewSpace, chosen: &[usize]) -> f64 {
        let nearest = |view| chosen.iter().map(|&other| angle(views, view, other)).fold(PI, f64::min);
        (0..views.len()).map(nearest).fold(0.0, f64::max)
    }

    #[test]
    fn each_view_is_the_farthest_from_all_before() {
        let views = generate::shell(DVec3::ZERO, 0.08, 80, 3).unwrap();
        let visited = taken(&views, 11, 15);
        for n in 1..visited.len() {
            let gap =
                |view: usize| visited[..n].iter().map(|&other| angle(&views, view, other)).fold(PI, f64::min);
            let widest = (0..views.len()).map(gap).fold(0.0, f64::max);
            assert!((gap(visited[n]) - widest).abs() < 1e-7, "view {n}: {} of {widest}", gap(visited[n]));
        }
    }

    #[test]
    fn the_largest_angle_is_at_most_twice_the_least_that_is_possible() {
        for seed in 0..10 {
            let views = generate::shell(DVec3::ZERO, 0.08, 16, seed).unwrap();
            let visited = taken(&views, 0, 5);
            for n in 1..=visited.len() {
                let choices = (0_u32..1 << views.len()).filter(|choice| choice.count_ones() as usize == n);
                let chosen =
                    |choice: u32| (0..views.len()).filter(|view| choice >> view & 1 == 1).collect::<Vec<_>>();
                let least = choices.map(|choice| largest_angle(&views, &chosen(choice))).fold(PI, f64::min);
                let found = largest_angle(&views, &visited[..n]);
                assert!(found <= 2.0 * least + 1e-9, "{n} views: {found} beside {least}");
            }
        }
    }

    #[test]
    fn views_past_the_object_and_out_of_range_are_left_out() {
        let at = |position: DVec3, target: DVec3| look_at(position, target).unwrap();
        let past = at(DVec3::Z * 0.4, DVec3::new(1.0, 0.0, 0.4));
        let views = ViewSpace::new(vec![
            at(DVec3::X * 0.4, DVec3::ZERO),
            past,
            at(DVec3::X * -0.9, DVec3::ZERO),
            at(DVec3::Y * 0.4, DVec3::ZERO),
        ])
        .unwrap();
        let (snapshot, camera, cancel) = (box_around(IVec3::ZERO), Intrinsics::d435i(), Cancel::default());
        let situation = Situation::new(&snapshot, &views, &camera, &cancel).with_visited(&[0]).unwrap();
        let choice = |situation: &Situation<'_>| EvenViews.plan(situation).unwrap().choice.unwrap();
        assert_eq!((choice(&situation).view, choice(&situation).runner_up), (2, Some(3)));
        let near = situation.with_depth_range(DepthRange { min: 0.1, max: 0.8 });
        assert_eq!((choice(&near).view, choice(&near).runner_up), (3, None));
        assert!((choice(&near).score - PI / 2.0).abs() < 1e-9);
        assert_eq!(
            choice(&near).explanation.unwrap().get("angle_deg"),
            Some(choice(&near).score.to_degrees())
        );
        let visited = near.with_visited(&[0, 2, 3]).unwrap();
        assert_eq!(EvenViews.plan(&visited).unwrap().choice, None);
    }

    #[test]
    fn frames_count_where_they_were_taken() {
        let views = generate::fibonacci_sphere(DVec3::ZERO, 0.4, 40).unwrap();
        let (snapshot, camera, cancel) = (box_around(IVec3::ZERO), Intrinsics::d435i(), Cancel::default());
        let image = DepthImage::from_metres(640, 480, vec![f32::NAN; camera.n_pixels()]).unwrap();
        let from = look_at(DVec3::Y * 0.4, DVec3::ZERO).unwrap();
        let frames = [Frame::new(image, camera, from, 1.0).unwrap()];
        let situation = Situation::new(&snapshot, &views, &camera, &cancel).with_frames(&frames);
        // The first view was visited, but is none of the frames.
        let situation = situation.with_visited(&[0]).unwrap();
        let chosen = EvenViews.plan(&situation).unwrap().choice.unwrap().view;
        assert!(views.pose(chosen).translation().y < -0.35, "{}", views.pose(chosen).translation());
    }
}
