//! The planner against the gain of every single view, and what it expects against sums over all of them.

use crate::gain::check_view;
use crate::synthetic::{even_prior, half_seen_ball, nothing_measured, prior, random_snapshot, snapshot};
use glam::{DVec3, IVec3, UVec3};
use nextview::Cancel;
use nextview::gain::ExpectedSurface;
use nextview::geometry::{Aabb, VoxelBlock};
use nextview::map::{LogOdds, Occupancy, Snapshot};
use nextview::motion::{MotionConfig, Surroundings, Trajectory};
use nextview::planner::{
    Choice, MostSurface, MostSurfaceConfig, Outlook, Plan, RandomViews, Situation, ViewPlanner,
};
use nextview::prior::{SurfacePrior, coarse_enough};
use nextview::sensor::{DepthRange, Intrinsics};
use nextview::view::{ViewSpace, generate, look_at};
use proptest::prelude::*;

fn views(n: usize) -> ViewSpace {
    generate::shell(DVec3::ZERO, 0.08, n, 5).unwrap()
}

fn plan_with(
    planner: &mut dyn ViewPlanner,
    snapshot: &Snapshot,
    views: &ViewSpace,
    visited: &[usize],
) -> Plan {
    let (camera, cancel) = (Intrinsics::d435i(), Cancel::default());
    let situation = Situation::new(snapshot, views, &camera, &cancel);
    planner.plan(&situation.with_visited(visited).unwrap()).unwrap()
}

fn plan(
    config: MostSurfaceConfig,
    prior: &SurfacePrior,
    snapshot: &Snapshot,
    views: &ViewSpace,
    visited: &[usize],
) -> Plan {
    plan_with(&mut MostSurface::with_prior(config, prior.clone()).unwrap(), snapshot, views, visited)
}

