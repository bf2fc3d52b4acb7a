//! What is read is checked, keys have units, and numbers keep their bits.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use glam::{DQuat, DVec3};
use nextview::geometry::{Aabb, Lattice, Plane, Pose};
use nextview::map::SensorModel;
use nextview::motion::MotionConfig;
use nextview::object::Table;
use nextview::planner::{BatchConfig, Choice, Explanation, GreedyConfig, MaxFlowConfig, MostSurfaceConfig};
use nextview::registration::RegistrationConfig;
use nextview::sensor::{Distortion, Intrinsics};
use nextview::session::{MultiResolutionConfig, SessionConfig, StopConfig};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::{Value, json};

/// The fault of a value, or none.
fn fault<T: DeserializeOwned>(value: Value) -> Option<String> {
    serde_json::from_str::<T>(&value.to_string()).err().map(|error| error.to_string())
}

fn assert_refused<T: DeserializeOwned>(value: Value, expected: &str) {
    let fault = fault::<T>(value.clone()).unwrap_or_else(|| panic!("{value} is accepted"));
    assert!(fault.contains(expected), "{value}: {fault}");
}

fn read_back<T: Serialize + DeserializeOwned>(value: &T) -> T {
    serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
}

#[test]
fn geometry_is_checked() {
    let pose = |rotation: [f64; 4]| json!({"rotation_xyzw": rotation, "translation_m": [0.0, 0.0, 1.0]});
    assert_eq!(fault::<Pose>(pose([0.0, 0.0, 0.0, 1.0])), None);
    assert_refused::<Pose>(pose([0.0, 3.0, 0.0, 4.0]), "length of the quaternion is 5, expected 1");
    assert_refused::<Pose>(pose([0.0; 4]), "length of the quaternion is 0");
    let plane = |length: f64| json!({"normal": [0.0, 0.0, length], "offset_m": 0.1});
    assert_eq!(fault::<Plane>(plane(1.0)), None);
    assert_refused::<Plane>(plane(2.0), "length of the normal is 2");
    let bounds = |min: f64| json!({"min_m": [min, 0.0, 0.0], "max_m": [1.0, 1.0, 1.0]});
    assert_eq!(fault::<Aabb>(bounds(0.0)), None);
    assert_refused::<Aabb>(bounds(1.5), "expected the lowest corner first");
    assert_refused::<Lattice>(json!({"voxel_size_m": -1.0}), "voxel_size_m is -1, expected");
}

#[test]
fn poses_keep_their_bits() {
    let turned = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_x(1.1);
    let pose = Pose::new(turned, DVec3::new(0.1, -0.2, 1.0 / 3.0)).unwrap();
    let off = Pose::new(turned, DVec3::ZERO).unwrap().inverse();
    for pose in [pose, off, pose * off] {
        let read = read_back(&pose);
        assert_eq!(
            read.rotation().to_array().map(f64::to_bits),
            pose.rotation().to_array().map(f64::to_bits)
        );
        assert_eq!(read, pose);
    }
}

#[test]
fn optics_are_checked() {
    assert_eq!(read_back(&Intrinsics::d435i()), Intrinsics::d435i());
    let mut camera = serde_json::to_value(Intrinsics::d435i()).unwrap();
    camera["width"] = json!(0);
    assert_refused::<Intrinsics>(camera, "width is 0, expected 1 to 32768 pixels");
    // JSON has no infinity; TOML has.
    let distortion = |k: &str| {
        toml::from_str::<Holder>(&format!("lens = {{ brown-conrady = [{k}, 0.0, 0.0, 0.0, 0.0] }}"))
    };
    assert!(distortion("0.1").is_ok());
    for bad in ["nan", "inf"] {
        let fault = distortion(bad).unwrap_err().to_string();
        assert!(fault.contains("expected finite coefficients"), "{fault}");
    }
}

#[derive(Debug, serde::Deserialize)]
struct Holder {
    #[allow(dead_code, reason = "only read")]
    lens: Distortion,
}

#[test]
fn configurations_of_planners_are_checked() {
    assert_refused::<MaxFlowConfig>(json!({"gamma": 2}), "gamma is 2, expected a number in 0..=1");
    assert_refused::<MaxFlowConfig>(json!({"ray_spacing": 0.0}), "ray_spacing is 0");
    assert_refused::<GreedyConfig>(json!({"theta": -0.1}), "theta is -0.1");
    assert_refused::<BatchConfig>(json!({"n_views": 0}), "n_views is 0, expected at least 1");
    assert_refused::<MostSurfaceConfig>(json!({"rays_across": 0}), "rays_across is 0");
    assert_refused::<MostSurfaceConfig>(json!({"rays": 3}), "unknown field");
    let fault = toml::from_str::<MaxFlowConfig>("gamma = nan").unwrap_err().to_string();
    assert!(fault.contains("gamma is NaN, expected a number in 0..=1"), "{fault}");
}

