//! The files of a scan's results.

use crate::files::ResultFolder;
use crate::run::FinishedScan;
use crate::{Fault, FinalModel, ScanConfig, ScanRecord};
use nextview::geometry::Pose;
use nextview::motion::Waypoint;
use nextview::surface::{write_cloud, write_mesh};
use std::io::Write;

/// Adds everything that a scan leaves, but for pages that show it: configuration, record, poses, waypoints,
/// map, model.
pub fn write_results(
    folder: &mut ResultFolder,
    config: &ScanConfig,
    scan: &FinishedScan<'_>,
    record: &ScanRecord,
    model: &FinalModel,
) -> Result<(), Fault> {
    let text = toml::to_string(config).map_err(Fault::data)?;
    folder.add("config.toml", |w| Ok(w.write_all(text.as_bytes())?))?;
    folder.add("record.json", |w| write_json(w, record))?;
    folder.add("steps.jsonl", |w| record.steps.iter().try_for_each(|step| write_json(w, step)))?;
    folder.add("views.csv", |w| write_views(w, record))?;
    folder.add("waypoints.csv", |w| write_waypoints(w, scan))?;
    let octree = scan.session.map().to_octree()?.pruned();
    folder.add("map.ot", |w| Ok(octree.write_ot(w)?))?;
    folder.add("map.bt", |w| Ok(octree.write_bt(w)?))?;
    folder.add("cloud.ply", |w| Ok(write_cloud(w, &model.cloud)?))?;
    folder.add("mesh.ply", |w| Ok(write_mesh(w, &model.vertices, &model.mesh.triangles)?))
}

/// One JSON object on a line.
fn write_json(writer: &mut Vec<u8>, value: &impl serde::Serialize) -> Result<(), Fault> {
    serde_json::to_writer(&mut *writer, value).map_err(Fault::data)?;
    writer.push(b'\n');
    Ok(())
}

fn write_views(writer: &mut Vec<u8>, record: &ScanRecord) -> Result<(), Fault> {
    writeln!(writer, "step,view,x_m,y_m,z_m,qx,qy,qz,qw")?;
    for step in &record.steps {
        let view = step.view.map(|view| view.to_string()).unwrap_or_default();
        let ([x, y, z], [qx, qy, qz, qw]) = (step.position_m, step.quaternion_xyzw);
        writeln!(writer, "{},{view},{x},{y},{z},{qx},{qy},{qz},{qw}", step.step)?;
    }
    Ok(())
}

/// The trajectory to each view, from the view before, with times since the camera set off there.
fn write_waypoints(writer: &mut Vec<u8>, scan: &FinishedScan<'_>) -> Result<(), Fault> {
    writeln!(writer, "step,time_s,x_m,y_m,z_m,qx,qy,qz,qw")?;
    for (step, trajectory) in scan.steps.iter().zip(&scan.trajectories) {
        for Waypoint { time, world_from_camera } in trajectory.waypoints() {
            writeln!(writer, "{},{time},{}", step.step, numbers(world_from_camera))?;
        }
    }
    Ok(())
}

/// Position and quaternion, with commas.
fn numbers(world_from_camera: &Pose) -> String {
    let (t, q) = (world_from_camera.translation(), world_from_camera.rotation());
    format!("{},{},{},{},{},{},{}", t.x, t.y, t.z, q.x, q.y, q.z, q.w)
}
