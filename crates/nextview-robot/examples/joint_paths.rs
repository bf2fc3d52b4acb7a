//! Plans paths between random joint values in a cell and prints them as JSON lines, for an independent check:
//! `cargo run --release -p nextview-robot --example joint_paths -- 10000 600 20 > paths.jsonl`, then
//! `checks/joint_paths.py paths.jsonl`. The numbers are pairs, the most seconds to take, and on how many of
//! the pairs, spread evenly, 20 attempts are compared.
//!
//! The first line is the cell, every other one a pair: its corners, or none if no path was found, the time to
//! plan, the duration, and, where compared, the shortest duration of 20 attempts.

#[path = "../tests/cell/mod.rs"]
mod cell;

use nextview::Cancel;
use nextview::geometry::Pose;
use nextview::geometry::random::Random;
use nextview_robot::collision::Checker;
use nextview_robot::path::{JointPath, JointTrajectory, plan_path};
use nextview_robot::{Shape, ShapeKind};
use serde_json::{Value, json};
use std::time::Instant;

const EFFORT: usize = 2000;
const N_COMPARED: u64 = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Result<Vec<u64>, _> = std::env::args().skip(1).map(|n| n.parse()).collect();
    let [n_pairs, most_seconds, n_compared] = numbers?[..] else {
        return Err("expected pairs, seconds, and pairs to compare".into());
    };
    let checker = cell::checker();
    let cancel = Cancel::default();
    println!("{}", described(&checker));
    let mut random = Random::new(10, 0);
    let start = Instant::now();
    let duration = |path: &JointPath| JointTrajectory::along(path, checker.arm()).duration();
    for pair in 0..n_pairs {
        if start.elapsed().as_secs() >= most_seconds {
            break;
        }
        let from = cell::free_values(&checker, &mut random);
        let to = cell::free_values(&checker, &mut random);
        let plan = |seed: u64| plan_path(&checker, &from, &to, seed, EFFORT, &cancel);
        let clock = Instant::now();
        let path = plan(0).ok();
        let plan_ms = clock.elapsed().as_secs_f64() * 1e3;
        let is_compared = pair * n_compared / n_pairs != (pair + 1) * n_compared / n_pairs;
        let best = is_compared.then(|| {
            let others = (0..N_COMPARED).filter_map(|seed| plan(seed).ok());
            others.map(|path| duration(&path)).fold(f64::INFINITY, f64::min)
        });
        let corners = path.as_ref().map(JointPath::corners);
        let taken = path.as_ref().map(duration);
        println!("{}", json!({"corners": corners, "plan_ms": plan_ms, "duration_s": taken, "best_s": best}));
    }
    Ok(())
}

fn described(checker: &Checker) -> Value {
    let arm = checker.arm();
    let joint = |i: usize| json!({"parent_from_joint": arm.joints[i].parent_from_joint});
    let shapes = |shapes: &[Shape], link_from_frame: Pose| -> Vec<Value> {
        let each = shapes.iter().map(|shape| {
            let pose = link_from_frame * shape.link_from_shape;
            match &shape.kind {
                ShapeKind::Box(half) => json!({"pose": pose, "half": half}),
                ShapeKind::Cylinder { radius, length } => {
                    json!({"pose": pose, "radius": radius, "length": length})
                }
                other => json!({"pose": pose, "other": format!("{other:?}")}),
            }
        });
        each.collect()
    };
    let links: Vec<Value> =
        arm.links.iter().map(|link| Value::from(shapes(&link.shapes, Pose::IDENTITY))).collect();
    let (wall, half) = cell::wall();
    let blocked: String = cell::blocked().iter().map(|is| if *is { '1' } else { '0' }).collect();
    json!({
        "joints": (0..arm.n_joints()).map(joint).collect::<Vec<_>>(),
        "links": links,
        "camera": shapes(&cell::camera().shapes, arm.last_link_from_flange),
        "may_touch": arm.may_touch,
        "wall": {"pose": wall, "half": half},
        "grid": cell::base_from_grid(), "voxel": cell::VOXEL, "n": cell::N_VOXELS, "blocked": blocked,
    })
}
