use super::Slips;
use super::ladder::{self, Rung};
use super::map::Knowledge;
use super::recording::N_SCANS;
use super::reference::{
    CURVES, FIRST_PLAN, FIRST_PLAN_THROUGH_UNKNOWN, ORDER_LIKE_FIXED, ORDER_LIKE_RECORDED,
};
use super::run::{ChoiceRule, FirstPlan, ScannedObject};
use crate::Outcome;
use nextview_scan::files::csv_field;
use std::fmt::Write;

/// Numbers of averaged runs of each kind.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Number of draws of thread timing.
    pub n_orders: u64,
    /// Number of draws of random views.
    pub n_random: u64,
}

/// All measurements of the program `authors_code`, as CSV, and planning times, which differ between runs.
pub struct Measurements {
    /// The recorded views, scanned again.
    pub scans: String,
    /// The first plan on the recorded first map.
    pub first_plan: String,
    /// Coverage with slips and without them.
    pub coverage: String,
    /// Planning times, a line for each kind of run.
    pub times: String,
}

impl Measurements {
    /// Runs everything, and passes the name of the current part to `under_way`. All but the times are
    /// bit-identical in every run.
    pub fn new(scene: &ScannedObject, effort: Effort, under_way: impl Fn(&str)) -> Outcome<Self> {
        let (choices, n) = (ladder::orders(effort.n_orders, false), effort.n_orders);
        under_way("recorded views");
        let scans = replay(scene)?;
        under_way("the first plan");
        let first_plan = first_plan(scene)?;
        let views: String = (1..=N_SCANS).map(|scan| format!("view_{scan},")).collect();
        let coverage = format!("part,program,{views}lowest,highest,n_rays,entropy_percent\n");
        let mut report = Self { scans, first_plan, coverage, times: String::new() };
        under_way("slip after slip");
        let mut rungs = vec![
            Rung::run("recorded views", scene, Slips::AUTHORS_CODE, &[ChoiceRule::Recorded])?,
            one_order(scene, ORDER_LIKE_RECORDED)?,
            one_order(scene, ORDER_LIKE_FIXED)?,
        ];
        rungs.extend(ladder::cumulative(scene, &choices)?);
        under_way("random views");
        let random: Vec<_> = (0..effort.n_random).map(ChoiceRule::Random).collect();
        rungs.push(Rung::run("random views", scene, Slips::AUTHORS_CODE, &random)?);
        report.rungs("one after the other", &CURVES, &rungs)?;
        under_way("each slip alone");
        report.rungs("alone", &[], &ladder::alone(scene, &choices)?)?;
        under_way("draws that last");
        let lasting = ladder::cumulative(scene, &ladder::orders(n, true))?;
        report.rungs("one after the other, draws last", &CURVES[2..], &lasting)?;
        under_way("weights of the flow");
        let mut weights = ladder::weights(scene, Slips::AUTHORS_CODE, n, "authors-code")?;
        weights.extend(ladder::weights(scene, Slips::PAPER, n, "the paper's formulas")?);
        report.rungs("weights of the flow", &[], &weights)?;
        Ok(report)
    }

    fn rungs(&mut self, part: &str, curves: &[(&str, [f64; N_SCANS])], rungs: &[Rung]) -> Outcome<()> {
        for (name, curve) in curves {
            writeln!(self.coverage, "{},{},{},,,", csv_field(part), csv_field(name), columns(curve))?;
        }
        for rung in rungs {
            let ([low, high], curve) = (rung.last, columns(&rung.coverage));
            let rays = rung.n_rays.map_or(String::new(), |n| n.to_string());
            let (name, entropy) = (csv_field(&rung.name), rung.entropy * 100.0);
            let part = csv_field(part);
            writeln!(self.coverage, "{part},{name},{curve},{low:.3},{high:.3},{rays},{entropy:.1}")?;
            writeln!(self.times, "{part}, {name}: {:.1} ms", rung.plan_time.as_secs_f64() * 1e3)?;
        }
        Ok(())
    }
}

fn columns(curve: &[f64]) -> String {
    curve.iter().map(|coverage| format!("{coverage:.3}")).collect::<Vec<_>>().join(",")
}

fn one_order(scene: &ScannedObject, order: u64) -> Outcome<Rung> {
    let name = format!("authors-code, order {order}");
    Rung::run(&name, scene, Slips::AUTHORS_CODE, &[ChoiceRule::max_flow(order)])
}

fn replay(scene: &ScannedObject) -> Outcome<String> {
    let mut table =
        "scan,view,recorded_occupied,occupied,recorded_entropy_nats,entropy_nats,different_voxels\n"
            .to_owned();
    let recording = &scene.recording;
    for (scan, step) in scene.run(Slips::AUTHORS_CODE, ChoiceRule::Recorded)?.iter().enumerate() {
        let theirs = &recording.maps[scan];
        let [ours, recorded] = [&step.log_odds, theirs].map(|map| Knowledge::new(map, recording, true));
        let (ours, recorded) = (ours?, recorded?);
        let n_different = step.log_odds.iter().zip(theirs).filter(|(a, b)| a != b).count();
        writeln!(
            table,
            "{},{},{},{},{:.2},{:.2},{n_different}",
            scan + 1,
            step.view,
            recorded.n_occupied(),
            ours.n_occupied(),
            recorded.entropy(),
            ours.entropy(),
        )?;
    }
    Ok(table)
}

fn first_plan(scene: &ScannedObject) -> Outcome<String> {
    let mut table =
        "rays_rule,program,n_rays,rays_per_view,views_without_rays,flow_voxels,flow_edges,quality\n"
            .to_owned();
    let through = Slips { rays_stop_at_unknown: false, ..Slips::AUTHORS_CODE };
    for (name, theirs, slips) in [
        ("authors-code", FIRST_PLAN.map(Some), Slips::AUTHORS_CODE),
        ("rays pass unknown voxels", FIRST_PLAN_THROUGH_UNKNOWN, through),
    ] {
        let cell = |(value, digits): (Option<f64>, usize)| {
            value.map_or(String::new(), |value| format!("{value:.digits$}"))
        };
        let cells = |values: [Option<f64>; 6]| {
            values.into_iter().zip([0, 1, 0, 0, 0, 1]).map(cell).collect::<Vec<_>>().join(",")
        };
        writeln!(table, "{name},theirs,{}", cells(theirs))?;
        writeln!(table, "{name},here,{}", cells(facts(&scene.survey(slips)?).map(Some)))?;
    }
    Ok(table)
}

fn facts(survey: &FirstPlan) -> [f64; 6] {
    let FirstPlan { n_rays, rays_per_view, n_views_without, n_voxels, n_edges, quality } = *survey;
    [n_rays as f64, rays_per_view, n_views_without as f64, n_voxels as f64, n_edges as f64, quality]
}
