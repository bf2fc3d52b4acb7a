use super::line::line_contact;
use super::shortcut::shorten;
use super::timing::{duration, motion_time};
use super::tree::connect;
use super::{JointPath, NoPath};
use crate::Arm;
use crate::collision::Checker;
use nextview::geometry::random::Random;
use nextview::{Cancel, Cancelled};

/// Number of searches for a path that is not straight; the fastest is kept.
const N_ATTEMPTS: u64 = 4;

/// Number of changes tried to speed up a path.
const N_CHANGES: usize = 150;

/// Plans a collision-free path: straight in joint values if that is free, otherwise by random search with up
/// to `effort` samples (1000 is plenty in most cells). The same seed gives the same path.
pub fn plan_path(
    checker: &Checker,
    from: &[f64],
    to: &[f64],
    seed: u64,
    effort: usize,
    cancel: &Cancel,
) -> Result<JointPath, NoPath> {
    plan_path_to_any(checker, from, &[to.to_vec()], seed, effort, cancel).map(|(_, path)| path)
}

/// Plans a path to one of several goals, for example all joint values that bring a camera to a view; returns
/// the path and the number of the goal. Prefers straight lines and, among them or without any, the goal that
/// the joints reach first.
pub fn plan_path_to_any(
    checker: &Checker,
    from: &[f64],
    goals: &[Vec<f64>],
    seed: u64,
    effort: usize,
    cancel: &Cancel,
) -> Result<(usize, JointPath), NoPath> {
    check(checker.arm(), from, goals)?;
    if let Some(contact) = checker.contact(from) {
        return Err(NoPath::StartTouches(contact));
    }
    let mut order: Vec<(f64, usize)> =
        (0..goals.len()).map(|goal| (motion_time(checker.arm(), from, &goals[goal]), goal)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut free, mut contacts) = (Vec::new(), Vec::new());
    for &(_, goal) in &order {
        match checker.contact(&goals[goal]) {
            None => free.push(goal),
            Some(contact) => contacts.push(contact),
        }
    }
    if free.is_empty() {
        return Err(NoPath::EndTouches(contacts));
    }
    for &goal in &free {
        if line_contact(checker, from, &goals[goal], cancel)?.is_none() {
            return Ok((goal, JointPath::new(vec![from.to_vec(), goals[goal].clone()])));
        }
    }
    for &goal in &free {
        if let Some(corners) = search(checker, from, &goals[goal], seed, effort, cancel)? {
            return Ok((goal, JointPath::new(corners)));
        }
    }
    Err(NoPath::NotFound { n_samples: effort * free.len() })
}

/// The fastest of several paths. Later attempts may use as many samples as the first one left over.
fn search(
    checker: &Checker,
    from: &[f64],
    to: &[f64],
    seed: u64,
    effort: usize,
    cancel: &Cancel,
) -> Result<Option<Vec<Vec<f64>>>, Cancelled> {
    let mut best: Option<(f64, Vec<Vec<f64>>)> = None;
    for attempt in 0..N_ATTEMPTS {
        let mut random = Random::new(seed, attempt);
        let Some(corners) = connect(checker, from, to, &mut random, effort, cancel)? else { break };
        let corners = shorten(checker, corners, &mut random, N_CHANGES, cancel)?;
        let time = duration(checker.arm(), &corners);
        if best.as_ref().is_none_or(|(least, _)| time < *least) {
            best = Some((time, corners));
        }
    }
    Ok(best.map(|(_, corners)| corners))
}

fn check(arm: &Arm, from: &[f64], goals: &[Vec<f64>]) -> Result<(), NoPath> {
    let mut faults = Vec::new();
    if goals.is_empty() {
        faults.push("there is no goal".to_owned());
    }
    let ends = std::iter::once(("start".to_owned(), from));
    let goals = goals.iter().enumerate().map(|(i, goal)| (format!("goal {i}"), goal.as_slice()));
    for (name, values) in ends.chain(goals) {
        if values.len() != arm.n_joints() {
            faults.push(format!("{name} has {} values, expected {}", values.len(), arm.n_joints()));
            continue;
        }
        for (joint, value) in arm.joints.iter().zip(values) {
            let limits = joint.limits;
            // An infinite range does not make an infinite value valid.
            if !limits.contains(*value) || !value.is_finite() {
                let range = format!("expected {} to {}", limits.lower, limits.upper);
                faults.push(format!("{name}: {} is {value}, {range}", joint.name));
            }
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(NoPath::Invalid(faults)) }
}