/// The plan, with every view evaluated by itself. Distances are from the last view taken. Plans must be
/// equal, so what a view shows comes from the library, to the last bit. It is checked against the view's
/// rays, each cut with every voxel: for the chosen view, and for all of up to 25 views or every sixteenth of
/// more, since all would take minutes.
fn slow_plan(
    config: MostSurfaceConfig,
    prior: &SurfacePrior,
    snapshot: &Snapshot,
    views: &ViewSpace,
    visited: &[usize],
) -> Plan {
    let MostSurfaceConfig { rays_across, theta, per_second } = config;
    let cancel = &Cancel::default();
    let (snapshot, camera) = (coarse_enough(snapshot, cancel).unwrap(), Intrinsics::d435i());
    let ray_spacing = snapshot.block().dims().max_element() as f64 / rays_across;
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    let (estimate, measured) = (prior.estimate(&snapshot, cancel).unwrap(), nothing_measured(&snapshot));
    let gain = |view: usize, spacing: f64| {
        let range = DepthRange::default();
        let gain = ExpectedSurface::new(&snapshot, &camera, range, &measured, &estimate, spacing).unwrap();
        if views.len() <= 25 || view.is_multiple_of(16) {
            check_view(&snapshot, &camera, &estimate, spacing, &views.pose(view)).unwrap();
        }
        gain.evaluator().gain(&views.pose(view))
    };
    let open: Vec<usize> = (0..views.len()).filter(|view| !visited.contains(view)).collect();
    let place = |view: usize| views.pose(view).translation();
    let distance = |view: usize| visited.last().map_or(0.0, |&last| place(view).distance(place(last)));
    let path: f64 = open.iter().map(|&view| distance(view)).sum();
    let share = |part: f64, all: f64| if all > 0.0 { part / all } else { 0.0 };
    let values = |views: &[usize], gains: &[f64]| -> Vec<f64> {
        let largest = gains.iter().copied().fold(0.0, f64::max);
        let value = |(&view, gain): (&usize, &f64)| match visited {
            [first] => gain + largest * advantage_of_second(bounds, place(*first), place(view)),
            _ => *gain,
        };
        views.iter().zip(gains).map(value).collect()
    };
    let score = |view: usize, value: f64, total: f64| {
        if per_second {
            return share(value, total) / seconds_to(views, visited, view);
        }
        (1.0 - theta) * share(value, total) - theta * share(distance(view), path)
    };
    // Sorting is stable: of equals the lower number stays before the higher.
    let ranked = |views: &[usize], values: &[f64], total: f64| {
        let mut order: Vec<usize> = (0..views.len()).collect();
        let score = |&i: &usize| score(views[i], values[i], total);
        order.sort_by(|a, b| score(b).total_cmp(&score(a)));
        order
    };
    let mut looked_at = open.clone();
    let look = |views: &[usize], factor: f64| -> Vec<f64> {
        views.iter().map(|&view| gain(view, factor * ray_spacing)).collect()
    };
    let first_factor = match open.len() {
        0..=24 => 1.0,
        25..=150 => 2.0,
        151..=1000 => 4.0,
        _ => 8.0,
    };
    let mut gains = look(&looked_at, first_factor);
    let mut total: f64 = values(&looked_at, &gains).iter().sum();
    for (n_views, factor) in [(1000, 4.0), (150, 2.0), (24, 1.0)].into_iter().filter(|(n, _)| *n < open.len())
    {
        let before = values(&looked_at, &gains);
        let mut best = ranked(&looked_at, &before, total);
        best.truncate(n_views);
        best.sort_unstable();
        looked_at = best.iter().map(|&i| looked_at[i]).collect();
        gains = best.iter().map(|&i| gains[i]).collect();
        let before: f64 = values(&looked_at, &gains).iter().sum();
        gains = look(&looked_at, factor);
        if before > 0.0 {
            total *= values(&looked_at, &gains).iter().sum::<f64>() / before;
        }
    }
    let values = values(&looked_at, &gains);
    let order = ranked(&looked_at, &values, total);
    let order: Vec<usize> = order.into_iter().filter(|&i| gains[i] >= 0.5).collect();
    let choice = order.first().map(|&i| Choice {
        view: looked_at[i],
        score: score(looked_at[i], values[i], total),
        runner_up: order.get(1).map(|&i| looked_at[i]),
        explanation: Some([("local_share", share(values[i], total))].into()),
    });
    if let Some(choice) = &choice {
        check_view(&snapshot, &camera, &estimate, ray_spacing, &views.pose(choice.view)).unwrap();
    }
    let shown_by = |view: usize, spacing: f64| -> Vec<f32> {
        let mut shown = vec![0.0; estimate.len()];
        let range = DepthRange::default();
        let gain = ExpectedSurface::new(&snapshot, &camera, range, &measured, &estimate, spacing).unwrap();
        gain.evaluator().survey(&views.pose(view), |item, class| shown[item] = estimate.shows(item, class));
        shown
    };
    let all = open.iter().map(|&view| shown_by(view, first_factor * ray_spacing));
    let shown = all.fold(vec![0.0; estimate.len()], |all, view| best_of(&all, &view));
    let outlook = Outlook {
        n_seen: snapshot.count(Occupancy::Occupied),
        n_expected: order.first().map_or(Vec::new(), |&i| {
            let shown = |view: usize| shown_by(view, ray_spacing);
            n_expected(bounds.center(), views, &open, looked_at[i], shown)
        }),
        n_unseen: shown.iter().map(|&p| p as f64).sum(),
    };
    Plan { choice, outlook: Some(outlook), ..Plan::default() }
}

/// Seconds to go straight to a view that looks at the same point, at the default speed, and to measure there.
fn seconds_to(views: &ViewSpace, visited: &[usize], view: usize) -> f64 {
    let (empty, motion) = (Surroundings::default(), MotionConfig::default());
    let way = |&last: &usize| Trajectory::new(&views.pose(last), &views.pose(view), &empty, &motion).unwrap();
    visited.last().map_or(0.0, |last| way(last).duration()) + 2.0
}

