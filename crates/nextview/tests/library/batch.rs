//! Batches of views against what single rays tell and against all choices of views.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::half_seen_ball::half_seen_ball;
use glam::{DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::gain::ExpectedSurface;
use nextview::geometry::{Lattice, VoxelBlock};
use nextview::map::{LogOdds, Snapshot};
use nextview::motion::{KeepOut, tour_length};
use nextview::planner::{Batch, BatchConfig, BatchPlan, Situation, ViewPlanner};
use nextview::prior::SurfacePrior;
use nextview::sensor::{DepthRange, Intrinsics};
use nextview::view::{ViewSpace, generate};
use nextview::visibility::MeasuredParts;

const N_VIEWS: usize = 14;
const VISITED: [usize; 2] = [3, 9];

fn views() -> ViewSpace {
    generate::shell(DVec3::ZERO, 0.08, N_VIEWS, 5).unwrap()
}

fn with_situation<T>(snapshot: &Snapshot, views: &ViewSpace, use_it: impl FnOnce(&Situation<'_>) -> T) -> T {
    let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
    let situation = Situation::new(snapshot, views, &camera, &cancel);
    use_it(&situation.with_visited(&VISITED).unwrap())
}

fn plan(config: BatchConfig) -> BatchPlan {
    let planner = Batch::new(config).unwrap();
    with_situation(&half_seen_ball(), &views(), |situation| planner.plan_batch(situation).unwrap())
}

/// For every view the value of each voxel: the probability that it shows new surface.
fn values(snapshot: &Snapshot, views: &ViewSpace) -> Vec<Vec<f64>> {
    let estimate = SurfacePrior::default().estimate(snapshot, &Cancel::default()).unwrap();
    let measured = MeasuredParts::new(&[], snapshot, &Cancel::default()).unwrap();
    let (camera, range) = (Intrinsics::d435i(), DepthRange::default());
    let gain = ExpectedSurface::new(snapshot, &camera, range, &measured, &estimate, 2.0).unwrap();
    let look = |view: usize| {
        let mut value = vec![0.0; estimate.len()];
        gain.evaluator().survey(&views.pose(view), |i, class| value[i] = estimate.shows(i, class) as f64);
        value
    };
    (0..views.len()).map(look).collect()
}

fn value_of(values: &[Vec<f64>], views: &[usize]) -> f64 {
    let best = |voxel: usize| views.iter().map(|&view| values[view][voxel]).fold(0.0, f64::max);
    (0..values[0].len()).map(best).sum()
}

fn path_length(views: &[usize]) -> f64 {
    let (space, snapshot) = (self::views(), half_seen_ball());
    let ball = KeepOut::around(&snapshot.lattice().bounds(&snapshot.block()), 0.0).unwrap();
    let position = |&view: &usize| space.pose(view).translation();
    tour_length(Some(position(&VISITED[1])), views.iter().map(position), &ball)
}

fn numbers(plan: &BatchPlan) -> Vec<usize> {
    plan.views.iter().map(|view| view.view).collect()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * b.abs()
}

#[test]
fn a_batch_is_the_best_of_all_choices_on_the_shortest_tour() {
    let (snapshot, space) = (half_seen_ball(), views());
    let values = values(&snapshot, &space);
    let open: Vec<usize> = (0..N_VIEWS).filter(|view| !VISITED.contains(view)).collect();
    let total = value_of(&values, &open);
    for n_views in 1..=4 {
        let plan = plan(BatchConfig { n_views, least_share: 0.0, ..BatchConfig::default() });
        let views = numbers(&plan);
        let choices = (0_u32..1 << open.len()).filter(|choice| choice.count_ones() as usize == n_views);
        let chosen = |choice: u32| (0..open.len()).filter(move |i| choice >> i & 1 == 1);
        let best = choices
            .map(|choice| value_of(&values, &chosen(choice).map(|i| open[i]).collect::<Vec<_>>()))
            .fold(0.0, f64::max);
        assert!(close(plan.share * total, best), "{n_views} views: {} of {best}", plan.share * total);
        assert!(close(plan.share, value_of(&values, &views) / total) && close(plan.share_bound, plan.share));
        assert!(close(plan.path_length, path_length(&views)));
        for (i, view) in plan.views.iter().enumerate() {
            let new = value_of(&values, &views[..=i]) - value_of(&values, &views[..i]);
            assert!((view.gain - new).abs() < 1e-5 * total && close(view.share, view.gain / total));
        }
        let mut reversed = views.clone();
        reversed.reverse();
        assert!(plan.path_length <= path_length(&reversed) + 1e-12);
    }
}

#[test]
fn views_that_add_little_are_left_out() {
    let all = plan(BatchConfig { n_views: N_VIEWS, least_share: 0.0, ..BatchConfig::default() });
    let some = plan(BatchConfig { n_views: N_VIEWS, least_share: 0.05, ..BatchConfig::default() });
    let one = plan(BatchConfig { n_views: N_VIEWS, least_share: 1.0, ..BatchConfig::default() });
    assert!(all.share > 1.0 - 1e-6 && all.views.len() <= N_VIEWS - VISITED.len());
    assert!(some.views.len() > 1 && some.views.len() < all.views.len() && some.share > 0.8);
    assert_eq!(one.views.len(), 1);
}

#[test]
fn a_weight_on_the_path_makes_it_shorter() {
    let of = |theta| plan(BatchConfig { n_views: 6, theta, ..BatchConfig::default() });
    let free = of(0.0);
    let score = |plan: &BatchPlan, theta: f64| {
        (1.0 - theta) * plan.share / free.share - theta * plan.path_length / free.path_length
    };
    let thetas = [0.1, 0.3, 0.5, 0.9, 1.0];
    let plans = thetas.map(of);
    for (plan, theta) in plans.iter().zip(thetas) {
        assert!(plan.share <= free.share + 1e-9 && plan.share_bound >= plan.share);
        assert!(score(plan, theta) >= score(&free, theta) - 1e-9, "theta {theta}");
    }
    assert!(plans[1].path_length < free.path_length && plans[1].share > 0.5 * free.share, "{plans:#?}");
    // Only the path counts: the nearest view of any value.
    let values = values(&half_seen_ball(), &views());
    let open: Vec<usize> = (0..N_VIEWS).filter(|view| !VISITED.contains(view)).collect();
    let least = 0.01 * value_of(&values, &open);
    let valuable = open.into_iter().filter(|&view| value_of(&values, &[view]) >= least);
    let nearest = valuable.min_by(|&a, &b| path_length(&[a]).total_cmp(&path_length(&[b]))).unwrap();
    assert_eq!(numbers(&plans[4]), [nearest]);
}

#[test]
fn a_plan_is_the_first_view_and_an_itinerary() {
    let (snapshot, space) = (half_seen_ball(), views());
    let mut planner =
        Batch::new(BatchConfig { n_views: 3, tolerance: 0.25, ..BatchConfig::default() }).unwrap();
    let plan = with_situation(&snapshot, &space, |situation| planner.plan(situation).unwrap());
    let itinerary = plan.itinerary.unwrap();
    assert_eq!((itinerary.legs.len(), itinerary.tolerance), (3, 0.25));
    assert_eq!(plan.choice.as_ref(), Some(&itinerary.legs[0].choice));
    assert!(itinerary.legs.iter().all(|leg| leg.expected > 0.0 && leg.choice.score > 0.0));
}

/// Each view after the first adds most to those before it, one after the other.
#[test]
fn the_views_after_one_are_those_that_add_most() {
    let (snapshot, space) = (half_seen_ball(), views());
    let values = values(&snapshot, &space);
    let position = |&view: &usize| space.pose(view).translation();
    let ball = KeepOut::around(&snapshot.lattice().bounds(&snapshot.block()), 0.0).unwrap();
    for (first, n_views) in [(VISITED[0], 4), (6, 4), (6, 1)] {
        let batch = Batch::new(BatchConfig { n_views, least_share: 0.0, ..BatchConfig::default() }).unwrap();
        let after =
            with_situation(&snapshot, &space, |situation| batch.plan_after(situation, first).unwrap());
        let mut expected = vec![first];
        for _ in 0..n_views {
            let open = (0..N_VIEWS).filter(|view| !VISITED.contains(view) && !expected.contains(view));
            let with = |view: &usize| value_of(&values, &[&expected[..], &[*view]].concat());
            let best = open.max_by(|a, b| with(a).total_cmp(&with(b))).unwrap();
            expected.push(best);
        }
        let tour: Vec<usize> = after.iter().map(|view| view.view).collect();
        let sorted = |mut views: Vec<usize>| {
            views.sort_unstable();
            views
        };
        assert_eq!(sorted(tour.clone()), sorted(expected[1..].to_vec()), "after {first}");
        let length = |tour: &[usize]| tour_length(Some(position(&first)), tour.iter().map(position), &ball);
        let mut reversed = tour.clone();
        reversed.reverse();
        assert!(length(&tour) <= length(&reversed) + 1e-12);
        let mut so_far = vec![first];
        for view in &after {
            let before = value_of(&values, &so_far);
            so_far.push(view.view);
            assert!((view.gain - (value_of(&values, &so_far) - before)).abs() < 1e-4 * before);
        }
    }
}

#[test]
fn nothing_to_see_is_no_batch() {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    let known = Snapshot::from_fn(Lattice::new(0.02).unwrap(), block, |_| Some(LogOdds(-1.0)));
    for theta in [0.0, 0.5] {
        let mut planner = Batch::new(BatchConfig { theta, ..BatchConfig::default() }).unwrap();
        let (batch, plan) = with_situation(&known, &views(), |situation| {
            (planner.plan_batch(situation).unwrap(), planner.plan(situation).unwrap())
        });
        assert_eq!((batch, plan.choice), (BatchPlan::default(), None));
    }
}

#[test]
fn threads_do_not_show() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| [0.0, 0.3].map(|theta| plan(BatchConfig { theta, ..BatchConfig::default() })))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn refuses_parameters_out_of_range() {
    let default = BatchConfig::default();
    for config in [
        BatchConfig { n_views: 0, ..default },
        BatchConfig { theta: 1.1, ..default },
        BatchConfig { least_share: f64::NAN, ..default },
        BatchConfig { tolerance: -0.1, ..default },
        BatchConfig { ray_spacing: 0.0, ..default },
    ] {
        assert!(Batch::new(config).is_err(), "{config:?}");
    }
}
