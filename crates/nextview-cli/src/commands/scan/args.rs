use super::run::{Output, begin, begin_and_turn, resume};
use crate::Failure;
use crate::commands::values::{self, named};
use clap::{Args, ValueEnum};
use glam::DVec3;
use nextview::registration::RegistrationMode;
use nextview::sensor::CameraAxes;
use nextview_recording::PoseDirection;
use nextview_scan::files::Overwrite;
use nextview_scan::{
    BoxRule, NoiseModel, PlannerName, Profile, ScanConfig, SensorName, SourceConfig, TableRule, UnitName,
    ViewSpaceName, result_folder,
};
use std::path::PathBuf;

/// Scan an object from the first view to the last, and write map, cloud, mesh and report.
///
/// A simulated depth camera looks at a mesh; the planner knows only the box around it (or not even that) and
/// the depth images. Because the true object is known, the scan is measured: against random views (skill 0)
/// and against a clairvoyant planner that knows the object (skill 1).
///
/// Every frame is saved to disk before it counts: --resume resumes a scan after any interruption.
///
/// With --frames, recorded depth images replace the camera: the candidates are the recorded poses, and the
/// box grows from the first image unless --box-m states it. The scan is measured if --truth names the true
/// object's mesh.
#[derive(Debug, Default, PartialEq, Args)]
#[command(after_help = EXAMPLES)]
pub struct ScanArgs {
    /// A mesh file (.ply, .obj, .stl, .off, .gltf, .glb) or builtin:NAME (teapot, mug, bracket, torus-knot,
    /// random-N such as random-17) [default: builtin:teapot]
    #[arg(value_parser = values::file_name())]
    model: Option<String>,
    /// Recorded frames instead of a simulation: a folder with poses.csv, intrinsics.txt and depth/, one of
    /// TUM RGB-D, or an .mcap file of ROS 2
    #[arg(long, value_name = "PATH", value_parser = values::file_name(), conflicts_with_all = ["model", "candidates", "view_space", "object_box", "noise", "pose_error_mm", "pose_error_deg", "size_m"])]
    frames: Option<String>,
    #[command(flatten)]
    recording: RecordingArgs,
    /// Planner that chooses the next view [default: most-surface; profile paper: max-flow]
    #[arg(long, value_parser = named::<PlannerName>())]
    planner: Option<PlannerName>,
    /// Penalty on long moves, 0 to 1: the weight of the movement cost, the paper's theta [default: 0]
    #[arg(long, value_name = "T", value_parser = values::share, allow_negative_numbers = true)]
    theta: Option<f64>,
    /// Choose the view with the most surface per second of moving and measuring, instead of per view; only
    /// for most-surface
    #[arg(long, conflicts_with = "theta")]
    per_second: bool,
    /// Maximum number of views [default: 10, or all candidates if there are fewer]
    #[arg(long, value_name = "N", value_parser = values::count, allow_negative_numbers = true)]
    views: Option<usize>,
    /// Stop when the planner estimates that this share, 0 to 1, of the visible surface has been seen
    #[arg(long, value_name = "SHARE", value_parser = values::share, allow_negative_numbers = true)]
    complete: Option<f64>,
    /// Results of an earlier scan of the same object, which has been turned since: its frames are added to
    /// map and model as soon as the turn is found. In a simulation, the object is turned as those results
    /// request
    #[arg(long, value_name = "DIR", value_parser = values::file_name(), conflicts_with = "flips")]
    after: Option<String>,
    /// How often to turn the object once everything visible in its current position has been seen: 0 or 1.
    /// The scan before the turn is saved in OUT-placement-1 [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=1), conflicts_with = "frames")]
    flips: Option<u8>,
    /// Maximum length of the path through the views, in metres
    #[arg(long, value_name = "M", value_parser = values::positive, allow_negative_numbers = true)]
    max_path_m: Option<f64>,
    /// Stop after this time, in seconds, when the current view is done; the result then depends on the speed
    /// of the machine
    #[arg(long, value_name = "S", value_parser = values::not_negative, allow_negative_numbers = true)]
    max_time_s: Option<f64>,
    /// Number of view candidates [default: 1000; profile paper: 5000]
    #[arg(long, value_name = "N", value_parser = values::count, allow_negative_numbers = true)]
    candidates: Option<usize>,
    /// Number of the first view among the candidates, from 0; with --frames, its index among the usable
    /// frames, regardless of their numbers [default: 0]
    #[arg(long, value_name = "I", value_parser = values::count, allow_negative_numbers = true)]
    first_view: Option<usize>,
    /// Edge of a voxel in metres [default: about a fortieth of the object, 0.005 for recordings whose box
    /// grows; profile paper: 0.01]
    #[arg(long, value_name = "M", value_parser = values::positive, allow_negative_numbers = true)]
    voxel_size_m: Option<f64>,
    /// Whether planning begins in coarse voxels and halves them as the map becomes known [default: off]
    #[arg(long, value_enum, value_name = "on|off", hide_possible_values = true)]
    multi_resolution: Option<Switch>,
    /// Box around the object [default: known]
    #[arg(long = "box", value_parser = named::<BoxRule>())]
    object_box: Option<BoxRule>,
    /// If the box grows: how far apart parts of the object may be, in metres [default: 0, they touch]
    #[arg(long, value_name = "M", value_parser = values::not_negative, allow_negative_numbers = true)]
    max_gap_m: Option<f64>,
    /// Table that the object stands on [default: none]
    #[arg(long, value_parser = named::<TableRule>())]
    table: Option<TableRule>,
    /// Depth camera, which decides optics, range and noise: d405, d415, d435, d435i, d455, l515,
    /// azure-kinect, femto-bolt, gemini-335, zivid-2-m60, phoxi-s, phoxi-m, or a .toml file that states how
    /// it differs from one of them [default: optics of the D435i, no limits and no noise]. With --frames, it
    /// states only the error of the depth, which --goal-mm needs
    #[arg(long, value_name = "NAME|FILE", value_parser = values::file_name())]
    sensor: Option<String>,
    /// Errors and losses of the camera's depth [default: none, or those of --sensor]
    #[arg(long, value_parser = named::<NoiseModel>())]
    noise: Option<NoiseModel>,
    /// Standard deviation of the position error of each image's pose, along each axis, in millimetres
    /// [default: 0]
    #[arg(long, value_name = "MM", value_parser = values::not_negative, allow_negative_numbers = true)]
    pose_error_mm: Option<f64>,
    /// Standard deviation of the rotation error of each image's pose, about each axis, in degrees [default:
    /// 0]
    #[arg(long, value_name = "DEG", value_parser = values::not_negative, allow_negative_numbers = true)]
    pose_error_deg: Option<f64>,
    /// Whether to align each image to the surface measured before, which corrects wrong poses; with auto, as
    /// soon as the poses disagree [default: auto with --frames, else off]
    #[arg(long, value_parser = ["on", "off", "auto"], value_name = "on|off|auto", hide_possible_values = true)]
    register: Option<String>,
    /// Minimum share, 0 to 1, of known surface in the next view, so that its image can be aligned [default:
    /// 0.5 with registration, else 0]
    #[arg(long, value_name = "SHARE", value_parser = values::share, allow_negative_numbers = true)]
    min_overlap: Option<f64>,
    /// Required accuracy of the surface: its expected error, a standard deviation in millimetres; until it is
    /// reached, views are spent on second looks [default: no second looks]
    #[arg(long, value_name = "MM", value_parser = values::positive, allow_negative_numbers = true)]
    goal_mm: Option<f64>,
    /// Required number of looks at each part of the surface; until it is reached, views are spent on second
    /// looks [default: no second looks]
    #[arg(long, value_name = "N", value_parser = values::count, allow_negative_numbers = true)]
    looks: Option<usize>,
    /// CAD model of the part, for the planner inspection
    #[arg(long, value_name = "MESH", value_parser = values::file_name())]
    reference: Option<String>,
    /// Whether to close the mesh where nothing was measured, for 3D printing; its column `filled` marks these
    /// vertices [default: off]
    #[arg(long, value_enum, value_name = "on|off", hide_possible_values = true)]
    watertight: Option<Switch>,
    /// View candidates: shell (the paper's), sphere, hemisphere, ring (a turntable), or a CSV file of poses
    /// [default: shell]
    #[arg(long, value_name = "RULE|FILE", value_parser = values::file_name())]
    view_space: Option<String>,
    /// Base of a robot and its reach, in metres; candidates out of reach are dropped [default: everywhere]
    #[arg(long, value_name = "X,Y,Z,R", value_parser = values::sphere, allow_hyphen_values = true)]
    reach: Option<[f64; 4]>,
    #[command(flatten)]
    robot: RobotArgs,
    /// Seed of the random shell and the planners random and receding-horizon [default: 0]
    #[arg(long, value_name = "S", value_parser = values::seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Named set of defaults [default: default]
    #[arg(long, value_parser = named::<Profile>())]
    profile: Option<Profile>,
    /// Unit of the mesh file [default: auto]
    #[arg(long, value_parser = named::<UnitName>())]
    unit: Option<UnitName>,
    /// Scale the object so that its longest side has this length in metres
    #[arg(long, value_name = "M", value_parser = values::positive, allow_negative_numbers = true)]
    size_m: Option<f64>,
    /// Whether to compute the random and clairvoyant curves and the skill, if the ground truth is known
    /// [default: on]
    #[arg(long, value_enum, value_name = "on|off", hide_possible_values = true)]
    baselines: Option<Switch>,
    /// Configuration to start from, such as the config.toml of an earlier scan; options given here override
    /// it
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// Folder for the results [default: scan-OBJECT-PLANNER, followed by -2, -3, ... if that holds results]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace existing results in the folder; the scan's input files are never replaced
    #[arg(long)]
    force: bool,
    /// Resume the interrupted scan in this folder; only --json can be combined with it
    #[arg(long, value_name = "DIR")]
    resume: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// The arm that holds the camera.
#[derive(Debug, Default, PartialEq, Args)]
struct RobotArgs {
    /// Arm that holds the camera: ur3e, ur5e, ur10e, kr6_r900, lr_mate_200id, panda, or a URDF file; only
    /// views that it reaches without collision are taken [default: none]
    #[arg(long = "robot", value_name = "NAME|URDF", value_parser = values::file_name())]
    arm: Option<String>,
    /// With --robot: where its base stands, upright, in metres [default: 0,0,0]
    #[arg(long = "robot-base", value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true)]
    base: Option<DVec3>,
    /// With --robot: file with the 4 x 4 matrix, row by row and in metres, that transforms points from the
    /// camera to the flange [default: no offset]
    #[arg(long, value_name = "FILE")]
    hand_eye: Option<PathBuf>,
}

/// What only recordings need.
#[derive(Debug, Default, PartialEq, Args)]
struct RecordingArgs {
    /// With --frames: prefix of the pose columns in poses.csv [default: world_from_camera, or the only set]
    #[arg(long, value_name = "NAME")]
    pose_columns: Option<String>,
    /// With --frames: where the axes of the recorded cameras point: opencv (x right, y down, z forward),
    /// opengl (x right, y up, z backward), or ros (x forward, y left, z up) [default: opencv]
    #[arg(long, value_name = "AXES", value_parser = values::word::<CameraAxes>)]
    camera_axes: Option<CameraAxes>,
    /// With --frames: direction of the recorded poses, world-from-camera or camera-from-world [default:
    /// world-from-camera]
    #[arg(long, value_name = "DIRECTION", value_parser = values::word::<PoseDirection>)]
    poses: Option<PoseDirection>,
    /// With --frames: the box around the object, in metres, as its lowest and its highest corner [default: it
    /// grows]
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = values::corners, allow_hyphen_values = true)]
    box_m: Option<[f64; 6]>,
    /// With --frames: height of the table that the object stands on, z in metres; anything below it, or less
    /// than 2 mm above it, does not belong to the object [default: no table]
    #[arg(long, value_name = "Z", value_parser = values::number, allow_negative_numbers = true)]
    table_z_m: Option<f64>,
    /// With --frames: mesh of the true object, to evaluate the scan
    #[arg(long, value_name = "MESH", value_parser = values::file_name())]
    truth: Option<String>,
    /// With --truth: file with the 4 x 4 matrix, row by row and in metres, that transforms points from the
    /// recording to the mesh
    #[arg(long, value_name = "FILE", value_parser = values::file_name())]
    truth_from_world: Option<String>,
}