/// The larger of both, number by number.
fn best_of(a: &[f32], b: &[f32]) -> Vec<f32> {
    a.iter().zip(b).map(|(a, b)| a.max(*b)).collect()
}

fn total(shown: &[f32]) -> f64 {
    shown.iter().map(|&p| p as f64).sum()
}

/// What is expected in all after each of five views, of 24 that lie all around, `chosen` first.
fn n_expected(
    center: DVec3,
    views: &ViewSpace,
    open: &[usize],
    chosen: usize,
    shown: impl Fn(usize) -> Vec<f32>,
) -> Vec<f64> {
    let toward = |view: usize| (views.pose(view).translation() - center).normalize();
    let mut around = vec![chosen];
    while around.len() < open.len().min(24) {
        let cosine =
            |view: usize| around.iter().map(|&taken| toward(view).dot(toward(taken))).fold(-1.0, f64::max);
        let left = open.iter().filter(|view| !around.contains(view));
        around.push(*left.min_by(|&&a, &&b| cosine(a).total_cmp(&cosine(b))).unwrap());
    }
    let mut seen = shown(chosen);
    let mut after = vec![total(&seen)];
    while after.len() < around.len().min(5) {
        let with = around.iter().map(|&view| best_of(&seen, &shown(view)));
        seen = with.max_by(|a, b| total(a).total_cmp(&total(b))).unwrap();
        after.push(total(&seen));
    }
    after
}

/// What speaks for the second view besides its gain, in shares of the largest gain.
fn advantage_of_second(bounds: Aabb, first: DVec3, second: DVec3) -> f64 {
    let (center, size) = (bounds.center(), bounds.size());
    let (first, second) = (first - center, second - center);
    let faces = DVec3::new(size.y * size.z, size.x * size.z, size.x * size.y);
    let outline = faces.dot(second.abs()) / (faces.length() * second.length());
    -0.24 * first.angle_between(second).cos()
        + 0.61 * outline
        + 0.14 * (second.length() / size.max_element()).min(2.5)
}

/// The plans agree; those of a second view as far as its advantage can be computed in another order.
fn assert_alike(found: &Plan, expected: &Plan, visited: &[usize]) {
    if visited.len() != 1 {
        return assert_eq!(found, expected);
    }
    let numbers = |plan: &Plan| {
        plan.choice.as_ref().map_or([0.0; 2], |choice| {
            let explanation = choice.explanation.as_ref().unwrap();
            [choice.score, explanation.get("local_share").unwrap()]
        })
    };
    let close = numbers(found).iter().zip(numbers(expected)).all(|(a, b)| (a - b).abs() < 1e-12);
    let views = |plan: &Plan| plan.choice.as_ref().map(|choice| (choice.view, choice.runner_up));
    assert!(close && views(found) == views(expected), "{found:?} instead of {expected:?}");
    assert_eq!(found.outlook, expected.outlook);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Up to 24 candidates are looked at once.
    #[test]
    fn takes_the_best_of_all_views(
        seed in 0..u64::MAX / 2, dims in prop::array::uniform3(2_u32..14), n_views in 1_usize..25,
        theta in prop::sample::select(vec![0.0, 0.3, 1.0]), rays_across in 1.0..30.0,
    ) {
        let dims = UVec3::from_array(dims);
        let snapshot = random_snapshot(-(dims / 2).as_ivec3(), dims, seed);
        let per_second = seed % 2 == 1;
        let theta = if per_second { 0.0 } else { theta };
        let config = MostSurfaceConfig { rays_across, theta, per_second };
        let (prior, views) = (prior(seed), views(n_views));
        for visited in [&[][..], &[0]] {
            let found = plan(config, &prior, &snapshot, &views, visited);
            assert_alike(&found, &slow_plan(config, &prior, &snapshot, &views, visited), visited);
        }
    }

    /// Of more views than 24, the best 24 of the pass before are looked at with all rays; of more than 150,
    /// the best 150; of more than 1000, the best 1000 of the first pass.
    #[test]
    fn takes_the_best_of_the_shortlist(
        seed in 0..u64::MAX / 2, n_views in prop::sample::select(vec![60, 200, 1100]),
        theta in prop::sample::select(vec![0.0, 0.3, 1.0]),
    ) {
        let config = MostSurfaceConfig { theta, ..MostSurfaceConfig::default() };
        let (prior, snapshot, views) = (prior(seed), half_seen_ball(), views(n_views));
        for visited in [&[3, 17][..], &[17]] {
            let found = plan(config, &prior, &snapshot, &views, visited);
            assert_alike(&found, &slow_plan(config, &prior, &snapshot, &views, visited), visited);
        }
    }
}

