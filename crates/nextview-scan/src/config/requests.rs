//! The keys that an external request may have.

use super::{PlannerName, ScanConfig, ViewRule};
use crate::{Fault, FaultKind, Named};
use nextview::sensor::Sensor;
use nextview_robot::presets;
use toml::{Table, Value};

/// Keys whose values are numbers, booleans or one of a few words: none can name a file.
const HARMLESS: &str = "
baseline_seed baselines candidates first_view goal_mm memory_limit_mb min_overlap profile seed size_m
size_of time_limit_s unit view_distance_m view_seed view_standoff_m views voxel_size_m
batch.least_share batch.n_views batch.ray_spacing batch.theta batch.tolerance
camera.cx camera.cy camera.distortion camera.distortion.brown-conrady
camera.distortion.inverse-brown-conrady camera.fx camera.fy camera.height camera.width
frontier_tour.ray_spacing greedy.ray_spacing greedy.theta kaba.ray_spacing
live.box_m live.first_pose.rotation_xyzw live.first_pose.translation_m live.max_depth_m live.min_depth_m
live.poses.rotation_xyzw live.poses.translation_m live.table_z_m
looks.angle_deg looks.apart_deg looks.n looks.points_per_mm2
map.background map.rays map.sensor_model.clamp_max map.sensor_model.clamp_min map.sensor_model.hit
map.sensor_model.miss
max_flow.free_space max_flow.gamma max_flow.ray_spacing max_flow.theta max_flow.uses_history
model.watertight
most_surface.per_second most_surface.rays_across most_surface.theta
motion.acceleration_m_per_s2 motion.clearance_m motion.sensing_time_s motion.speed_m_per_s
multi_resolution.coarsest_voxel_size_m multi_resolution.enabled multi_resolution.q_thresh
noise.depth.baseline_m noise.depth.correlated_share noise.depth.correlation_px noise.depth.depth_unit_m
noise.depth.disparity_sigma_px noise.depth.disparity_step_px noise.depth.edge_gradient
noise.depth.edge_loss noise.depth.error.constant_m noise.depth.error.linear
noise.depth.error.quadratic_per_m noise.depth.flying_jump noise.depth.flying_share noise.depth.focal_px
noise.depth.grazing_from_rad noise.depth.lateral_sigma_px noise.depth.max_depth_m
noise.depth.min_depth_m noise.first_pose_is_right noise.model noise.pose_error_deg noise.pose_error_mm
noise.seed
object_box.max_gap_m object_box.rule object_box.table
receding_horizon.ray_spacing
reach.allowed_boxes_m reach.base_m reach.forbidden_boxes_m reach.max_radius_m reach.min_radius_m
registration.enabled registration.given_poses registration.min_overlap registration.min_stiffness
registration.position_uncertainty_m registration.rotation_uncertainty_deg registration.spacing_m
robot.base_from_camera.rotation_xyzw robot.base_from_camera.translation_m robot.boxes_m
robot.camera_body_m robot.clearance_m robot.flange_from_camera.rotation_xyzw
robot.flange_from_camera.translation_m robot.flange_from_world.rotation_xyzw
robot.flange_from_world.translation_m robot.home robot.table_z_m robot.world_from_base.rotation_xyzw
robot.world_from_base.translation_m
stop.completeness stop.entropy_share stop.expected_gain stop.path_length_m stop.progress
turntable.plate_radius_m turntable.table_from_camera.rotation_xyzw
turntable.table_from_camera.translation_m
";

/// Keys whose value is a text that names nothing outside the scan.
const TEXTS: [&str; 3] = ["object", "robot.base_link", "robot.tip_link"];

/// All names that a key accepts.
type KeyNames = fn() -> Vec<&'static str>;

