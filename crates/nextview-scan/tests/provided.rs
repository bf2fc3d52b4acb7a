//! Planners provided by the program around the library. This test is a separate process, because it registers
//! some.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use nextview::planner::{GreedyConfig, InOrder, Plan, RandomViews, Situation, ViewPlanner};
use nextview::sensor::DepthImage;
use nextview::{Cancel, Error};
use nextview_scan::{
    Fault, FaultKind, LiveConfig, LiveFrame, LiveScan, PlannerName, PlannerProvider, ProvidedPlanner,
    ScanConfig, ScanRecord, SourceConfig, provide_planners,
};

/// Stands for an interpreter with a module `known` of three classes.
struct Interpreter;

struct Broken;

impl ViewPlanner for Broken {
    fn plan(&mut self, _: &Situation<'_>) -> Result<Plan, Error> {
        Err(Error::Planner("division by zero".into()))
    }
}

impl PlannerProvider for Interpreter {
    fn check(&self, planner: &ProvidedPlanner) -> Result<(), Fault> {
        match (planner.module(), planner.class()) {
            ("known", "InOrder" | "Random" | "Broken") => Ok(()),
            (module, class) => Err(Fault::request(format!("{module} has no {class}"))),
        }
    }

    fn build(
        &self,
        planner: &ProvidedPlanner,
        config: GreedyConfig,
        seed: u64,
    ) -> Result<Box<dyn ViewPlanner>, Fault> {
        assert_eq!(config.theta, 0.25);
        Ok(match planner.class() {
            "Random" => Box::new(RandomViews { seed }),
            "Broken" => Box::new(Broken),
            _ => Box::new(InOrder),
        })
    }
}

fn config(planner: &str) -> ScanConfig {
    provide_planners(Box::new(Interpreter));
    let text = format!("planner = \"{planner}\"\ngreedy.theta = 0.25\nseed = 5\nviews = 4\ncandidates = 30");
    let live = LiveConfig { box_m: Some([-0.1, -0.1, -0.1, 0.1, 0.1, 0.1]), ..LiveConfig::default() };
    ScanConfig { source: SourceConfig::Live(live), ..ScanConfig::parse(&text, None, None).unwrap() }
}

/// Takes a view that shows nothing; `None` if the scan is over.
fn step(scan: &mut LiveScan) -> Result<Option<()>, Fault> {
    let Some(view) = scan.next()? else { return Ok(None) };
    let nothing = vec![f32::INFINITY; scan.config().camera.n_pixels()];
    let image = DepthImage::from_metres(640, 480, nothing).unwrap();
    scan.observe(LiveFrame::new(image, view.world_from_camera)).map(|_| Some(()))
}

fn views(mut scan: LiveScan) -> Vec<Option<usize>> {
    while step(&mut scan).unwrap().is_some() {}
    scan.scan().steps.iter().map(|step| step.view).collect()
}

fn begin(config: ScanConfig) -> LiveScan {
    LiveScan::begin(config, None, Cancel::default()).unwrap()
}

#[test]
fn a_provided_planner_scans_as_a_built_in_one_does() {
    let provided = config("python:known:Random");
    let built_in = ScanConfig { planner: PlannerName::Random.into(), ..provided.clone() };
    assert_eq!(views(begin(provided)), views(begin(built_in)));
}

#[test]
fn its_name_is_kept_and_its_scan_resumed() {
    let dir = std::env::temp_dir().join(format!("nextview-provided-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let mut scan = LiveScan::begin(config("python:known:InOrder"), Some(&dir), Cancel::default()).unwrap();
    step(&mut scan).unwrap();
    step(&mut scan).unwrap();
    drop(scan);
    let scan = LiveScan::resume(&dir, Cancel::default()).unwrap();
    let record = scan.scan().record(scan.config(), nextview_scan::Measured::Nothing).unwrap();
    let json = serde_json::to_string(&record).unwrap();
    assert!(json.contains("\"planner\":\"python:known:InOrder\""), "{json}");
    assert_eq!(serde_json::from_str::<ScanRecord>(&json).unwrap().planner, record.planner);
    assert_eq!(views(scan), [Some(0), Some(1), Some(2), Some(3)]);
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn a_planner_that_fails_ends_the_scan_with_its_error_as_the_cause() {
    let mut scan = begin(config("python:known:Broken"));
    step(&mut scan).unwrap();
    for _ in 0..2 {
        let fault = step(&mut scan).unwrap_err();
        assert_eq!(fault.message, "the planner failed: division by zero");
        assert_eq!(fault.kind, FaultKind::Request);
        assert_eq!(std::error::Error::source(&fault).unwrap().to_string(), "division by zero");
    }
    assert_eq!((scan.scan().steps.len(), scan.stop_reason()), (1, None));
}

#[test]
fn a_planner_that_there_is_not_is_refused_with_all_other_faults() {
    provide_planners(Box::new(Interpreter));
    let text = "planner = \"python:known:Best\"\nvoxel_size_m = -1.0\nstop.completeness = 0.9";
    let faults = ScanConfig::parse(text, None, None).unwrap_err();
    let said: Vec<String> = faults.iter().map(|fault| fault.message.clone()).collect();
    assert!(said.iter().any(|message| message.contains("`voxel_size_m` is -1")), "{said:?}");
    assert!(said.iter().any(|message| message == "known has no Best"), "{said:?}");
    assert!(said.iter().any(|message| message.contains("python:known:Best cannot stop")), "{said:?}");
    assert!(faults.iter().any(|fault| fault.key.as_deref() == Some("planner")));
}