#[test]
fn configurations_of_sessions_are_checked() {
    let config = SessionConfig::new(0.01, Aabb::cube(DVec3::ZERO, 0.1));
    let of = |key: &str, value: Value| {
        let mut all = serde_json::to_value(config).unwrap();
        all[key] = value;
        all
    };
    assert_eq!(fault::<SessionConfig>(of("max_views", json!(3))), None);
    for (key, value, expected) in [
        ("voxel_size_m", json!(-1), "voxel_size_m is -1, expected a finite length of at least 0.0001 m"),
        ("max_views", json!(0), "max_views is 0, expected at least 1"),
        (
            "object_box",
            json!({"known": {"min_m": [0, 0, 0], "max_m": [0.001, 0.1, 0.1]}}),
            "at least one voxel",
        ),
        ("sensor_model", json!({"hit": 0.3}), "hit is 0.3"),
        ("multi_resolution", json!({"coarsest_voxel_size_m": 0.015}), "coarsest_voxel_size_m is 0.015"),
        ("multi_resolution", json!({"q_thresh": 1.5}), "q_thresh is 1.5"),
        ("motion", json!({"speed_m_per_s": 0}), "speed_m_per_s is 0, expected 0.001 to 100"),
        ("registration", json!({"rotation_uncertainty_deg": 200}), "rotation_uncertainty_deg is 200"),
        ("stop", json!({"path_length_m": 0}), "path_length_m is 0, expected a positive number of metres"),
        ("stop", json!({"max_views": 3}), "unknown field `max_views`"),
        ("speed", json!(1), "unknown field `speed`"),
    ] {
        assert_refused::<SessionConfig>(of(key, value), expected);
    }
    assert_refused::<SessionConfig>(json!({"voxel_size_m": 0.01}), "missing field `object_box`");
    let least = json!({"voxel_size_m": 0.01, "object_box": {"known": {"min_m": [-0.1, -0.1, -0.1], "max_m": [0.1, 0.1, 0.1]}}});
    assert_eq!(serde_json::from_value::<SessionConfig>(least).unwrap(), config);
    assert_eq!(read_back(&config), config);
    let text = toml::to_string(&config).unwrap();
    assert_eq!(toml::from_str::<SessionConfig>(&text).unwrap(), config, "{text}");
    let fault = toml::from_str::<Table>("at-height-m = nan").unwrap_err().to_string();
    assert!(fault.contains("expected a finite height in metres"), "{fault}");
}

#[test]
fn keys_have_units() {
    let keys = |value: Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    let of_motion = keys(serde_json::to_value(MotionConfig::default()).unwrap());
    assert_eq!(of_motion, ["acceleration_m_per_s2", "clearance_m", "sensing_time_s", "speed_m_per_s"]);
    let stop = StopConfig { path_length: Some(2.0), ..StopConfig::default() };
    assert_eq!(serde_json::to_value(stop).unwrap(), json!({"path_length_m": 2.0, "progress": 0.01}));
    let rule = MultiResolutionConfig { coarsest_voxel_size: Some(0.04), ..MultiResolutionConfig::enabled() };
    let expected = json!({"enabled": true, "coarsest_voxel_size_m": 0.04, "q_thresh": 0.5});
    assert_eq!(serde_json::to_value(rule).unwrap(), expected);
    assert_eq!(serde_json::to_value(Table::AtHeight(0.7)).unwrap(), json!({"at-height-m": 0.7}));
    assert!(keys(serde_json::to_value(SensorModel::default()).unwrap()).contains(&"hit".to_owned()));
}

#[test]
fn degrees_in_files_are_tidy_and_read_back_to_the_same_bits() {
    let config = RegistrationConfig::default();
    let text = serde_json::to_string(&config).unwrap();
    assert!(text.contains("\"rotation_uncertainty_deg\":10.0,"), "{text}");
    let read: RegistrationConfig = serde_json::from_str(&text).unwrap();
    assert_eq!(read.rotation_uncertainty.to_bits(), 10_f64.to_radians().to_bits());
    assert_eq!(config.rotation_uncertainty.to_bits(), 10_f64.to_radians().to_bits());
}

#[test]
fn explanations_are_plain_objects() {
    let explanation = Explanation::from([("local_share", 0.25)]);
    let choice = Choice { explanation: Some(explanation), ..Choice::new(3, 0.5) };
    let expected = json!({"view": 3, "score": 0.5, "runner_up": null, "explanation": {"local_share": 0.25}});
    assert_eq!(serde_json::to_value(&choice).unwrap(), expected);
    assert_eq!(read_back(&choice), choice);
    assert_eq!(read_back(&Choice::new(3, 0.5)), Choice::new(3, 0.5));
}
