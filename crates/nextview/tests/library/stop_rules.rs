//! When a session ends: by what its planner expects and by how far the camera goes; and what its reports say
//! of both.

#![allow(clippy::unwrap_used, reason = "clippy allows it in test functions, not in their helpers")]

use glam::DVec3;
use nextview::Error;
use nextview::geometry::Aabb;
use nextview::planner::{
    Choice, EvenViews, InOrder, Itinerary, Leg, MinOverlap, Outlook, Plan, RandomViews, Situation,
    ViewPlanner,
};
use nextview::sensor::{DepthImage, DepthNoise, Frame, Intrinsics, SurfaceNoise};
use nextview::session::{
    Decision, MultiResolutionConfig, NextView, Session, SessionConfig, StepReport, StopConfig, StopReason,
};
use nextview::view::{ViewSpace, generate, look_at};

/// Distance between neighbouring views, metres; sums of it have no rounding.
const STEP: f64 = 0.125;

/// Goes from view to view and expects after each what it is told to; without more to tell, it expects and
/// chooses nothing.
struct Told(Vec<Outlook>);

impl ViewPlanner for Told {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let view = situation.visited().len();
        let outlook = self.0.get(view - 1).cloned();
        Ok(Plan { choice: outlook.as_ref().map(|_| choice(view)), outlook, ..Plan::default() })
    }
}

fn choice(view: usize) -> Choice {
    Choice::new(view, 1.0)
}

fn outlook(n_expected: f64, n_unseen: f64) -> Outlook {
    Outlook { n_seen: 100, n_expected: vec![n_expected], n_unseen }
}

/// The wall soon leaves the box, so that later frames show nothing new.
const NO_PROGRESS_RULE: StopConfig = StopConfig {
    entropy_share: None,
    completeness: None,
    expected_gain: None,
    progress: 0.0,
    path_length: None,
};

/// Views in a row that look across the box.
fn views() -> ViewSpace {
    let position = |i: usize| DVec3::new(i as f64 * STEP, -1.0, 0.0);
    ViewSpace::new((0..12).map(|i| look_at(position(i), DVec3::X * position(i).x).unwrap()).collect())
        .unwrap()
}

fn config(stop: StopConfig) -> SessionConfig {
    SessionConfig { stop, ..SessionConfig::new(0.01, Aabb::cube(DVec3::ZERO, 0.05)) }
}

fn camera() -> Intrinsics {
    Intrinsics::pinhole(32, 24, glam::DVec2::splat(60.0), glam::DVec2::new(15.5, 11.5)).unwrap()
}

fn session(planner: impl ViewPlanner + 'static, stop: StopConfig) -> Session {
    Session::new(config(stop), camera(), views(), Box::new(planner)).unwrap()
}

/// A frame that shows a wall across the box, farther from each view than from the last.
fn observe(session: &mut Session, view: usize) -> StepReport {
    let image = DepthImage::from_metres(32, 24, vec![1.0 + 0.01 * view as f32; 32 * 24]).unwrap();
    session.observe(&Frame::new(image, camera(), views().pose(view), 2.0).unwrap()).unwrap()
}

fn scan(session: &mut Session) -> (Vec<(NextView, StepReport)>, StopReason) {
    let mut steps = Vec::new();
    loop {
        match session.decide().unwrap() {
            Decision::Move(next) => {
                let report = observe(session, next.view.unwrap());
                steps.push((next, report));
            }
            Decision::Stop(reason) => return (steps, reason),
        }
    }
}

/// How many views are taken, and why no more.
fn check(planner: impl ViewPlanner + 'static, stop: StopConfig, n_views: usize, reason: StopReason) {
    let mut session = session(planner, stop);
    assert_eq!(scan(&mut session).1, reason, "{stop:?}");
    assert_eq!(session.visited(), (0..n_views).collect::<Vec<_>>(), "{stop:?}");
    assert_eq!(session.decide().unwrap(), Decision::Stop(reason), "the answer stays the same");
}

#[test]
fn stops_when_enough_is_estimated_to_have_been_seen() {
    // Completeness 0.5, 0.8, 0.9, 1.
    let told = || Told([100.0, 25.0, 100.0 / 9.0, 0.0].map(|n_unseen| outlook(1.0, n_unseen)).to_vec());
    let stop = |share| StopConfig { completeness: Some(share), ..StopConfig::default() };
    for (share, n_views) in [(0.0, 1), (0.5, 1), (0.51, 2), (0.8, 2), (0.85, 3), (0.95, 4), (1.0, 4)] {
        check(told(), stop(share), n_views, StopReason::Complete);
    }
    check(told(), StopConfig::default(), 5, StopReason::NothingToGain);
}

