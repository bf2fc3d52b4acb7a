//! The files of a finished scan.

use super::finished::{FinishedScan, Measured};
use super::model::FinalModel;
use super::outcome::{Outcome, milliseconds, stop_phrase};
use super::recorded::AccuracyMm;
use super::registration::RegistrationLine;
use super::{ScanConfig, ways_so_far};
use crate::Failure;
use crate::files::ResultFolder;
use crate::report::{self, ScanReport};
use glam::DVec3;
use nextview::geometry::Pose;
use nextview::model::{write_cloud, write_mesh};
use nextview::motion::{Way, Waypoint};
use nextview::session::StepReport;
use rustc_hash::FxHashSet;
use serde::Serialize;
use std::io::Write;

/// What is written.
pub(super) struct Results<'a> {
    pub config: &'a ScanConfig,
    pub scan: &'a FinishedScan<Measured>,
    pub outcome: &'a Outcome,
    pub model: &'a FinalModel,
}

impl Results<'_> {
    /// Writes all files and shows the folder.
    pub fn write(&self, mut folder: ResultFolder) -> Result<(), Failure> {
        let config = toml::to_string(self.config).map_err(Failure::data)?;
        folder.add("config.toml", |w| Ok(w.write_all(config.as_bytes())?))?;
        folder.add("steps.jsonl", |w| self.write_steps(w))?;
        folder.add("views.csv", |w| self.write_views(w))?;
        folder.add("waypoints.csv", |w| self.write_waypoints(w))?;
        let octree = self.scan.session.map().to_octree()?.pruned();
        folder.add("map.ot", |w| Ok(octree.write_ot(w)?))?;
        folder.add("map.bt", |w| Ok(octree.write_bt(w)?))?;
        let FinalModel { cloud, mesh, vertices } = self.model;
        folder.add("cloud.ply", |w| Ok(write_cloud(w, cloud)?))?;
        folder.add("mesh.ply", |w| Ok(write_mesh(w, vertices, &mesh.triangles)?))?;
        folder.add("report.html", |w| Ok(w.write_all(report::render(&self.report(&config)).as_bytes())?))?;
        folder.publish()
    }

    fn write_steps(&self, mut writer: impl Write) -> Result<(), Failure> {
        let is_pose_wrong = self.config.noise.is_pose_wrong();
        let ways = ways_so_far(&self.scan.steps);
        for (i, (step, [way_m, move_time_s])) in self.scan.steps.iter().zip(ways).enumerate() {
            let Measured { truth, accuracy } = step.measures;
            let surface_coverage = |i: usize| truth.map(|truth| truth.surface_coverage[i]);
            let line = StepLine {
                report: StepReport { registration: None, ..step.report },
                registration: step.report.registration.map(RegistrationLine::from),
                misplaced_mm: truth
                    .and_then(|truth| truth.misplacement)
                    .filter(|_| is_pose_wrong)
                    .map(|m| 1e3 * m),
                voxel_coverage: truth.map(|truth| truth.voxels.coverage()),
                false_voxels: truth.map(|truth| truth.voxels.n_false),
                surface_coverage_1mm: surface_coverage(0),
                surface_coverage_2mm: surface_coverage(1),
                surface_coverage_5mm: surface_coverage(2),
                reachable_coverage: self.outcome.reachable_coverage_curve.as_ref().map(|curve| curve[i]),
                frame: self.outcome.recorded.as_ref().map(|recorded| recorded.frames[i].as_str()),
                accuracy: accuracy.map(AccuracyMm::from),
                path_length_m: step.path_length,
                way_m,
                move_time_s,
                plan_time_ms: milliseconds(step.plan_time),
                map_time_ms: milliseconds(step.map_time),
            };
            serde_json::to_writer(&mut writer, &line).map_err(Failure::data)?;
            writeln!(writer)?;
        }
        Ok(())
    }

    fn write_views(&self, mut writer: impl Write) -> Result<(), Failure> {
        writeln!(writer, "step,view,x_m,y_m,z_m,qx,qy,qz,qw")?;
        for StepReport { step, view, world_from_camera, .. } in self.scan.steps.iter().map(|step| step.report)
        {
            let view = view.map(|view| view.to_string()).unwrap_or_default();
            writeln!(writer, "{step},{view},{}", numbers(&world_from_camera))?;
        }
        Ok(())
    }

    /// The way to each view, from the view before, with times since the camera set off there.
    fn write_waypoints(&self, mut writer: impl Write) -> Result<(), Failure> {
        writeln!(writer, "step,time_s,x_m,y_m,z_m,qx,qy,qz,qw")?;
        for step in &self.scan.steps {
            for Waypoint { time, world_from_camera } in step.way.waypoints() {
                writeln!(writer, "{},{time},{}", step.report.step, numbers(world_from_camera))?;
            }
        }
        Ok(())
    }

    fn report(&self, config: &str) -> ScanReport {
        let outcome = self.outcome;
        let mut known = FxHashSet::default();
        let mut path_before = 0.0;
        let steps = self.scan.steps.iter().enumerate().map(|(i, step)| {
            let travel = step.path_length - std::mem::replace(&mut path_before, step.path_length);
            let cell = |point: &DVec3| (*point / self.scan.detail()).floor().as_ivec3();
            let points = step.frame.points_in(self.scan.bounds);
            report::Step {
                view: step.report.view,
                world_from_camera: step.report.world_from_camera,
                depth: step.frame.image().clone(),
                points: points
                    .filter(|point| known.insert(cell(point)))
                    .map(|point| point.as_vec3())
                    .collect(),
                coverage: outcome.reachable_coverage_curve.as_ref().map(|curve| curve[i]),
                new_voxels: step.report.update.n_newly_occupied,
                choice: step.report.choice,
                outlook: step.report.outlook,
                plan_time: step.plan_time.as_secs_f64(),
                travel,
                path: way_points(&step.way),
            }
        });
        ScanReport {
            steps: steps.collect(),
            object: outcome.object.clone(),
            planner: outcome.planner.to_string(),
            profile: outcome.profile.to_string(),
            seed: outcome.seed,
            stop_reason: stop_phrase(outcome.stop_reason).to_owned(),
            summary: outcome.summary(),
            random: outcome.baselines.as_ref().map(|b| report::RandomCurve {
                mean: b.random.mean.clone(),
                low: b.random.low.clone(),
                high: b.random.high.clone(),
                band: "5th to 95th percentile of 200 sequences".to_owned(),
            }),
            clairvoyant: outcome.baselines.as_ref().map(|b| b.clairvoyant.clone()),
            candidates: self.scan.session.views().poses().iter().map(|pose| pose.translation()).collect(),
            camera: self.config.camera,
            command: "nextview scan --config config.toml".to_owned(),
            config: config.to_owned(),
        }
    }
}

