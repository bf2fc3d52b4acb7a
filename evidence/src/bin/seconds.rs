//! Coverage over seconds: the default planner per view, with a movement cost and per second, against random
//! views and fixed plans.
//!
//! `cargo run --release -p nextview-evidence --bin seconds -- N_STARTS MESH ...`
//!
//! A fixed plan has a given number of candidates, as far apart as possible, in the order of the shortest tour
//! or always the nearest next. The camera moves and measures with the defaults of `[motion]`; planning takes
//! no time. Prints the reachable coverage after some times and its mean over the longest of them, as means
//! over all objects and first views.

use glam::DVec3;
use nextview::Error as PlanningError;
use nextview::motion::{KeepOut, MotionConfig, tour};
use nextview::planner::{Choice, MostSurface, MostSurfaceConfig, Plan, RandomViews, Situation, ViewPlanner};
use nextview_benchmarks::Outcome;
use nextview_evidence::known_object::{KnownObject, KnownStep};
use std::path::Path;

/// Seconds at which the coverage is printed; scans end at the last one.
const TIMES: [f64; 6] = [10.0, 20.0, 30.0, 45.0, 60.0, 90.0];

/// Number of candidates between first views: a prime, which spreads them all around.
const APART: usize = 137;

#[derive(Clone, Copy)]
enum Kind {
    MostSurface { theta: f64, per_second: bool },
    Random,
    ShortestTour { n_views: usize },
    NearestNext { n_views: usize },
}

const KINDS: [(&str, Kind); 11] = [
    ("most-surface", Kind::MostSurface { theta: 0.0, per_second: false }),
    ("most-surface, theta 0.3", Kind::MostSurface { theta: 0.3, per_second: false }),
    ("most-surface, theta 0.6", Kind::MostSurface { theta: 0.6, per_second: false }),
    ("most-surface, per second", Kind::MostSurface { theta: 0.0, per_second: true }),
    ("random", Kind::Random),
    ("6 even views, shortest tour", Kind::ShortestTour { n_views: 6 }),
    ("10 even views, shortest tour", Kind::ShortestTour { n_views: 10 }),
    ("16 even views, shortest tour", Kind::ShortestTour { n_views: 16 }),
    ("24 even views, shortest tour", Kind::ShortestTour { n_views: 24 }),
    ("16 even views, nearest next", Kind::NearestNext { n_views: 16 }),
    ("all views, nearest next", Kind::NearestNext { n_views: KnownObject::N_CANDIDATES }),
];

fn main() -> Outcome<()> {
    let mut arguments = std::env::args().skip(1);
    let n_starts: usize = arguments.next().ok_or("usage: seconds N_STARTS MESH ...")?.parse()?;
    let mut scans: Vec<Vec<Vec<KnownStep>>> = KINDS.iter().map(|_| Vec::new()).collect();
    for path in arguments {
        eprintln!("{path}");
        let object = KnownObject::load(Path::new(&path))?;
        for first_view in (0..n_starts).map(|start| start * APART % KnownObject::N_CANDIDATES) {
            for ((_, kind), scans) in KINDS.iter().zip(&mut scans) {
                let is_enough = |steps: &[KnownStep]| {
                    steps.last().is_some_and(|last| last.seconds > TIMES[TIMES.len() - 1])
                };
                scans.push(object.scan(planner(*kind, &object, first_view)?, first_view, is_enough)?);
            }
        }
    }
    let times = TIMES.map(|time| format!(" {time:.0} s |"));
    println!("| |{} mean |\n|---|{}---:|", times.concat(), "---:|".repeat(TIMES.len()));
    for ((name, _), scans) in KINDS.iter().zip(&scans) {
        let mean_of = |of: &dyn Fn(&[KnownStep]) -> f64| {
            100.0 * scans.iter().map(|steps| of(steps)).sum::<f64>() / scans.len() as f64
        };
        let cells = TIMES.map(|time| format!(" {:.1} |", mean_of(&|steps| coverage_at(steps, time))));
        println!("| {name} |{} {:.1} |", cells.concat(), mean_of(&mean_coverage));
    }
    Ok(())
}

fn planner(kind: Kind, object: &KnownObject, first_view: usize) -> Outcome<Box<dyn ViewPlanner>> {
    let place = |view: usize| object.views.pose(view).translation();
    Ok(match kind {
        Kind::MostSurface { theta, per_second } => {
            Box::new(MostSurface::new(MostSurfaceConfig { theta, per_second, ..Default::default() })?)
        }
        Kind::Random => Box::new(RandomViews { seed: first_view as u64 }),
        Kind::ShortestTour { n_views } => {
            let views = even_views(object, first_view, n_views);
            let bounds = object.scene.planning_box(KnownObject::VOXEL_SIZE);
            let ball = KeepOut::around(&bounds, MotionConfig::default().clearance)?;
            let positions: Vec<DVec3> = views[1..].iter().map(|&view| place(view)).collect();
            let order = tour(Some(place(first_view)), &positions, &ball)?;
            Box::new(Listed(order.into_iter().map(|i| views[1 + i]).collect()))
        }
        Kind::NearestNext { n_views } => {
            let mut left = even_views(object, first_view, n_views);
            let mut order = vec![left.remove(0)];
            while !left.is_empty() {
                let from = place(order[order.len() - 1]);
                let nearest = (0..left.len())
                    .min_by(|&a, &b| from.distance(place(left[a])).total_cmp(&from.distance(place(left[b]))));
                order.push(left.remove(nearest.ok_or("views are left")?));
            }
            Box::new(Listed(order.split_off(1)))
        }
    })
}

/// Takes these views in this order.
struct Listed(Vec<usize>);

impl ViewPlanner for Listed {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, PlanningError> {
        let next = self.0.iter().find(|view| !situation.visited().contains(view));
        Ok(Plan { choice: next.map(|&view| Choice::new(view, 0.0)), ..Plan::default() })
    }
}

/// `n_views` candidates: the first view, then always the one farthest from all before it.
fn even_views(object: &KnownObject, first_view: usize, n_views: usize) -> Vec<usize> {
    let toward = |view: usize| (object.views.pose(view).translation() - object.scene.center()).normalize();
    let mut views = vec![first_view];
    let mut cosines = vec![-1.0_f64; object.views.len()];
    while views.len() < n_views.min(object.views.len()) {
        let last = toward(views[views.len() - 1]);
        cosines
            .iter_mut()
            .enumerate()
            .for_each(|(view, cosine)| *cosine = cosine.max(toward(view).dot(last)));
        views.iter().for_each(|&view| cosines[view] = f64::INFINITY);
        views.extend((0..cosines.len()).min_by(|&a, &b| cosines[a].total_cmp(&cosines[b])));
    }
    views
}

/// The coverage after the last view measured by this time.
fn coverage_at(steps: &[KnownStep], time: f64) -> f64 {
    steps.iter().rev().find(|step| step.seconds <= time).map_or(0.0, |step| step.coverage)
}

/// The mean coverage over all times until scans end.
fn mean_coverage(steps: &[KnownStep]) -> f64 {
    let end = TIMES[TIMES.len() - 1];
    let ends = steps.iter().skip(1).map(|step| step.seconds).chain([end]).map(|time| time.min(end));
    let areas = steps.iter().zip(ends).map(|(step, until)| step.coverage * (until - step.seconds).max(0.0));
    areas.sum::<f64>() / end
}
