//! Views for a purpose: the needs of each purpose of a scan, and the results of planners and goals.
//!
//!     cargo run --release -p nextview-evidence --bin purposes -- MESH ...
//!
//! Twelve views of each mesh at its true size by a D435i, with its noise and right poses. The table is found,
//! the box grows, and no scan ends before its last view unless nothing is left to gain. Prints a table with
//! the results of each way to choose views, as means over the objects. A second table compares the results of
//! each purpose's own way with the default planner and random views, with 95 % intervals of the paired
//! differences over the objects.

use nextview::session::Decision;
use nextview::surface::LooksGoal;
use nextview_benchmarks::Outcome;
use nextview_campaign::statistics::Interval;
use nextview_evidence::needs::{Needs, TrueObject};
use nextview_scan::{BoxRule, PlannerName, ScanConfig, SensorName, SimulatedObject, TableRule};

const N_VIEWS: usize = 12;

/// Number of scans by random views of each object.
const N_RANDOM: u64 = 2;

/// Goal for the accuracy of the surface, mm.
const GOAL_MM: f64 = 0.2;

/// Minimum overlap for photogrammetry.
const OVERLAP: f64 = 0.8;

/// A method of choosing views.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    set: fn(&mut ScanConfig),
}

const MOST_SURFACE: usize = 0;
const RANDOM: usize = 1;

const WAYS: [Way; 6] = [
    Way { name: "most-surface", set: |_| () },
    Way { name: "random", set: |config| config.planner = PlannerName::Random.into() },
    Way { name: "even-views", set: |config| config.planner = PlannerName::EvenViews.into() },
    Way { name: "most-surface, looks", set: |config| config.looks = Some(LooksGoal::default()) },
    Way {
        name: "most-surface, overlap and looks",
        set: |config| {
            config.min_overlap = Some(OVERLAP);
            config.looks = Some(LooksGoal::default());
        },
    },
    Way { name: "most-surface, goal", set: |config| config.goal_mm = Some(GOAL_MM) },
];

/// The measures, in the order of [`Needs::values`].
const MEASURES: [&str; 8] = [
    "surface seen",
    "largest angle",
    "mean angle",
    "least overlap",
    "mean overlap",
    "matchable",
    "3 looks",
    "within the goal",
];

/// Purposes, each with the number of its method and the numbers of its measures.
const PURPOSES: [(&str, usize, &[usize]); 5] = [
    ("most surface", MOST_SURFACE, &[0]),
    ("reference views", 2, &[1, 2]),
    ("photogrammetry", 4, &[5, 3]),
    ("three looks", 3, &[6]),
    ("error of 0.2 mm", 5, &[7]),
];

fn main() -> Outcome<()> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    if paths.is_empty() {
        return Err("usage: purposes MESH ...".into());
    }
    let mut found: Vec<Vec<[f64; 8]>> = Vec::new();
    for path in &paths {
        found.push(of_object(path)?);
    }
    let n_objects = found.len();
    println!("{n_objects} objects, {N_VIEWS} views; random views: mean of {N_RANDOM} scans of each.\n");
    print_means(&found);
    print_differences(&found);
    Ok(())
}

/// The measures of each method on an object.
fn of_object(path: &str) -> Outcome<Vec<[f64; 8]>> {
    let base = config(path)?;
    let object = SimulatedObject::new(&base)?;
    eprintln!("{} {}", object.description(), object.notes().join("; "));
    let truth = TrueObject::new(object.scene.camera(), object.scene.center(), &object.views)?;
    let mut found = Vec::new();
    for (i, way) in WAYS.iter().enumerate() {
        let mut config = base.clone();
        (way.set)(&mut config);
        let n_scans = if i == RANDOM { N_RANDOM } else { 1 };
        let scans = (0..n_scans).map(|seed| {
            let config = ScanConfig { seed, view_seed: Some(0), ..config.clone() };
            Ok(scan(&config, &object, &truth)?.values())
        });
        let scans = scans.collect::<Outcome<Vec<_>>>()?;
        let values: [f64; 8] = std::array::from_fn(|i| mean(scans.iter().map(|values| values[i])));
        eprintln!("  {:<32} {values:6.3?}", way.name);
        found.push(values);
    }
    Ok(found)
}