/// Position and quaternion, with commas.
fn numbers(world_from_camera: &Pose) -> String {
    let (t, q) = (world_from_camera.translation(), world_from_camera.rotation());
    format!("{},{},{},{},{},{},{}", t.x, t.y, t.z, q.x, q.y, q.z, q.w)
}

/// Where the way goes; nothing if it goes nowhere.
fn way_points(way: &Way) -> Vec<DVec3> {
    let points = way.waypoints().iter().map(|point| point.world_from_camera.translation());
    if way.length() > 0.0 { points.collect() } else { Vec::new() }
}

/// One line of `steps.jsonl`.
#[derive(Serialize)]
struct StepLine<'a> {
    /// Without its registration, which is told in the file's units.
    #[serde(flatten)]
    report: StepReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    registration: Option<RegistrationLine>,
    /// Of a camera whose poses are wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    misplaced_mm: Option<f64>,
    voxel_coverage: Option<f64>,
    false_voxels: Option<usize>,
    surface_coverage_1mm: Option<f64>,
    surface_coverage_2mm: Option<f64>,
    surface_coverage_5mm: Option<f64>,
    reachable_coverage: Option<f64>,
    /// Of recordings only, as the accuracy.
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<&'a str>,
    #[serde(flatten)]
    accuracy: Option<AccuracyMm>,
    path_length_m: f64,
    /// Of all ways so far.
    way_m: f64,
    move_time_s: f64,
    plan_time_ms: f64,
    map_time_ms: f64,
}
