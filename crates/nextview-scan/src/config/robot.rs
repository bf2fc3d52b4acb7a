use crate::{Fault, files};
use glam::{DQuat, DVec3};
use nextview::geometry::{Aabb, Plane, Pose};
use nextview_recording::read_transform;
use nextview_robot::collision::{Attachment, Obstacle, ObstacleKind, touching_links};
use nextview_robot::presets;
use nextview_robot::{Arm, Mount, RobotCell, Shape, ShapeKind, UrdfOptions};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The arm that moves the camera, or the object in front of a fixed camera. Views out of its reach are no
/// candidates. Every view comes with a collision-free joint trajectory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct RobotConfig {
    /// The name of a common arm, or a URDF file.
    pub arm: String,
    /// The URDF link where the arm begins. Default: the root.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_link: Option<String>,
    /// The URDF link of the flange. Default: the last one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip_link: Option<String>,
    /// Pose of the arm's base. Default: at the origin of the world.
    pub world_from_base: Pose,
    /// The hand-eye matrix: pose of the camera on the flange. Default: identity.
    pub flange_from_camera: Pose,
    /// Pose of a fixed camera while the flange carries the object. Requires `flange_from_world` and replaces
    /// the two poses above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_from_camera: Option<Pose>,
    /// Pose of the world on the flange that carries the object: the world is fixed to the object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flange_from_world: Option<Pose>,
    /// The joint values before the first view, in radians or metres. By default, the arm starts at the first
    /// view.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub home: Vec<f64>,
    /// The camera's body, given by its lowest and highest corners in the camera frame. Default: that of a
    /// RealSense D435i, 90 x 25 x 25 mm behind its glass.
    pub camera_body_m: [f64; 6],
    /// Height, in the frame of the base, of a table to avoid, in addition to the object's table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_z_m: Option<f64>,
    /// Boxes to avoid in the frame of the base, given by their lowest and highest corners.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub boxes_m: Vec<[f64; 6]>,
    /// Minimum distance to everything around the arm, 0.001 to 1.
    pub clearance_m: f64,
}

/// Maximum size of a URDF file in bytes.
const MOST_BYTES: u64 = 10_000_000;

impl Default for RobotConfig {
    fn default() -> Self {
        Self {
            arm: "ur5e".to_owned(),
            base_link: None,
            tip_link: None,
            world_from_base: Pose::IDENTITY,
            flange_from_camera: Pose::IDENTITY,
            base_from_camera: None,
            flange_from_world: None,
            home: Vec::new(),
            camera_body_m: [-0.045, -0.0125, -0.025, 0.045, 0.0125, 0.0],
            table_z_m: None,
            boxes_m: Vec::new(),
            clearance_m: 0.01,
        }
    }
}

impl RobotConfig {
    /// Places the base here, upright and facing along x.
    pub fn set_base(&mut self, position: DVec3) -> Result<(), Fault> {
        let pose = Pose::new(DQuat::IDENTITY, position);
        self.world_from_base = pose.map_err(|error| Fault::from(error).within("robot.world_from_base"))?;
        Ok(())
    }

    /// Reads `flange_from_camera`: 4 lines of 4 numbers.
    pub fn read_hand_eye(&mut self, path: &Path) -> Result<(), Fault> {
        self.flange_from_camera = read_transform(path)?;
        Ok(())
    }

    /// The URDF file; `None` for a preset.
    pub fn file(&self) -> Option<&Path> {
        (!presets::NAMES.contains(&self.arm.as_str())).then(|| Path::new(&self.arm))
    }

    /// All faults; those of the arm itself only if there are no others, and only if it is a preset.
    pub(crate) fn faults(&self) -> Vec<Fault> {
        let faults = self.faults_beside_arm();
        if !faults.is_empty() || self.file().is_some() {
            return faults;
        }
        self.cell().err().into_iter().collect()
    }

    /// The fault of an arm that is read from a file, if there are no others.
    pub(crate) fn fault_of_file(&self) -> Option<Fault> {
        self.file().filter(|_| self.faults_beside_arm().is_empty())?;
        self.cell().err()
    }

    fn faults_beside_arm(&self) -> Vec<Fault> {
        let boxes = self.boxes_m.iter().map(|corners| solid("robot.boxes_m", corners));
        let body = solid("robot.camera_body_m", &self.camera_body_m);
        let solids = boxes.chain([body]).filter_map(Result::err);
        solids.chain(self.mount().err()).collect()
    }