#[test]
fn stops_when_six_views_show_nothing_new() {
    let scan_wall = |progress: f64, distance: fn(usize) -> f32| {
        let mut session = session(InOrder, StopConfig { progress, ..StopConfig::default() });
        loop {
            match session.decide().unwrap() {
                Decision::Stop(reason) => return (session.visited().len(), reason),
                Decision::Move(next) => {
                    let distance = distance(next.view.unwrap());
                    let image = DepthImage::from_metres(32, 24, vec![distance; 32 * 24]).unwrap();
                    let frame = Frame::new(image, camera(), next.world_from_camera, 2.0).unwrap();
                    session.observe(&frame).unwrap();
                }
            }
        }
    };
    assert_eq!(scan_wall(0.01, |_| 1.0), (7, StopReason::NoProgress));
    assert_eq!(scan_wall(0.0, |_| 1.0), (10, StopReason::ViewLimit), "off");
    // Another wall in the third view.
    assert_eq!(scan_wall(0.01, |view| if view < 2 { 1.0 } else { 1.03 }), (9, StopReason::NoProgress));
    assert_eq!(scan_wall(0.01, |_| 5.0), (10, StopReason::ViewLimit), "nothing seen at all");
}

/// The same distance in all pixels, metres; 0 for none.
fn image(distance: f32) -> DepthImage {
    DepthImage::from_metres(32, 24, vec![distance; 32 * 24]).unwrap()
}

/// Of a spiral of 40 views from pole to pole, the one opposite the first.
const OPPOSITE: usize = 38;

#[test]
fn an_image_without_depths_does_not_end_a_scan() {
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.5, 40).unwrap();
    let planner = Box::new(Told(Vec::new()));
    let mut session = Session::new(config(StopConfig::default()), camera(), views, planner).unwrap();
    let mut asked = Vec::new();
    for distance in [0.0, 0.0, 0.49] {
        let Decision::Move(next) = session.decide().unwrap() else { panic!("stopped after {asked:?}") };
        asked.push(next.view.unwrap());
        session
            .observe(&Frame::new(image(distance), camera(), next.world_from_camera, 2.0).unwrap())
            .unwrap();
    }
    assert_eq!(asked[..2], [0, OPPOSITE]);
    assert_eq!(session.decide().unwrap(), Decision::Stop(StopReason::NothingToGain));
}

#[test]
fn even_views_go_on_where_nothing_new_is_seen() {
    // A ball that fills the box looks the same from everywhere, and from the third view on nothing is new.
    let views = generate::fibonacci_sphere(DVec3::ZERO, 0.5, 40).unwrap();
    let scan = |planner: Box<dyn ViewPlanner>| {
        let mut session =
            Session::new(config(StopConfig::default()), camera(), views.clone(), planner).unwrap();
        while let Decision::Move(next) = session.decide().unwrap() {
            let image = DepthImage::from_metres(32, 24, vec![0.49; 32 * 24]).unwrap();
            session.observe(&Frame::new(image, camera(), next.world_from_camera, 2.0).unwrap()).unwrap();
        }
        (session.visited().len(), session.decide().unwrap())
    };
    let all = (10, Decision::Stop(StopReason::ViewLimit));
    assert_eq!(scan(Box::new(EvenViews)), all);
    assert_eq!(scan(Box::new(MinOverlap::new(0.1, Box::new(EvenViews)).unwrap())), all);
    assert!(RandomViews { seed: 0 }.seeks_surface() && !EvenViews.seeks_surface());
}

#[test]
fn without_a_next_view_a_scan_may_be_complete_or_not() {
    struct Done;
    impl ViewPlanner for Done {
        fn plan(&mut self, _: &Situation<'_>) -> Result<Plan, Error> {
            Ok(Plan { outlook: Some(outlook(0.0, 25.0)), ..Plan::default() })
        }
    }
    let stop = |share| StopConfig {
        completeness: Some(share),
        expected_gain: Some(1.0),
        path_length: Some(1e-9),
        ..StopConfig::default()
    };
    check(Done, stop(0.8), 1, StopReason::Complete);
    check(Done, stop(0.81), 1, StopReason::NothingToGain);
}