#[test]
fn of_equal_views_the_first_is_taken() {
    let poses = views(10).poses().to_vec();
    let twice = ViewSpace::new([&poses[..], &poses[..]].concat()).unwrap();
    let config = MostSurfaceConfig::default();
    let choice = plan(config, &prior(2), &half_seen_ball(), &twice, &[]).choice.unwrap();
    assert!(choice.view < 10);
    assert_eq!(choice.runner_up, Some(choice.view + 10));
}

#[test]
fn what_was_visited_is_not_chosen_again() {
    let (config, views, mut visited) = (MostSurfaceConfig::default(), views(12), Vec::new());
    while let Some(choice) = plan(config, &prior(3), &half_seen_ball(), &views, &visited).choice {
        assert!(!visited.contains(&choice.view));
        visited.push(choice.view);
    }
    assert_eq!(visited.len(), 12, "the map does not change, so every view goes on showing something");
    let outlook = plan(config, &prior(3), &half_seen_ball(), &views, &visited).outlook.unwrap();
    assert_eq!((outlook.n_expected_next(), outlook.n_unseen), (0.0, 0.0));
}

#[test]
fn where_only_the_way_counts_the_nearest_is_taken() {
    let (views, config) = (views(90), MostSurfaceConfig { theta: 1.0, ..MostSurfaceConfig::default() });
    let choice = plan(config, &prior(4), &half_seen_ball(), &views, &[7]).choice.unwrap();
    let distance = |view: &usize| views.pose(*view).translation().distance(views.pose(7).translation());
    let nearest = (0..90).filter(|&view| view != 7).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    assert_eq!(Some(choice.view), nearest);
}

/// Of views in a row of which the nearest see nothing.
#[test]
fn of_views_of_no_use_two_dozen_are_tried() {
    let chosen = |n_blind: usize| {
        let place = |i: usize| DVec3::X * (0.4 + 0.01 * i as f64);
        let target = |i: usize| if i <= n_blind { DVec3::X } else { DVec3::ZERO };
        let views = ViewSpace::new((0..50).map(|i| look_at(place(i), target(i)).unwrap()).collect()).unwrap();
        let config = MostSurfaceConfig { theta: 1.0, ..MostSurfaceConfig::default() };
        plan(config, &even_prior(0.1, 0.5), &half_seen_ball(), &views, &[0]).choice.map(|choice| choice.view)
    };
    assert_eq!(chosen(0), Some(1));
    assert_eq!(chosen(23), Some(24));
    assert_eq!(chosen(24), None);
}

#[test]
fn half_a_voxel_is_the_least_gain_of_a_view() {
    let block = VoxelBlock::new(IVec3::splat(-2), UVec3::splat(4)).unwrap();
    let one_unknown = snapshot(block, |key| (key != IVec3::ZERO).then_some(0.85));
    let views =
        ViewSpace::new(vec![look_at(DVec3::new(0.3, 0.2, 0.1), DVec3::splat(0.005)).unwrap()]).unwrap();
    for (shows, is_chosen) in [(0.4, false), (0.6, true)] {
        let plan = plan(MostSurfaceConfig::default(), &even_prior(0.5, shows), &one_unknown, &views, &[]);
        let outlook = plan.outlook.unwrap();
        assert_eq!((plan.choice.is_some(), outlook.n_seen), (is_chosen, 63));
        assert!((outlook.n_unseen - shows as f64).abs() < 1e-6);
        let expected = if is_chosen { shows as f64 } else { 0.0 };
        assert!((outlook.n_expected_next() - expected).abs() < 1e-6);
    }
}

