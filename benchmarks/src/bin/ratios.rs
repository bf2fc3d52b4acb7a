//! Prints the table of ratios from lines `PROGRAM,STAGE,CASE,MILLISECONDS` on standard input. The minimum
//! time counts if a case has several lines.
//!
//!     ratios < results.csv
//!
//! Limits of our own times are milliseconds, or multiples of a stage of the same run. Exits with 1 if a
//! target is missed, unless the variable QUICK is set.

use nextview_benchmarks::is_quick;
use std::collections::BTreeMap;
use std::error::Error;
use std::io::Read;
use std::process::ExitCode;

/// Minimum ratios of a peer's time to ours.
const RATIOS: [(&str, &str, &str, f64); 18] = [
    ("insertion A; per end voxel; unbounded", "1 cm", "octomap", 5.0),
    ("insertion A; per end voxel; unbounded", "5 mm", "octomap", 20.0),
    ("insertion A; per end voxel; unbounded", "2 mm", "octomap", 60.0),
    ("insertion A; per end voxel; unbounded", "1 mm", "octomap", 100.0),
    ("insertion A; per end voxel; unbounded", "1 cm", "bonxai", 1.0),
    ("insertion A; per end voxel; unbounded", "5 mm", "bonxai", 1.0),
    ("insertion A; per end voxel; unbounded", "2 mm", "bonxai", 1.0),
    ("insertion A; per end voxel; unbounded", "1 mm", "bonxai", 1.0),
    ("insertion B; per end voxel; unbounded", "1 cm", "octomap", 10.0),
    ("planning rays", "1 cm", "octomap", 60.0),
    ("planning rays", "5 mm", "octomap", 60.0),
    ("planning rays", "2 mm", "octomap", 100.0),
    ("depth image", "1x", "embree", 1.0),
    ("depth image", "4x", "embree", 1.0),
    ("depth image", "16x", "embree", 1.0),
    ("flow and cover", "19177 rays", "spfa", 200.0),
    ("flow and cover", "19177 rays", "lemon", 1.0),
    ("write .bt", "5 mm", "octomap", 1.0),
];

/// Follows every ray from the camera, as the peers do. Insertion confined to a box does less, so it is not
/// compared.
const UNBOUNDED: &str = "; unbounded";

/// A limit on a time.
enum Limit {
    Ms(f64),
    /// Multiple of the CPU time of planning rays at 5 mm; limits CPU time.
    Multiple(f64),
}

/// Maxima of our own times.
const LIMITS: [(&str, &str, &str, Limit); 12] = [
    ("nextview", "flow and cover", "19177 rays", Limit::Ms(5.0)),
    ("nextview", "flow and cover", "148428 rays", Limit::Ms(50.0)),
    ("nextview wall", "decision; rays of the authors' code", "1 cm", Limit::Ms(3.0)),
    ("nextview", "decision; rays of the authors' code", "1 cm", Limit::Multiple(0.03)),
    ("nextview wall", "decision; 32 x 24 rays", "1 cm", Limit::Ms(150.0)),
    ("nextview wall", "decision; no voxel missed", "1 cm", Limit::Ms(150.0)),
    ("nextview", "decision; no voxel missed", "1 cm", Limit::Multiple(1.5)),
    ("nextview", "decision; default", "5 mm", Limit::Multiple(1.0)),
    ("nextview wall", "decision; most-surface; second view", "5 mm", Limit::Ms(300.0)),
    ("nextview wall", "decision; most-surface; fourth view", "5 mm", Limit::Ms(300.0)),
    ("nextview wall", "scan of ten views", "5 mm", Limit::Ms(2000.0)),
    ("nextview", "scan of ten views", "5 mm", Limit::Multiple(10.0)),
];

/// Minimum time by stage, case and program.
type Times = BTreeMap<(String, String, String), f64>;

/// Stage and case of every row.
type StageRows = Vec<(String, String)>;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let (times, order) = parse(&text)?;
    let time = |stage: &str, case: &str, program: &str| {
        times.get(&(stage.to_owned(), case.to_owned(), program.to_owned())).copied()
    };
    let mut n_missed = 0;
    println!(
        "| stage | case | nextview, ms | peer | peer, ms | ratio | target |\n|---|---|---:|---|---:|---:|---:|"
    );
    let is_alike = |stage: &str| !stage.starts_with("insertion") || stage.ends_with(UNBOUNDED);
    for (stage, case) in order.iter().filter(|(stage, _)| is_alike(stage)) {
        let ours = time(stage, case, "nextview");
        for peer in ["octomap", "bonxai", "embree", "lemon", "spfa", "open3d", "small_gicp"] {
            let theirs = time(stage.trim_end_matches(UNBOUNDED), case, peer);
            let (Some(ours), Some(theirs)) = (ours, theirs) else { continue };
            let target =
                RATIOS.iter().find(|row| (row.0, row.1, row.2) == (stage, case, peer)).map(|row| row.3);
            let verdict = verdict(target.is_none_or(|target| theirs / ours >= target), &mut n_missed);
            let target = target.map_or(String::new(), |target| format!("{target} {verdict}"));
            println!(
                "| {stage} | {case} | {ours:.3} | {peer} | {theirs:.3} | {:.1} | {target} |",
                theirs / ours
            );
        }
    }
    println!(
        "\n| stage | case | one thread, CPU ms | all threads, wall ms | at most |\n|---|---|---:|---:|---:|"
    );
    for (stage, case) in &order {
        let cell = |ms: Option<f64>| ms.map_or(String::new(), |ms| format!("{ms:.3}"));
        let ours = ["nextview", "nextview wall"].map(|program| time(stage, case, program));
        let limits = LIMITS.iter().filter(|row| (row.1, row.2) == (stage, case));
        let limits = limits.map(|(program, _, _, limit)| {
            let (text, most) = match limit {
                Limit::Ms(ms) => (format!("{ms} ms"), Some(*ms)),
                Limit::Multiple(n) => {
                    (format!("{n} x"), time("planning rays", "5 mm", "nextview").map(|ms| n * ms))
                }
            };
            let is_met = time(stage, case, program).zip(most).is_some_and(|(ms, most)| ms <= most);
            format!("{text} {}", verdict(is_met, &mut n_missed))
        });
        println!(
            "| {stage} | {case} | {} | {} | {} |",
            cell(ours[0]),
            cell(ours[1]),
            limits.collect::<Vec<_>>().join(", ")
        );
    }
    Ok(if n_missed == 0 || is_quick() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn verdict(is_met: bool, n_missed: &mut usize) -> &'static str {
    *n_missed += !is_met as usize;
    if is_met { "met" } else { "**missed**" }
}

/// The times, and stages with cases in the order of their first line.
fn parse(text: &str) -> Result<(Times, StageRows), Box<dyn Error>> {
    let (mut times, mut order) = (Times::new(), StageRows::new());
    for line in text.lines() {
        let fields: Vec<&str> = line.split(',').collect();
        let &[program, stage, case, ms] = fields.as_slice() else {
            return Err(format!("not a line PROGRAM,STAGE,CASE,MILLISECONDS: {line}").into());
        };
        let ms: f64 = ms.parse().map_err(|_| format!("no time in line: {line}"))?;
        let [stage, case] = [stage, case].map(str::to_owned);
        if !order.contains(&(stage.clone(), case.clone())) {
            order.push((stage.clone(), case.clone()));
        }
        let least = times.entry((stage, case, program.to_owned())).or_insert(ms);
        *least = least.min(ms);
    }
    Ok((times, order))
}