#[test]
fn stops_when_the_next_view_is_expected_to_add_little() {
    let told = || Told([50.0, 10.0, 20.0, 5.0].map(|n_expected| outlook(n_expected, 100.0)).to_vec());
    let stop = |share| StopConfig { expected_gain: Some(share), ..StopConfig::default() };
    for (share, n_views) in [(1.0, 1), (0.51, 1), (0.5, 2), (0.11, 2), (0.1, 4), (0.051, 4)] {
        check(told(), stop(share), n_views, StopReason::LittleToGain);
    }
    check(told(), stop(0.05), 5, StopReason::NothingToGain);
    check(told(), stop(0.0), 5, StopReason::NothingToGain);
    let told = || Told([5.0, 0.11, 0.09, 5.0].map(|n_expected| outlook(n_expected, 100.0)).to_vec());
    check(told(), StopConfig::default(), 3, StopReason::LittleToGain);
    check(told(), StopConfig { progress: 0.0, ..StopConfig::default() }, 5, StopReason::NothingToGain);
}

#[test]
fn a_goal_for_the_error_keeps_a_scan_going_only_while_surface_misses_it() {
    let depth = DepthNoise { constant: 0.001, ..DepthNoise::default() };
    let scan = |goal| {
        let surface_error = SurfaceNoise { depth, ..SurfaceNoise::default() };
        let config = SessionConfig { goal: Some(goal), surface_error, ..config(NO_PROGRESS_RULE) };
        let stop = StopConfig { progress: 0.01, ..NO_PROGRESS_RULE };
        let told = Told(vec![outlook(0.01, 100.0); 4]);
        let mut session =
            Session::new(SessionConfig { stop, ..config }, camera(), views(), Box::new(told)).unwrap();
        let (steps, reason) = scan(&mut session);
        (steps.last().unwrap().1.share_at_goal.unwrap(), steps.len(), reason)
    };
    assert_eq!(scan(0.002), (1.0, 1, StopReason::LittleToGain));
    let (share, n_views, reason) = scan(0.0006);
    assert!(
        share < 0.99 && (n_views, reason) == (5, StopReason::NothingToGain),
        "{share} {n_views} {reason:?}"
    );
}

#[test]
fn anything_is_much_where_nothing_was_seen() {
    let nothing_seen = Outlook { n_seen: 0, n_expected: vec![0.6], n_unseen: 1.0 };
    let stop = StopConfig { expected_gain: Some(1.0), ..StopConfig::default() };
    check(Told(vec![nothing_seen; 3]), stop, 4, StopReason::NothingToGain);
}

#[test]
fn stops_before_the_path_is_too_long() {
    let told = || Told(vec![outlook(50.0, 100.0); 11]);
    let stop = |steps: f64| StopConfig { path_length: Some(steps * STEP), ..NO_PROGRESS_RULE };
    for (steps, n_views) in [(0.001, 1), (0.999, 1), (1.0, 2), (3.5, 4), (4.0, 5)] {
        check(told(), stop(steps), n_views, StopReason::PathLimit);
    }
    check(told(), stop(9.0), 10, StopReason::ViewLimit);
    check(told(), stop(f64::INFINITY), 10, StopReason::ViewLimit);
}

#[test]
fn of_several_rules_the_first_to_hold_ends_the_scan() {
    let told = || Told((0..11).map(|i| outlook(50.0 - 5.0 * i as f64, 100.0 - 9.0 * i as f64)).collect());
    let all = StopConfig {
        completeness: Some(0.7),
        expected_gain: Some(0.2),
        path_length: Some(2.0 * STEP),
        ..NO_PROGRESS_RULE
    };
    check(told(), all, 3, StopReason::PathLimit);
    check(told(), StopConfig { path_length: None, ..all }, 8, StopReason::Complete);
    check(told(), StopConfig { path_length: None, completeness: None, ..all }, 8, StopReason::LittleToGain);
}

#[test]
fn planners_that_expect_nothing_never_stop_for_that() {
    let stop = StopConfig { completeness: Some(0.0), expected_gain: Some(1.0), ..NO_PROGRESS_RULE };
    let mut session = session(RandomViews { seed: 3 }, stop);
    let (steps, reason) = scan(&mut session);
    assert_eq!((steps.len(), reason), (10, StopReason::ViewLimit));
    assert!(steps.iter().all(|(next, report)| next.outlook.is_none() && report.outlook.is_none()));
}

#[test]
fn coarse_voxels_do_not_end_a_scan_for_what_they_show() {
    let stop = StopConfig { completeness: Some(0.0), expected_gain: Some(1.0), ..StopConfig::default() };
    let rule = MultiResolutionConfig { enabled: true, coarsest_voxel_size: Some(0.02), q_thresh: 1e-9 };
    let config = SessionConfig { multi_resolution: rule, ..config(stop) };
    let told = Told(vec![outlook(1.0, 0.0); 2]);
    let mut session = Session::new(config, camera(), views(), Box::new(told)).unwrap();
    let (steps, reason) = scan(&mut session);
    assert!(steps.iter().all(|(_, report)| report.voxel_size > 0.01));
    // Without a choice in coarse voxels the session goes over to the finest, of which this planner says
    // nothing.
    assert_eq!((steps.len(), reason), (3, StopReason::NothingToGain));
}