/// Keys that accept only these names in a request; in a configuration, they also accept a file or a class.
const NAMES: [(&str, KeyNames); 4] = [
    ("planner", || PlannerName::ALL.iter().map(|planner| planner.name()).collect()),
    ("robot.arm", || presets::NAMES.to_vec()),
    ("sensor", || Sensor::ALL.iter().map(|sensor| sensor.name()).collect()),
    ("view_space", || ViewRule::ALL.iter().map(|rule| rule.name()).collect()),
];

/// Keys and sections that name files.
const OF_FILES: [&str; 4] = ["after", "nbv_net.weights", "recording", "reference"];

impl ScanConfig {
    /// Reports everything that a request must not contain: from the answers, the sender could learn which
    /// files exist here, and their content. A key is refused unless it is declared harmless here. No file is
    /// accessed.
    pub fn faults_of_request(keys: &Table) -> Vec<Fault> {
        let mut faults = Vec::new();
        look("", keys, &mut faults);
        faults
    }
}

/// All keys that a request may have, some only with certain values.
fn declared() -> impl Iterator<Item = &'static str> {
    HARMLESS.split_whitespace().chain(TEXTS).chain(NAMES.map(|(key, _)| key))
}

fn is_within(key: &str, section: &str) -> bool {
    key.strip_prefix(section).is_some_and(|rest| rest.starts_with('.'))
}

fn look(section: &str, keys: &Table, faults: &mut Vec<Fault>) {
    for (word, value) in keys {
        let key = if section.is_empty() { word.clone() } else { format!("{section}.{word}") };
        look_at(&key, value, faults);
    }
}

fn look_at(key: &str, value: &Value, faults: &mut Vec<Fault>) {
    let is_section = || declared().chain(OF_FILES).any(|declared| is_within(declared, key));
    match value {
        _ if OF_FILES.contains(&key) => {
            let fault =
                Fault::request(format!("`{key}` cannot be set in a request: requests do not name files"));
            faults.push(Fault { key: Some(key.to_owned()), ..fault.with_remedy("leave it out") });
        }
        Value::Table(keys) if is_section() => look(key, keys, faults),
        Value::Array(values) if values.iter().any(Value::is_table) => {
            values.iter().for_each(|value| look_at(key, value, faults));
        }
        _ if declared().any(|declared| declared == key) => faults.extend(of_name(key, value)),
        _ if is_section() => faults.push(Fault::of_value(key, value, "a table")),
        _ => faults.push(unknown(key)),
    }
}

/// The fault of a value that is none of the names that its key accepts in a request.
fn of_name(key: &str, value: &Value) -> Option<Fault> {
    let (_, names) = NAMES.iter().find(|(named, _)| *named == key)?;
    let (name, names) = (value.as_str()?, names());
    (!names.contains(&name)).then(|| Fault::of_value(key, name, format!("one of {}", names.join(", "))))
}