    /// Builds the arm in its surroundings. Fails on the first invalid value.
    pub fn cell(&self) -> Result<RobotCell, Fault> {
        let arm = self.arm()?;
        if !self.home.is_empty() && (self.home.len() != arm.n_joints() || !arm.is_within_limits(&self.home)) {
            let limits = arm.joints.iter().map(|joint| {
                let limits = joint.limits;
                format!("{} in {:.3} to {:.3}", joint.name, limits.lower, limits.upper)
            });
            let expected = limits.collect::<Vec<_>>().join(", ");
            return Err(Fault::of_value("robot.home", format!("{:?}", self.home), expected));
        }
        let mut obstacles: Vec<Obstacle> =
            self.boxes_m.iter().enumerate().map(box_obstacle).collect::<Result<_, _>>()?;
        if let Some(z) = self.table_z_m {
            let plane = Plane::horizontal(z).map_err(|error| Fault::from(error).within("robot.table_z_m"))?;
            obstacles.push(Obstacle { name: "table".to_owned(), kind: ObstacleKind::Below(plane) });
        }
        let body = solid("robot.camera_body_m", &self.camera_body_m)?;
        let (mount, attached) = match self.mount()? {
            mount @ Mount::Camera { flange_from_camera, .. } => {
                let shape =
                    Shape { link_from_shape: flange_from_camera * body.link_from_shape, kind: body.kind };
                (mount, vec![Attachment { name: "camera".to_owned(), shapes: vec![shape] }])
            }
            mount @ Mount::Object { base_from_camera, .. } => {
                let base_from_shape = base_from_camera * body.link_from_shape;
                let kind = ObstacleKind::Solid { base_from_shape, kind: body.kind };
                obstacles.push(Obstacle { name: "camera".to_owned(), kind });
                (mount, Vec::new())
            }
        };
        RobotCell::new(arm, mount, attached, obstacles, self.clearance_m)
            .map_err(|error| Fault { key: Some("robot".to_owned()), ..Fault::request(error) })
    }

    /// Fails if the base is inside the object, as happens if its position was not stated.
    pub(crate) fn check_beside(&self, object: &Aabb) -> Result<(), Fault> {
        let place = self.world_from_base.translation();
        if self.base_from_camera.is_some() || !object.contains(place) {
            return Ok(());
        }
        let (min, max) = (object.min, object.max);
        let expected = format!("a place outside the object's box, {min:.3} to {max:.3} m");
        Err(Fault::of_value("robot.world_from_base", format!("{place:.3}"), expected))
    }

    fn mount(&self) -> Result<Mount, Fault> {
        match (self.base_from_camera, self.flange_from_world) {
            (None, None) => Ok(Mount::Camera {
                world_from_base: self.world_from_base,
                flange_from_camera: self.flange_from_camera,
            }),
            (Some(base_from_camera), Some(flange_from_world)) => {
                Ok(Mount::Object { flange_from_world, base_from_camera })
            }
            _ => Err(Fault::request(
                "`robot.base_from_camera` and `robot.flange_from_world` must be given together",
            )),
        }
    }

    fn arm(&self) -> Result<Arm, Fault> {
        let path = Path::new(&self.arm);
        let mut arm = match Arm::preset(&self.arm) {
            Ok(arm) => arm,
            Err(_) => {
                let known = presets::NAMES.join(", ");
                let text = files::read_text(path, MOST_BYTES).map_err(|fault| {
                    fault.with_remedy(format!("`robot.arm` takes a URDF file, or {known}"))
                })?;
                let folder = path.parent().unwrap_or(Path::new(""));
                let load_mesh = |name: &str| mesh_points(folder, name);
                let options = UrdfOptions {
                    base_link: self.base_link.as_deref(),
                    tip_link: self.tip_link.as_deref(),
                    load_mesh: &load_mesh,
                    ..UrdfOptions::default()
                };
                Arm::from_urdf(&text, &options).map_err(|error| Fault::data(error).in_file(path))?
            }
        };
        arm.may_touch = touching_links(&arm).map_err(|error| Fault::data(error).in_file(path))?;
        Ok(arm)
    }
}

/// The points of a mesh that a URDF names by a path from its folder or from a package around it.
#[cfg(feature = "simulated")]
fn mesh_points(folder: &Path, name: &str) -> Result<Vec<DVec3>, String> {
    let in_package =
        name.strip_prefix("package://").map(|rest| rest.split_once('/').map_or(rest, |(_, path)| path));
    let wanted = in_package.unwrap_or(name.strip_prefix("file://").unwrap_or(name));
    let found = folder.ancestors().map(|above| above.join(wanted)).find(|path| path.is_file());
    let path = found.ok_or_else(|| format!("no file {wanted} in the folder of the URDF or above it"))?;
    use nextview_sim::mesh::Unit;
    let mesh = nextview_sim::mesh::load(&path).map_err(|error| error.to_string())?;
    let (mesh, _) = mesh.to_metres(Unit::Metres).map_err(|error| error.to_string())?;
    Ok(mesh.vertices().to_vec())
}

#[cfg(not(feature = "simulated"))]
fn mesh_points(_: &Path, name: &str) -> Result<Vec<DVec3>, String> {
    Err(format!("{name} cannot be read here: nextview was built without the feature `simulated`"))
}

fn box_obstacle((i, corners): (usize, &[f64; 6])) -> Result<Obstacle, Fault> {
    let Shape { link_from_shape, kind } = solid("robot.boxes_m", corners)?;
    let kind = ObstacleKind::Solid { base_from_shape: link_from_shape, kind };
    Ok(Obstacle { name: format!("box {i}"), kind })
}

/// A box given by its lowest and highest corners.
fn solid(key: &str, &[x0, y0, z0, x1, y1, z1]: &[f64; 6]) -> Result<Shape, Fault> {
    let bounds = Aabb { min: DVec3::new(x0, y0, z0), max: DVec3::new(x1, y1, z1) };
    let is_box = bounds.min.is_finite() && bounds.max.is_finite() && bounds.min.cmplt(bounds.max).all();
    if !is_box {
        let value = format!("{} to {}", bounds.min, bounds.max);
        return Err(Fault::of_value(key, value, "finite corners, the lowest first"));
    }
    let middle = Pose::new(DQuat::IDENTITY, bounds.center())?;
    Ok(Shape { link_from_shape: middle, kind: ShapeKind::Box(0.5 * bounds.size()) })
}
