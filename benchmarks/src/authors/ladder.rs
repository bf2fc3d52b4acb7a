use super::recording::N_SCANS;
use super::run::{ChoiceRule, ScannedObject, StepResult};
use super::{Repair, Slips};
use crate::Outcome;
use rayon::prelude::*;
use std::time::Duration;

/// Runs of one kind with different draws.
pub struct Rung {
    /// Name of the kind.
    pub name: String,
    /// Mean coverage after each scan.
    pub coverage: [f64; N_SCANS],
    /// The lowest and the highest coverage after the last scan.
    pub last: [f64; 2],
    /// Mean entropy after the last scan, as a share.
    pub entropy: f64,
    /// Number of rays of the first plan; `None` for random views.
    pub n_rays: Option<usize>,
    /// Mean planning time.
    pub plan_time: Duration,
}

impl Rung {
    /// Runs with these slips, once per choice.
    pub fn run(name: &str, scene: &ScannedObject, slips: Slips, choices: &[ChoiceRule]) -> Outcome<Self> {
        let run = |&choice: &ChoiceRule| scene.run(slips, choice).map_err(|error| error.to_string());
        let runs: Vec<Vec<StepResult>> = choices.par_iter().map(run).collect::<Result<_, _>>()?;
        let mean = |value: &dyn Fn(&[StepResult]) -> f64| {
            runs.iter().map(|run| value(run)).sum::<f64>() / runs.len() as f64
        };
        let last = |run: &[StepResult]| run[N_SCANS - 1].coverage;
        let plans = || runs.iter().flatten().filter_map(|step| step.plan.as_ref());
        let n_plans = plans().count().max(1) as u32;
        Ok(Self {
            name: name.to_owned(),
            coverage: std::array::from_fn(|scan| mean(&|run| run[scan].coverage)),
            last: [
                runs.iter().map(|run| last(run)).fold(f64::INFINITY, f64::min),
                runs.iter().map(|run| last(run)).fold(0.0, f64::max),
            ],
            entropy: mean(&|run| run[N_SCANS - 1].entropy),
            n_rays: plans().next().map(|plan| plan.n_rays),
            plan_time: plans().map(|plan| plan.time).sum::<Duration>() / n_plans,
        })
    }
}

/// Returns the paper's defaults with `n` draws; `lasting` draws hold for a run, others for a plan.
pub fn orders(n: u64, lasting: bool) -> Vec<ChoiceRule> {
    (0..n).map(|order| ChoiceRule::MaxFlow { gamma: 0.5, uses_history: true, order, lasting }).collect()
}

/// Runs the authors' program, then repairs one slip after the other.
pub fn cumulative(scene: &ScannedObject, choices: &[ChoiceRule]) -> Outcome<Vec<Rung>> {
    let mut slips = Slips::AUTHORS_CODE;
    let mut rungs = vec![Rung::run("authors-code", scene, slips, choices)?];
    for (name, repair) in Slips::REPAIRS {
        repair(&mut slips);
        rungs.push(Rung::run(name, scene, slips, choices)?);
    }
    Ok(rungs)
}

/// Runs the authors' program with each slip repaired alone.
pub fn alone(scene: &ScannedObject, choices: &[ChoiceRule]) -> Outcome<Vec<Rung>> {
    let rung = |(name, repair): Repair| {
        let mut slips = Slips::AUTHORS_CODE;
        repair(&mut slips);
        Rung::run(name, scene, slips, choices)
    };
    Slips::REPAIRS.into_iter().map(rung).collect()
}

/// Runs other weights of the flow, with these slips: the extremes of table IV.
pub fn weights(scene: &ScannedObject, slips: Slips, n: u64, kind: &str) -> Outcome<Vec<Rung>> {
    let cases = [
        ("gamma 0", 0.0, true),
        ("gamma 1", 1.0, true),
        ("gamma 0.5, no history", 0.5, false),
        ("gamma 1, no history", 1.0, false),
    ];
    let rung = |(name, gamma, uses_history)| {
        let choices: Vec<_> =
            (0..n).map(|order| ChoiceRule::MaxFlow { gamma, uses_history, order, lasting: false }).collect();
        Rung::run(&format!("{kind}, {name}"), scene, slips, &choices)
    };
    cases.into_iter().map(rung).collect()
}
