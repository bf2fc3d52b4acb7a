//! The program `nextview-ros2`: a ROS 2 node that scans with any depth camera. It subscribes to images and
//! transforms, and publishes next views, maps and clouds. All decisions are made by
//! [`nextview_scan::LiveScan`].
//!
//! `docs/ros2.md` describes its topics, services and parameters.

mod camera;
mod connections;
mod messages;
mod names;
mod node;
mod notes;
mod parameters;
mod scan;
mod status;

use nextview_scan::process;
use parameters::{Parameters, RosArguments};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = RosArguments::parse(std::env::args().skip(1));
    let started = arguments.and_then(|arguments| {
        let parameters = Parameters::new(&arguments)?;
        Ok((arguments, parameters))
    });
    let (arguments, parameters) = match started {
        Ok(started) => started,
        Err(problem) => {
            eprintln!("{problem}");
            return ExitCode::from(2);
        }
    };
    let limited = process::limit_is_an_error().map_err(|error| error.to_string());
    match limited.and_then(|()| node::run(&arguments.names, parameters)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::FAILURE
        }
    }
}