const EXAMPLES: &str = "\
Examples:
  nextview scan                                             the built-in teapot
  nextview scan part.stl --unit mm --views 15 --out part    your own mesh
  nextview scan bunny.ply --profile paper --json            the paper's protocol, as JSON
  nextview scan --config part/config.toml                   the same scan again
  nextview scan --frames recorded/ --truth part.stl         recorded frames, measured
  nextview scan --resume part                               resume after an interruption

The folder holds config.toml (everything that determines the scan), record.json (all measures),
steps.jsonl (a line per view), views.csv (poses), waypoints.csv (trajectories between them), map.ot
and map.bt (OctoMap), cloud.ply, mesh.ply and report.html.";

/// On or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

impl ScanArgs {
    pub fn run(self) -> Result<(), Failure> {
        match &self.resume {
            None => self.scan(),
            Some(dir) => {
                let alone = Self { resume: self.resume.clone(), json: self.json, ..Self::default() };
                if self != alone {
                    return Err(Failure::usage(
                        "--resume continues a scan with its own settings; only --json can be combined with it",
                    ));
                }
                // The folder belonged to the scan when it began.
                let rule = Overwrite::results();
                resume(Output { dir: dir.clone(), is_named: true, rule, config: None, json: self.json })
            }
        }
    }

    fn scan(self) -> Result<(), Failure> {
        let mut config = self.configuration()?;
        if self.model.is_some() && config.source.recording().is_some() {
            config.source = SourceConfig::Simulated;
        }
        set(&mut config.object, self.model.or(self.frames.clone()));
        self.recording.set(&mut config, self.frames.is_some())?;
        set(&mut config.planner, self.planner.map(Into::into));
        set(&mut config.most_surface.per_second, self.per_second.then_some(true));
        self.theta.into_iter().for_each(|theta| config.set_theta(theta));
        config.views = self.views.or(config.views);
        set(&mut config.candidates, self.candidates);
        set(&mut config.first_view, self.first_view);
        set(&mut config.view_space, self.view_space.map(ViewSpaceName));
        self.reach.into_iter().for_each(|sphere| config.reach.set_sphere(sphere));
        self.robot.set(&mut config)?;
        set(&mut config.seed, self.seed);
        set(&mut config.unit, self.unit);
        set(&mut config.multi_resolution.enabled, self.multi_resolution.map(|switch| switch == Switch::On));
        set(&mut config.object_box.rule, self.object_box);
        set(&mut config.object_box.max_gap_m, self.max_gap_m);
        set(&mut config.object_box.table, self.table);
        self.sensor.map_or(Ok(()), |name| config.set_sensor(SensorName(name)))?;
        set(&mut config.noise.model, self.noise);
        set(&mut config.noise.pose_error_mm, self.pose_error_mm);
        set(&mut config.noise.pose_error_deg, self.pose_error_deg);
        config.registration.enabled = match self.register.as_deref() {
            Some("on") => Some(RegistrationMode::On),
            Some("off") => Some(RegistrationMode::Off),
            Some(_) => Some(RegistrationMode::Auto),
            None => config.registration.enabled,
        };
        set(&mut config.model.watertight, self.watertight.map(|switch| switch == Switch::On));
        config.min_overlap = self.min_overlap.or(config.min_overlap);
        config.goal_mm = self.goal_mm.or(config.goal_mm);
        self.looks.into_iter().for_each(|n| config.looks.get_or_insert_default().n = n);
        self.reference.into_iter().for_each(|mesh| config.set_reference(mesh.into()));
        set(&mut config.baselines, self.baselines.map(|switch| switch == Switch::On));
        config.stop.completeness = self.complete.or(config.stop.completeness);
        config.stop.path_length = self.max_path_m.or(config.stop.path_length);
        config.time_limit_s = self.max_time_s.or(config.time_limit_s);
        config.voxel_size_m = self.voxel_size_m.or(config.voxel_size_m);
        config.size_m = self.size_m.or(config.size_m);
        config.after = self.after.map(PathBuf::from).or(config.after);
        config.check_with_files()?;
        let rule = Overwrite::forced(self.force);
        let is_named = self.out.is_some();
        let dir = self.out.unwrap_or_else(|| result_folder(&config, &rule));
        let output = Output { dir, is_named, rule, config: self.config, json: self.json };
        match self.flips {
            Some(1) => begin_and_turn(config, output),
            _ => begin(config, output),
        }
    }