/// Goes to a far view first and, after another frame, to a nearer one.
struct Nearer;

impl ViewPlanner for Nearer {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let view = if situation.frames().len() < 2 { 3 } else { 2 };
        Ok(Plan { choice: Some(choice(view)), ..Plan::default() })
    }
}

#[test]
fn another_frame_may_let_a_scan_go_on() {
    for (steps, goes_on) in [(2.0, true), (1.0, false)] {
        let stop = StopConfig { path_length: Some(steps * STEP), ..StopConfig::default() };
        let mut session = session(Nearer, stop);
        assert!(matches!(session.decide().unwrap(), Decision::Move(NextView { view: Some(0), .. })));
        observe(&mut session, 0);
        assert_eq!(session.decide().unwrap(), Decision::Stop(StopReason::PathLimit));
        observe(&mut session, 1);
        assert_eq!(session.visited(), [0], "the frame after a stop was not asked for");
        assert_eq!(matches!(session.decide().unwrap(), Decision::Move(_)), goes_on);
    }
}

/// Plans anew each time it is asked: to a far view first, then to near ones.
struct Fickle {
    n_plans: usize,
}

impl ViewPlanner for Fickle {
    fn plan(&mut self, _: &Situation<'_>) -> Result<Plan, Error> {
        self.n_plans += 1;
        let view = if self.n_plans == 1 { 9 } else { 1 };
        Ok(Plan { choice: Some(choice(view)), ..Plan::default() })
    }
}

/// Chooses a near and a far view at once, and near ones afterwards.
struct Tour;

impl ViewPlanner for Tour {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let views = if situation.visited().len() == 1 { vec![1, 9] } else { vec![2, 3] };
        let leg = |view: &usize| Leg { choice: choice(*view), expected: 1.0 };
        let itinerary = Itinerary { legs: views.iter().map(leg).collect(), tolerance: f64::INFINITY };
        Ok(Plan { choice: Some(choice(views[0])), itinerary: Some(itinerary), ..Plan::default() })
    }
}

#[test]
fn asked_again_a_stop_stays_a_stop() {
    let stop = StopConfig { path_length: Some(4.0 * STEP), ..StopConfig::default() };
    let planners: [fn() -> Box<dyn ViewPlanner>; 2] = [|| Box::new(Fickle { n_plans: 0 }), || Box::new(Tour)];
    for planner in planners {
        let mut session = Session::new(config(stop), camera(), views(), planner()).unwrap();
        let reason = scan(&mut session).1;
        assert_eq!(reason, StopReason::PathLimit);
        for _ in 0..3 {
            assert_eq!(session.decide().unwrap(), Decision::Stop(reason));
        }
    }
}

#[test]
fn reports_tell_what_was_expected_and_how_far_the_camera_went() {
    let told = vec![outlook(50.0, 100.0), outlook(30.0, 60.0)];
    let mut session = session(Told(told.clone()), StopConfig::default());
    let (steps, _) = scan(&mut session);
    let expected = [None, Some(told[0].clone()), Some(told[1].clone())];
    assert_eq!(steps.iter().map(|(_, report)| report.outlook.clone()).collect::<Vec<_>>(), expected);
    assert_eq!(steps.iter().map(|(next, _)| next.outlook.clone()).collect::<Vec<_>>(), expected);
    assert_eq!(steps.iter().map(|(_, report)| report.travel).collect::<Vec<_>>(), [0.0, STEP, STEP]);
    // A frame that was not asked for is expected by nobody, but the camera went there.
    let report = observe(&mut session, 6);
    assert_eq!((report.outlook, report.travel), (None, 4.0 * STEP));
}

/// Takes the open view that costs least to go to.
struct Cheapest;

impl ViewPlanner for Cheapest {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        let travel = |view: &usize| situation.travel(*view).unwrap_or_default();
        let open = situation.open_views().into_iter();
        let cheapest = open.min_by(|a, b| travel(a).total_cmp(&travel(b)));
        Ok(Plan { choice: cheapest.map(choice), ..Plan::default() })
    }
}