#[test]
fn where_nothing_is_to_be_seen_there_is_no_choice() {
    let block = VoxelBlock::new(IVec3::splat(-4), UVec3::splat(8)).unwrap();
    for (log_odds, n_seen) in [(-0.4, 0), (0.85, 512)] {
        let known = snapshot(block, |_| Some(log_odds));
        let plan = plan(MostSurfaceConfig::default(), &prior(5), &known, &views(50), &[]);
        let outlook = Outlook { n_seen, n_expected: Vec::new(), n_unseen: 0.0 };
        assert_eq!(outlook.completeness(), 1.0);
        assert_eq!(plan, Plan { outlook: Some(outlook), ..Plan::default() });
    }
}

#[test]
fn threads_do_not_show() {
    let config = MostSurfaceConfig { theta: 0.2, ..MostSurfaceConfig::default() };
    let run = |n_threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| plan(config, &prior(6), &half_seen_ball(), &views(90), &[4]))
    };
    let one = run(1);
    assert!(one.choice.is_some());
    assert_eq!(one, run(2));
    assert_eq!(one, run(4));
}

/// The size of what is planned in, and all distances between rays, are those of the coarse voxels.
#[test]
fn fine_maps_are_planned_in_coarse_voxels() {
    let block = VoxelBlock::new(IVec3::new(-38, -4, -3), UVec3::new(77, 7, 8)).unwrap();
    let fine = snapshot(block, |key| (key.y < 2).then_some(if key.y < 1 { -0.4 } else { 0.85 }));
    let coarse = coarse_enough(&fine, &Cancel::default()).unwrap();
    assert!(coarse.block().n_voxels() < block.n_voxels());
    let (views, config) = (generate::shell(DVec3::ZERO, 0.4, 60, 5).unwrap(), MostSurfaceConfig::default());
    let of_coarse = plan(config, &prior(7), &coarse, &views, &[1]);
    assert!(of_coarse.choice.is_some());
    assert_eq!(plan(config, &prior(7), &fine, &views, &[1]), of_coarse);
}

#[test]
fn the_library_has_a_prior_of_its_own() {
    let (config, snapshot, views) = (MostSurfaceConfig::default(), half_seen_ball(), views(30));
    let own = plan_with(&mut MostSurface::new(config).unwrap(), &snapshot, &views, &[]);
    assert_eq!(own, slow_plan(config, &SurfacePrior::default(), &snapshot, &views, &[]));
    assert_eq!(plan_with(&mut RandomViews { seed: 1 }, &snapshot, &views, &[]).outlook, None);
}

#[test]
fn bad_parameters_are_refused() {
    let fault = |rays_across, theta| {
        let config = MostSurfaceConfig { rays_across, theta, ..MostSurfaceConfig::default() };
        MostSurface::new(config).map(|_| ()).map_err(|e| e.to_string())
    };
    for bad in [-0.1, 1.1, f64::NAN] {
        assert_eq!(fault(9.0, bad), Err(format!("theta is {bad}, expected a number in 0..=1")));
    }
    for bad in [0.0, 0.99, 1001.0, f64::NAN, f64::INFINITY] {
        assert_eq!(fault(bad, 0.0), Err(format!("rays_across is {bad}, expected a number in 1..=1000")));
    }
    let both = MostSurfaceConfig { theta: 0.3, per_second: true, ..MostSurfaceConfig::default() };
    let fault_of_both = MostSurface::new(both).map(|_| ()).map_err(|e| e.to_string());
    assert_eq!(
        fault_of_both.unwrap_err(),
        "theta is 0.3, expected 0 with per_second, which counts all the time"
    );
    for (rays_across, theta) in [(1.0, 0.0), (1000.0, 1.0)] {
        assert_eq!(fault(rays_across, theta), Ok(()));
    }
}