    /// Returns the base configuration: that of a file, or of a profile.
    fn configuration(&self) -> Result<ScanConfig, Failure> {
        let Some(path) = &self.config else {
            return Ok(ScanConfig::of_profile(self.profile.unwrap_or_default()));
        };
        Ok(ScanConfig::load(path, self.profile)?)
    }
}

impl RobotArgs {
    /// Overrides the robot of the configuration. Fails if there is none.
    fn set(self, config: &mut ScanConfig) -> Result<(), Failure> {
        if self == Self::default() {
            return Ok(());
        }
        if self.arm.is_none() && config.robot.is_none() {
            return Err(Failure::usage("--robot-base and --hand-eye need --robot"));
        }
        let robot = config.robot.get_or_insert_default();
        set(&mut robot.arm, self.arm);
        self.base.map_or(Ok(()), |base| robot.set_base(base))?;
        Ok(self.hand_eye.map_or(Ok(()), |file| robot.read_hand_eye(&file))?)
    }
}

impl RecordingArgs {
    /// Overrides the recording of the configuration. Fails if there is none.
    fn set(self, config: &mut ScanConfig, is_recorded: bool) -> Result<(), Failure> {
        let options = [
            ("pose-columns", self.pose_columns.is_some()),
            ("camera-axes", self.camera_axes.is_some()),
            ("poses", self.poses.is_some()),
            ("box-m", self.box_m.is_some()),
            ("table-z-m", self.table_z_m.is_some()),
            ("truth", self.truth.is_some()),
            ("truth-from-world", self.truth_from_world.is_some()),
        ];
        if !is_recorded && config.source.recording().is_none() {
            let given = options.into_iter().find(|(_, is_given)| *is_given);
            return given.map_or(Ok(()), |(name, _)| Err(Failure::usage(format!("--{name} needs --frames"))));
        }
        let recording = config.source.to_recording()?;
        recording.box_m = self.box_m.or(recording.box_m);
        recording.table_z_m = self.table_z_m.or(recording.table_z_m);
        recording.truth = self.truth.or(recording.truth.take());
        recording.truth_from_world = self.truth_from_world.or(recording.truth_from_world.take());
        recording.read.pose_columns = self.pose_columns.or(recording.read.pose_columns.take());
        set(&mut recording.read.camera_axes, self.camera_axes);
        set(&mut recording.read.poses, self.poses);
        Ok(())
    }
}

/// Overrides a value of the configuration if the option was given.
fn set<T>(field: &mut T, given: Option<T>) {
    if let Some(value) = given {
        *field = value;
    }
}