fn config(path: &str) -> Outcome<ScanConfig> {
    let mut config = ScanConfig {
        object: path.to_owned(),
        views: Some(N_VIEWS),
        baselines: false,
        view_seed: Some(0),
        ..ScanConfig::default()
    };
    config.set_sensor(SensorName("d435i".to_owned()))?;
    (config.object_box.rule, config.object_box.table) = (BoxRule::Grows, TableRule::Fit);
    config.stop.progress = 0.0;
    Ok(config)
}

fn scan(config: &ScanConfig, object: &SimulatedObject, truth: &TrueObject<'_>) -> Outcome<Needs> {
    config.check()?;
    let mut session = object.session(config, config.planner(None)?)?;
    while let Decision::Move(next) = session.decide()? {
        session.observe(&object.scene.camera().capture(&next.world_from_camera)?)?;
    }
    if session.frames().len() < N_VIEWS {
        eprintln!("  {} views only: {:?}", session.frames().len(), session.decide()?);
    }
    let bounds = session.bounds().ok_or("no object was found")?;
    truth.needs(session.frames(), bounds, (object.voxel_size, config.surface_error(), GOAL_MM / 1e3))
}

fn print_means(found: &[Vec<[f64; 8]>]) {
    println!("| | {} |", MEASURES.join(" | "));
    println!("|---|{}", "---:|".repeat(MEASURES.len()));
    for (way, name) in WAYS.iter().map(|way| way.name).enumerate() {
        let cells = (0..MEASURES.len()).map(|i| shown(i, mean(found.iter().map(|object| object[way][i]))));
        println!("| {name} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
}

fn print_differences(found: &[Vec<[f64; 8]>]) {
    println!(
        "\n| purpose | needs | most-surface | random | its own way | own way - most-surface | own way - random |"
    );
    println!("|---|---|---:|---:|---|---:|---:|");
    for (purpose, own, needs) in PURPOSES {
        for &i in needs {
            let of = |way: usize| found.iter().map(|object| object[way][i]).collect::<Vec<_>>();
            let beside = |way: usize| {
                let differences: Vec<f64> =
                    of(own).iter().zip(of(way)).map(|(own, other)| own - other).collect();
                match Interval::of_mean(&differences) {
                    _ if own == way => String::new(),
                    None => signed(i, mean(differences)),
                    Some(Interval { low, high }) => {
                        format!(
                            "{} ({} to {})",
                            signed(i, mean(differences)),
                            signed(i, low),
                            signed(i, high)
                        )
                    }
                }
            };
            let value = |way: usize| shown(i, mean(of(way)));
            println!(
                "| {purpose} | {} | {} | {} | {} with {} | {} | {} |",
                MEASURES[i],
                value(MOST_SURFACE),
                value(RANDOM),
                value(own),
                WAYS[own].name,
                beside(MOST_SURFACE),
                beside(RANDOM),
            );
        }
    }
}

/// A measure's value as text: angles in degrees, shares in percent.
fn shown(measure: usize, value: f64) -> String {
    if is_angle(measure) { format!("{value:.1}°") } else { format!("{:.1} %", 100.0 * value) }
}

/// A difference of two values as text.
fn signed(measure: usize, value: f64) -> String {
    if is_angle(measure) { format!("{value:+.1}") } else { format!("{:+.1}", 100.0 * value) }
}

fn is_angle(measure: usize) -> bool {
    MEASURES[measure].ends_with("angle")
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (n, sum) = values.into_iter().fold((0.0, 0.0), |(n, sum), value| (n + 1.0, sum + value));
    sum / f64::max(n, 1.0)
}
