//! Forward kinematics for other programs: `kinematics ARM [TIP_LINK]`, where ARM is a preset or a URDF file.
//! Reads the values of all joints from each line of stdin, in radians or metres, and writes the pose of the
//! flange as a line of JSON.

use nextview_robot::Arm;
use nextview_robot::urdf::UrdfOptions;
use std::error::Error;
use std::io::{BufRead, Write, stdin, stdout};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [arm, tip_link @ ..] = &arguments[..] else { return Err("kinematics ARM [TIP_LINK]".into()) };
    let arm = match Arm::preset(arm) {
        Ok(arm) => arm,
        Err(_) => {
            // Kinematics alone: meshes take up no space.
            let tip_link = tip_link.first().map(String::as_str);
            let options = UrdfOptions { tip_link, load_mesh: &|_| Ok(Vec::new()), ..UrdfOptions::default() };
            Arm::from_urdf(&std::fs::read_to_string(arm)?, &options)?
        }
    };
    let mut out = stdout().lock();
    for line in stdin().lock().lines() {
        let line = line?;
        let values = line.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        if values.len() != arm.n_joints() {
            return Err(format!("{line:?} has {} values, expected {}", values.len(), arm.n_joints()).into());
        }
        writeln!(out, "{}", serde_json::to_string(&arm.forward(&values))?)?;
    }
    Ok(())
}