#[test]
fn a_view_in_vain_is_not_repeated_next_to_it() {
    let (snapshot, views) = (half_seen_ball(), views(300));
    let planner = || MostSurface::with_prior(MostSurfaceConfig::default(), even_prior(0.3, 0.1)).unwrap();
    let mut doubting = planner();
    let first = plan_with(&mut doubting, &snapshot, &views, &[0]).choice.unwrap().view;
    let fresh = plan_with(&mut planner(), &snapshot, &views, &[0, first]);
    // The view was taken, and the map is as before.
    let after = plan_with(&mut doubting.clone(), &snapshot, &views, &[0, first]);
    let distance = |plan: &Plan| {
        let [a, b] = [first, plan.choice.as_ref().unwrap().view].map(|view| views.pose(view).translation());
        a.distance(b)
    };
    assert!(distance(&after) >= distance(&fresh), "{} {}", distance(&after), distance(&fresh));
    let unseen = |plan: &Plan| plan.outlook.as_ref().unwrap().n_unseen;
    assert!(unseen(&after) < 0.9 * unseen(&fresh), "{} {}", unseen(&after), unseen(&fresh));
    // A view of somebody else's choice teaches nothing, and neither does one that showed enough.
    let other = plan_with(&mut doubting.clone(), &snapshot, &views, &[0, 1]);
    assert_eq!(other, plan_with(&mut planner(), &snapshot, &views, &[0, 1]));
    let whole = Snapshot::from_fn(snapshot.lattice(), snapshot.block(), |key| {
        let radius = snapshot.lattice().center(key).length();
        (0.04..0.052).contains(&radius).then_some(LogOdds(0.85))
    });
    let shown = plan_with(&mut doubting, &whole, &views, &[0, first]);
    assert_eq!(shown, plan_with(&mut planner(), &whole, &views, &[0, first]));
}

/// The less a view shows of what was expected, the less is expected of the same voxels.
#[test]
fn expectations_fall_with_the_share_that_was_shown() {
    let (before, views) = (half_seen_ball(), views(300));
    let planner = || MostSurface::with_prior(MostSurfaceConfig::default(), even_prior(0.3, 0.1)).unwrap();
    let mut taught = planner();
    let plan = plan_with(&mut taught, &before, &views, &[0]);
    let (first, expected) = (plan.choice.unwrap().view, plan.outlook.unwrap().n_expected_next());
    let is_unknown = |index: &usize| before.occupancy()[*index] == Occupancy::Unknown;
    let unknown: Vec<usize> = (0..before.block().n_voxels()).filter(is_unknown).collect();
    // What the taught planner expects in all, as a share of what a fresh one does.
    let expectation = |shown: f64| {
        let new = &unknown[..(shown * expected).round() as usize];
        let after = Snapshot::from_fn(before.lattice(), before.block(), |key| {
            let index = before.block().index(key).unwrap();
            match before.occupancy()[index] {
                Occupancy::Occupied => Some(LogOdds(0.85)),
                Occupancy::Free => Some(LogOdds(-0.4)),
                Occupancy::Unknown => new.binary_search(&index).is_ok().then_some(LogOdds(0.85)),
            }
        });
        let unseen = |planner: &mut MostSurface| {
            plan_with(planner, &after, &views, &[0, first]).outlook.unwrap().n_unseen
        };
        unseen(&mut taught.clone()) / unseen(&mut planner())
    };
    let shares = [0.0, 0.2, 0.35, 0.6].map(expectation);
    assert!(shares.is_sorted() && shares[0] < 0.9 && shares[1] < shares[2], "{shares:?}");
    assert!(shares[2] < 1.0 && shares[3] == 1.0, "{shares:?}");
}