/// The fault of an undeclared key: it does not exist or was never declared harmless.
fn unknown(key: &str) -> Fault {
    let (section, word) = key.rsplit_once('.').unwrap_or(("", key));
    let prefix = if section.is_empty() { String::new() } else { format!("{section}.") };
    let known: Vec<&str> = declared().filter_map(|declared| declared.strip_prefix(&prefix)).collect();
    let words = known.iter().map(|rest| rest.split('.').next().unwrap_or(rest));
    Fault { kind: FaultKind::Request, ..Fault::unknown_key(&prefix, word, words) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> Vec<String> {
        let faults = ScanConfig::faults_of_request(&text.parse().unwrap());
        faults.into_iter().map(|fault| fault.message).collect()
    }

    #[test]
    fn keys_that_name_files_or_are_unknown_are_refused() {
        for (text, key) in [
            ("after = \"mug\"", "after"),
            ("recording = {}", "recording"),
            ("[reference]\nmesh = \"/etc/passwd\"", "reference"),
            ("nbv_net.weights = \"/etc/passwd\"", "nbv_net.weights"),
            ("robot.arm = \"/etc/passwd\"", "robot.arm"),
            ("sensor = \"/etc/passwd.toml\"", "sensor"),
            ("view_space = \"/etc/passwd\"", "view_space"),
            ("planner = \"python:os:system\"", "planner"),
            ("voxel_size = 1", "voxel_size"),
            ("live.poses = [{ file = \"/etc/passwd\" }]", "live.poses.file"),
            ("live.file = {}", "live.file"),
            ("secrets = {}", "secrets"),
            ("live = \"/etc/passwd\"", "live"),
        ] {
            let faults = refused(text);
            let is_named =
                ["is", "cannot be"].iter().any(|verb| faults[0].contains(&format!("`{key}` {verb} ")));
            assert!(faults.len() == 1 && is_named, "{text}: {faults:?}");
        }
    }

    #[test]
    fn harmless_keys_pass() {
        let text = "object = \"/etc/passwd\"\nplanner = \"rse\"\nsensor = \"d435i\"\nview_space = \"ring\"\n\
                    nbv_net = {}\nviews = 3\ncamera.distortion.brown-conrady = [0, 0, 0, 0, 0]\n[robot]\n\
                    arm = \"ur5e\"\n[live]\nbox_m = [0, 0, 0, 1, 1, 1]\n\
                    poses = [{ rotation_xyzw = [0, 0, 0, 1], translation_m = [0, 0, 0] }]";
        assert_eq!(refused(text), [""; 0]);
    }

    /// Every key of the schema is declared either as harmless or as one that names files.
    #[cfg(feature = "schema")]
    #[test]
    fn every_key_is_declared() {
        use std::collections::BTreeSet;
        let schema = serde_json::to_value(schemars::schema_for!(ScanConfig)).unwrap();
        let (mut keys, mut texts) = (BTreeSet::new(), BTreeSet::new());
        collect(&schema, &schema, "", &mut keys, &mut texts);
        let of_files = |key: &str| OF_FILES.iter().any(|file| key == *file || is_within(key, file));
        let declared: BTreeSet<String> = declared().map(str::to_owned).collect();
        let open: BTreeSet<String> = keys.iter().filter(|key| !of_files(key)).cloned().collect();
        let missing: Vec<_> = open.difference(&declared).collect();
        assert!(missing.is_empty(), "declare whether a request may have {missing:?}");
        let gone: Vec<_> = declared.difference(&open).collect();
        assert!(gone.is_empty(), "there are no such keys, or they name files: {gone:?}");
        let harmless: BTreeSet<&str> = HARMLESS.split_whitespace().collect();
        let texts: Vec<_> = texts.iter().filter(|key| harmless.contains(key.as_str())).collect();
        assert!(texts.is_empty(), "these take any text, so they may name files: {texts:?}");
    }

    /// Collects the dotted keys of a schema, and those that accept any text.
    #[cfg(feature = "schema")]
    fn collect(
        root: &serde_json::Value,
        schema: &serde_json::Value,
        key: &str,
        keys: &mut std::collections::BTreeSet<String>,
        texts: &mut std::collections::BTreeSet<String>,
    ) {
        if let Some(path) = schema["$ref"].as_str() {
            let named = root.pointer(path.trim_start_matches('#')).unwrap();
            return collect(root, named, key, keys, texts);
        }
        for part in ["anyOf", "oneOf", "allOf"].iter().filter_map(|of| schema[of].as_array()).flatten() {
            collect(root, part, key, keys, texts);
        }
        if let Some(properties) = schema["properties"].as_object() {
            for (word, inner) in properties {
                let inner_key = if key.is_empty() { word.clone() } else { format!("{key}.{word}") };
                collect(root, inner, &inner_key, keys, texts);
            }
        } else if schema["items"].is_object() {
            collect(root, &schema["items"], key, keys, texts);
        } else if schema.get("type").is_some_and(|kind| kind != "null") {
            keys.insert(key.to_owned());
            let is_text = schema["type"].to_string().contains("string");
            if is_text && schema.get("enum").is_none() && schema.get("const").is_none() {
                texts.insert(key.to_owned());
            }
        }
    }
}