#[test]
fn goes_only_where_the_robot_can_go_now() {
    let stop = NO_PROGRESS_RULE;
    let mut session = session(Cheapest, stop);
    let next = |session: &mut Session| session.decide().unwrap();
    let only = |open: &[(usize, f64)]| {
        let mut times = vec![None; 12];
        open.iter().for_each(|&(view, time)| times[view] = Some(time));
        times
    };
    session.set_approaches(only(&[(3, 9.0), (5, 1.0)]));
    let Decision::Move(first) = next(&mut session) else { panic!("goes on") };
    assert_eq!(first.view, Some(3), "the first view is the next one where it can go");
    observe(&mut session, 3);

    assert!(matches!(next(&mut session), Decision::Move(NextView { view: Some(2), .. })), "by distance");
    session.set_approaches(only(&[(2, 9.0), (5, 1.0), (3, 0.1)]));
    assert!(matches!(next(&mut session), Decision::Move(NextView { view: Some(5), .. })), "by time");
    session.set_approaches(only(&[(3, 0.1)]));
    assert!(matches!(next(&mut session), Decision::Stop(StopReason::OutOfReach)), "where it is already");
    session.set_approaches(only(&[(2, 9.0)]));
    assert!(matches!(next(&mut session), Decision::Move(NextView { view: Some(2), .. })));
    observe(&mut session, 2);
    assert!(matches!(next(&mut session), Decision::Move(NextView { view: Some(1), .. })), "forgotten");
}

/// Goes along an itinerary of all views; the score is the number of the plan.
#[derive(Default)]
struct Along {
    n_plans: usize,
}

impl ViewPlanner for Along {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        self.n_plans += 1;
        let choice = |view| Choice::new(view, self.n_plans as f64);
        let open = situation.open_views();
        let legs = open.iter().map(|&view| Leg { choice: choice(view), expected: 1.0 }).collect();
        let itinerary = Some(Itinerary { legs, tolerance: f64::INFINITY });
        Ok(Plan { choice: open.first().map(|&view| choice(view)), itinerary, ..Plan::default() })
    }
}

#[test]
fn an_itinerary_is_kept_where_the_robot_says_again_where_it_can_go() {
    let mut session = session(Along::default(), NO_PROGRESS_RULE);
    session.decide().unwrap();
    observe(&mut session, 0);
    for _ in 0..3 {
        let Decision::Move(NextView { choice: Some(choice), .. }) = session.decide().unwrap() else {
            panic!("goes on")
        };
        assert_eq!((choice.view, choice.score), (1, 1.0));
        session.set_approaches(vec![Some(1.0); 12]);
    }
}

#[test]
fn bad_values_are_refused() {
    let fault = |stop: StopConfig| {
        let session = Session::new(config(stop), camera(), views(), Box::new(RandomViews { seed: 1 }));
        assert_eq!(session.is_ok(), stop.check().is_ok());
        stop.check().map_err(|error| error.to_string())
    };
    let good = StopConfig::default();
    for bad in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        let expected = |name| Err(format!("{name} is {bad}, expected a number in 0..=1"));
        assert_eq!(fault(StopConfig { completeness: Some(bad), ..good }), expected("completeness"));
        assert_eq!(fault(StopConfig { expected_gain: Some(bad), ..good }), expected("expected_gain"));
        assert_eq!(fault(StopConfig { entropy_share: Some(bad), ..good }), expected("entropy_share"));
    }
    for bad in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        let expected = Err(format!("path_length_m is {bad}, expected a positive number of metres"));
        assert_eq!(fault(StopConfig { path_length: Some(bad), ..good }), expected);
    }
    let none = SessionConfig { max_views: 0, ..config(good) };
    assert_eq!(none.check().unwrap_err().to_string(), "max_views is 0, expected at least 1");
    let edges = StopConfig {
        entropy_share: Some(0.0),
        completeness: Some(1.0),
        expected_gain: Some(0.0),
        path_length: Some(1e-9),
        progress: 1.0,
    };
    assert_eq!(fault(edges), Ok(()));
}

/// Fails at its first attempt.
struct FailsOnce(bool);

impl ViewPlanner for FailsOnce {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        if std::mem::replace(&mut self.0, false) {
            return Err(Error::Planner("the other program does not answer".into()));
        }
        InOrder.plan(situation)
    }
}

#[test]
fn a_planner_that_fails_can_be_asked_again() {
    let mut session = session(FailsOnce(true), NO_PROGRESS_RULE);
    assert!(matches!(session.decide(), Ok(Decision::Move(_))), "the first view is given");
    observe(&mut session, 0);
    let error = session.decide().unwrap_err();
    assert_eq!(error.to_string(), "the planner failed: the other program does not answer");
    assert!(matches!(session.decide(), Ok(Decision::Move(next)) if next.view == Some(1)));
}
