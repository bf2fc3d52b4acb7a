//! Scans of parts whose CAD model is known, view by view.

use crate::common::{Step, scan, small_camera};
use fixedbitset::FixedBitSet;
use glam::{DQuat, DVec3};
use nextview::geometry::{Lattice, Pose};
use nextview::sensor::DepthRange;
use nextview::session::{Decision, Session, SessionConfig, StopReason};
use nextview::view::{ViewSpace, generate};
use nextview_sim::builtin;
use nextview_sim::inspection::{InspectionViews, PlacedPart, SurfaceDemand, SurfaceDemands};
use nextview_sim::mesh::TriangleMesh;
use nextview_sim::scene::Scene;
use nextview_sim::truth::ObjectVoxels;

const VOXEL_SIZE: f64 = 0.006;

/// A part that stands elsewhere than its model has it.
struct Setup {
    model: TriangleMesh,
    world_from_reference: Pose,
    scene: Scene,
    views: ViewSpace,
    demands: SurfaceDemands,
}

impl Setup {
    fn new(max_angle_deg: f64) -> Self {
        let model = builtin::by_name("bracket").unwrap();
        let turn = DQuat::from_rotation_z(2.0) * DQuat::from_rotation_x(0.4);
        let world_from_reference = Pose::new(turn, DVec3::new(0.05, -0.1, 0.3)).unwrap();
        let part = model.transformed(&world_from_reference).unwrap();
        let scene = Scene::new(part, small_camera()).unwrap();
        let views = generate::shell(scene.center(), scene.size(), 60, 1).unwrap();
        let max_angle = max_angle_deg.to_radians();
        let demand = SurfaceDemand { name: "all".to_owned(), bounds: None, max_angle, min_density: 0.0 };
        let demands = SurfaceDemands::new(&model, vec![demand]).unwrap();
        Self { model, world_from_reference, scene, views, demands }
    }

    fn session(&self, model: TriangleMesh, place: Option<Pose>, max_views: usize) -> Session {
        let demands = SurfaceDemands::new(&model, self.demands.demands().to_vec()).unwrap();
        let planner = InspectionViews::new(model, demands, place).unwrap();
        let bounds = self.scene.planning_box(VOXEL_SIZE);
        let config = SessionConfig { max_views, ..SessionConfig::new(VOXEL_SIZE, bounds) };
        Session::new(config, small_camera(), self.views.clone(), Box::new(planner)).unwrap()
    }

    fn scan(&self, place: Option<Pose>, max_views: usize) -> (Vec<Step>, StopReason) {
        let lattice = Lattice::new(VOXEL_SIZE).unwrap();
        let block = lattice.block_inside(&self.scene.planning_box(VOXEL_SIZE)).unwrap();
        let object = ObjectVoxels::new(self.scene.camera().mesh(), lattice, block);
        scan(&mut self.session(self.model.clone(), place, max_views), &self.scene, &object)
    }

    fn placed(&self) -> PlacedPart<'_> {
        let camera = (small_camera(), DepthRange { min: 0.0, max: 10.0 });
        PlacedPart::new(&self.model, &self.demands, &self.world_from_reference, camera).unwrap()
    }

    /// By candidate, the samples that it shows as demanded.
    fn shown(&self) -> Vec<FixedBitSet> {
        let part = self.placed();
        self.views.poses().iter().map(|pose| part.shown_from(pose).unwrap()).collect()
    }
}

fn union<'a>(sets: impl IntoIterator<Item = &'a FixedBitSet>) -> FixedBitSet {
    let mut all = FixedBitSet::new();
    sets.into_iter().for_each(|set| all.union_with(set));
    all
}

/// The slow twin: the view that shows most of the rest, again and again.
fn greedy(shown: &[FixedBitSet], first: usize) -> usize {
    let (mut covered, all, mut n) = (shown[first].clone(), union(shown), 1);
    while covered != all {
        let new = |set: &&FixedBitSet| set.difference_count(&covered);
        covered.union_with(shown.iter().max_by_key(new).unwrap());
        n += 1;
    }
    n
}

fn views(steps: &[Step]) -> Vec<usize> {
    steps.iter().map(|step| step.report.view.unwrap()).collect()
}

/// All that can be measured as demanded is, with about as few views as a greedy choice that knows where the
/// part stands.
#[test]
fn the_part_is_found_and_all_of_it_is_seen_as_demanded() {
    let setup = Setup::new(60.0);
    let shown = setup.shown();
    let n_greedy = greedy(&shown, 0);
    let (steps, reason) = setup.scan(None, 60);
    assert_eq!(reason, StopReason::NothingToGain);
    let part = setup.placed();
    let measured: Vec<FixedBitSet> = steps.iter().map(|step| part.shown_in(&step.frame).unwrap().1).collect();
    let (n, n_all) = (union(&measured).count_ones(..), union(&shown).count_ones(..));
    assert!(n as f64 > 0.985 * n_all as f64, "{n} of {n_all} samples");
    assert!(steps.len() <= n_greedy + 2, "{} views, greedy {n_greedy}", steps.len());
    let told = steps[2].report.choice.as_ref().and_then(|choice| choice.explanation.clone()).unwrap();
    let measurable = told.get("measurable_as_demanded_share").unwrap();
    let truly = n_all as f64 / setup.demands.samples().len() as f64;
    assert!((measurable - truly).abs() < 0.02, "{measurable} instead of {truly}");
}

/// With fewer views than are needed, they show more than as many of the views that all would need.
#[test]
fn few_views_show_as_much_as_they_can() {
    let setup = Setup::new(35.0);
    let shown = setup.shown();
    let (steps, reason) = setup.scan(Some(setup.world_from_reference), 5);
    assert_eq!((steps.len(), reason), (5, StopReason::ViewLimit));
    let of = |views: &[usize]| union(views.iter().map(|&view| &shown[view])).count_ones(..);
    let mut greedy = vec![0];
    while greedy.len() < 5 {
        let covered = union(greedy.iter().map(|&view| &shown[view]));
        greedy.push((0..shown.len()).max_by_key(|&view| shown[view].difference_count(&covered)).unwrap());
    }
    let (ours, theirs) = (of(&views(&steps)), of(&greedy));
    assert!(ours as f64 >= 0.98 * theirs as f64, "{ours} samples, greedy {theirs}");
}

#[test]
fn another_part_is_refused() {
    let setup = Setup::new(50.0);
    let mut session = setup.session(builtin::by_name("torus-knot").unwrap(), None, 20);
    let error = loop {
        match session.decide() {
            Ok(Decision::Move(next)) => {
                let frame = setup.scene.camera().capture(&next.world_from_camera).unwrap();
                session.observe(&frame).unwrap();
            }
            Ok(Decision::Stop(reason)) => panic!("it stopped: {reason:?}"),
            Err(error) => break error.to_string(),
        }
    };
    assert!(error.contains("the CAD model does not fit what 4 frames measured"), "{error}");
}
