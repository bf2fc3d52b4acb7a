//! Configurations report all their faults at once, with their places.

use nextview::sensor::Sensor;
use nextview_scan::{
    Faults, LiveConfig, NoiseModel, Profile, RobotConfig, ScanConfig, SensorName, SourceConfig,
};
use nextview_sim::noise::SensorNoise;
use std::path::Path;

fn parse(text: &str) -> Result<ScanConfig, Faults> {
    ScanConfig::parse(text, Some(Path::new("scan.toml")), None)
}

/// Line, column, key and remedy of every fault.
fn faults(text: &str) -> Vec<String> {
    let fault = |fault: &nextview_scan::Fault| {
        let position = fault.place.as_ref().and_then(|place| place.position);
        let (line, column) = position.unwrap_or_default();
        let remedy = fault.remedy.as_ref().map(|remedy| format!(" ({remedy})")).unwrap_or_default();
        format!("{line}:{column} {}{remedy}", fault.message)
    };
    parse(text).unwrap_err().iter().map(fault).collect()
}

#[test]
fn what_is_saved_loads_to_the_same() {
    for profile in [Profile::Paper, Profile::Default] {
        let config = ScanConfig::of_profile(profile);
        assert_eq!(parse(&toml::to_string(&config).unwrap()), Ok(config));
    }
}

#[test]
fn a_file_overrides_its_profile_and_an_option_the_file() {
    let text = "profile = \"paper\"\nviews = 3\n[max_flow]\ngamma = 0.25\n";
    let config = parse(text).unwrap();
    assert_eq!((config.views, config.candidates, config.max_flow.gamma), (Some(3), 5000, 0.25));
    assert_eq!(config.max_flow.ray_spacing, 10.0);
    let config = ScanConfig::parse(text, None, Some(Profile::Default)).unwrap();
    assert_eq!((config.candidates, config.max_flow.gamma, config.max_flow.ray_spacing), (1000, 0.25, 2.0));
}

#[test]
fn the_candidates_may_have_their_own_seed() {
    let seeds = |text: &str| parse(text).map(|config| (config.seed, config.view_seed()));
    assert_eq!(seeds("seed = 3\n"), Ok((3, 3)));
    assert_eq!(seeds("seed = 3\nview_seed = 0\n"), Ok((3, 0)));
}

#[test]
fn all_faults_come_at_once_with_line_and_column() {
    let text = "voxels = 3\nviews = \"many\"\n\n[max_flow]\n  gamma = 2\n[map]\nrays = \"some\"\n[stop]\n\
                entropy_share = 7\n";
    let found = faults(text);
    let expected = [
        "1:1 `voxels` is not a key (did you mean `voxel_size_m`?)",
        "2:1 `views` is \"many\", expected a whole number, at least 0",
        "5:3 `max_flow.gamma` is 2, expected a number in 0..=1",
        "7:1 `map.rays` is \"some\", expected",
        "9:1 `stop.entropy_share` is 7, expected a number in 0..=1",
    ];
    let mut sorted = found.clone();
    sorted.sort();
    assert_eq!(sorted.len(), expected.len(), "{found:?}");
    for (found, expected) in sorted.iter().zip(expected) {
        assert!(found.starts_with(expected), "{found}, expected {expected}");
    }
}

#[test]
fn types_are_named_in_words() {
    for (text, expected) in [
        ("views = -1", "1:1 `views` is -1, expected a whole number, at least 0"),
        ("seed = 0.5", "1:1 `seed` is 0.5, expected a whole number, at least 0"),
        ("voxel_size_m = \"fine\"", "1:1 `voxel_size_m` is \"fine\", expected a number"),
        ("stop = 3", "1:1 `stop` is 3, expected a table"),
        ("camera.width = -1", "1:8 `camera.width` is -1, expected a whole number, 0 to 4294967295"),
    ] {
        assert_eq!(faults(text), [expected]);
    }
}

#[test]
fn syntax_is_reported_by_line_and_column() {
    let found = faults("views = \nseed = 1\nplanner = \"local\n");
    assert!(found.len() == 2 && found[0].starts_with("1:") && found[1].starts_with("3:"), "{found:?}");
}

#[test]
fn candidates_have_one_distance_where_a_rule_gives_them_one() {
    let fault = |text: &str| {
        let found = faults(text);
        assert_eq!(found.len(), 1, "{found:?}");
        found[0].clone()
    };
    let rule = "view_space = \"sphere\"\n";
    assert!(parse(&format!("{rule}view_distance_m = 0.3\n")).is_ok());
    for (text, expected) in [
        (
            "view_distance_m = 0.3\n".to_owned(),
            "1:1 the candidates of `view_space` = shell have no common distance",
        ),
        (format!("{rule}view_distance_m = -1\n"), "2:1 `view_distance_m` is -1"),
        (
            format!("{rule}view_distance_m = 1\nview_standoff_m = 1\n"),
            "2:1 `view_distance_m` and `view_standoff_m` both",
        ),
        (
            format!("{rule}view_standoff_m = 1\nobject_box.rule = \"grows\"\n"),
            "2:1 `view_standoff_m` needs a known box",
        ),
    ] {
        assert!(fault(&text).starts_with(expected), "{}, expected {expected}", fault(&text));
    }
}

#[test]
fn wrong_values_are_named() {
    for (text, expected) in [
        ("voxel_size_m = nan\n", "`voxel_size_m` is NaN"),
        ("size_m = -1\n", "`size_m` is -1"),
        ("time_limit_s = -1\n", "`time_limit_s` is -1"),
        ("[map.sensor_model]\nhit = 0.2\n", "`map.sensor_model.hit` is 0.2"),
        ("[multi_resolution]\nq_thresh = 1.5\n", "`multi_resolution.q_thresh` is 1.5"),
        (
            "[multi_resolution]\ncoarsest_voxel_size_m = -1\n",
            "`multi_resolution.coarsest_voxel_size_m` is -1",
        ),
        ("[greedy]\ntheta = -1\n", "`greedy.theta` is -1"),
        ("[noise]\npose_error_mm = -1\n", "`noise.pose_error_mm` is -1, expected 0 to 1000"),
        ("[noise.depth]\nedge_loss = 2\n", "edge_loss` is 2"),
        (
            "[noise.depth]\nmin_depth_m = 170\nmax_depth_m = 10000\n",
            "`noise.depth.min_depth_m` is 170, expected at most 20 m; is it in millimetres?",
        ),
        (
            "[recording]\nbox_m = [-100, -100, 0, 100, 100, 200]\n",
            "`recording.box_m` is [-100, -100, 0] to [100, 100, 200], expected corners within 100 m of the origin; is it in \
             millimetres?",
        ),
        ("[motion]\nspeed_m_per_s = 0\n", "`motion.speed_m_per_s` is 0, expected 0.001 to 100"),
        ("[motion]\nacceleration_m_per_s2 = nan\n", "`motion.acceleration_m_per_s2` is NaN"),
        ("[motion]\nclearance_m = -1\n", "`motion.clearance_m` is -1, expected 0 to 1e6"),
        ("[motion]\nsensing_time_s = inf\n", "`motion.sensing_time_s` is inf"),
        ("[reach]\nmax_radius_m = 1\n", "`reach.base_m` and `reach.max_radius_m` must be given together"),
        ("[reach]\nmin_radius_m = 1\n", "`reach.min_radius_m` needs `reach.base_m`"),
        ("[reach]\nbase_m = [0, 0, 0]\nmax_radius_m = -1\n", "reach: reach is 0 to -1 m, expected"),
        ("[reach]\nallowed_boxes_m = [[0, 0, 0, 1, 1, -1]]\n", "the lowest first"),
        (
            "[reach]\nforbidden_boxes_m = [[0, 0]]\n",
            "`reach.forbidden_boxes_m.0` is [0, 0], expected a list of 6",
        ),
        ("min_overlap = 2\n", "`min_overlap` is 2"),
        ("[registration]\nspacing_m = 0\n", "`registration.spacing_m` is 0"),
        ("[registration]\nposition_uncertainty_m = -1\n", "`registration.position_uncertainty_m` is -1"),
        (
            "[registration]\nrotation_uncertainty_deg = 181\n",
            "`registration.rotation_uncertainty_deg` is 181",
        ),
        ("[registration]\nmin_overlap = 2\n", "`registration.min_overlap` is 2"),
        ("[batch]\nn_views = 0\n", "`batch.n_views` is 0"),
        ("[batch]\nleast_share = 2\n", "`batch.least_share` is 2"),
        ("[nbv_net]\nweights = 'no-such-file'\n", "no-such-file: cannot be read"),
        ("[max_flow]\nray_spacing = 1e-4\n", "`max_flow.ray_spacing` is 0.0001, expected a number of voxels"),
        ("[greedy]\nray_spacing = 0.05\n", "`greedy.ray_spacing` is 0.05"),
        ("[batch]\nray_spacing = nan\n", "`batch.ray_spacing` is NaN"),
        (
            "[object_box]\nmax_gap_m = -1\n",
            "`object_box.max_gap_m` is -1, expected a number of metres, 0 to 1000",
        ),
        ("[object_box]\ntable = \"oak\"\n", "`object_box.table` is \"oak\""),
        ("planner = \"random\"\nstop.completeness = 0.9\n", "the planner random cannot stop by completeness"),
    ] {
        let error = parse(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}, expected {expected}");
    }
}

#[test]
fn a_section_without_defaults_is_read_as_a_whole() {
    let turntable = |length: f64| {
        format!(
            "[turntable]\nplate_radius_m = 0.1\n[turntable.table_from_camera]\ntranslation_m = [0.4, 0, 0.3]\n\
             rotation_xyzw = [0, 0, 0, {length}]\n"
        )
    };
    assert_eq!(
        faults(&turntable(0.99)),
        ["3:12 `turntable.table_from_camera`: length of the quaternion is 0.99, expected 1 (within 1e-6)"]
    );
    let missing = faults("[live]\n[turntable]\nplate_radius_m = 0.1\n");
    assert_eq!(missing, ["2:2 `turntable.table_from_camera` is missing"]);
}

#[test]
fn an_unknown_key_names_its_nearest_neighbour() {
    assert_eq!(
        faults("[max_flow]\ngama = 1\n"),
        ["2:1 `max_flow.gama` is not a key (did you mean `max_flow.gamma`?)"]
    );
    assert_eq!(
        faults("[motoin]\nspeed_m_per_s = 1\n"),
        ["1:2 `motoin` is not a key (did you mean `motion`?)"]
    );
}

#[test]
fn what_is_wrong_is_named_by_key_and_line_however_it_is_written() {
    for (text, expected) in [
        (
            "[max_flow]\na = 1\n",
            &["2:1 `max_flow.a` is not a key (the keys of `max_flow` are gamma, uses_history, "][..],
        ),
        ("[noise]\nnoise = 1\n", &["2:1 `noise.noise` is not a key (the keys of `noise` are model, "]),
        ("[noise.depth]\ndepth = 1\n", &["2:1 `noise.depth.depth` is not a key"]),
        ("max_flow.gamma.x = 1\n", &["1:10 `max_flow.gamma` is { x = 1 }, expected a number"]),
        ("[[max_flow]]\ngamma = 1\n", &["1:3 `max_flow` is [{ gamma = 1 }], expected a table"]),
        (
            "max_flow = { gamma = 2, theta = -1, tetha = 0 }\nqq = 1\nmap = 7\n",
            &[
                "1:14 `max_flow.gamma` is 2, expected a number in 0..=1",
                "1:25 `max_flow.theta` is -1, expected a number in 0..=1",
                "1:37 `max_flow.tetha` is not a key (did you mean `max_flow.theta`?)",
                "2:1 `qq` is not a key",
                "3:1 `map` is 7, expected a table",
            ],
        ),
        (
            "profile = \"papr\"\nsensor = \"d4\"\nviews = true\n",
            &[
                "1:1 `profile` is \"papr\", expected paper or default",
                "2:1 `sensor` is d4, ",
                "3:1 `views` is true, ",
            ],
        ),
        (
            "[live]\nposes = [{ translation_m = [0, 0] }]\n",
            &["2:12 `live.poses.0.translation_m` is [0, 0], "],
        ),
        ("planner = 2020-01-01\n", &["1:1 `planner` is 2020-01-01, expected a string"]),
        (
            "[camera.distortion]\nbrown-conrady = [0, 0, 0, 0]\n",
            &["2:1 `camera.distortion.brown-conrady` is "],
        ),
        (
            "[camera]\nfx = 1e300\ncy = -1e9\n",
            &[
                "2:1 `camera.fx` is 1e300, expected a positive",
                "3:1 `camera.cy` is -1000000000.0, expected a pixel",
            ],
        ),
        (
            "[looks]\nn = 0\nangle_deg = 90\n",
            &["2:1 `looks.n` is 0, expected", "3:1 `looks.angle_deg` is 90, "],
        ),
        (
            "[recording.read]\npose_tolerance_s = -1\n",
            &[
                "2:1 -1 is out of range, expected a number of seconds, at least 0, as `recording.read.pose_tolerance_s`",
            ],
        ),
        ("[[reference]]\nmesh = 'a'\n", &["1:3 `reference` is [{ mesh = \"a\" }], expected a table"]),
        ("[reference]\nunit = 'mm'\n", &["1:2 `reference.mesh` is missing"]),
        (
            "[reference]\nmesh = 'a'\nangle_deg = 'x'\n",
            &["3:1 `reference.angle_deg` is \"x\", expected a number"],
        ),
    ] {
        let mut found = faults(text);
        found.sort();
        assert_eq!(found.len(), expected.len(), "{text}: {found:#?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.starts_with(expected), "{text}: {found}, expected {expected}");
        }
    }
}

/// A long value is truncated, and only the first of very many faults are reported.
#[test]
fn messages_stay_short() {
    let found = faults(&format!("object = [{}]\n", "1234567, ".repeat(1000)));
    assert!(found.len() == 1 && found[0].chars().count() < 150 && found[0].contains('…'), "{found:?}");
    let many: String = (0..5000).map(|i| format!("k{i} = 1\n")).collect();
    assert_eq!(faults(&many).len(), 100);
}

#[test]
fn faults_of_a_file_are_data_and_others_requests() {
    use nextview_scan::FaultKind::{Data, Request};
    let kind = |faults: Faults| faults.iter().map(|fault| fault.kind).collect::<Vec<_>>();
    assert_eq!(kind(parse("min_overlap = 2\n").unwrap_err()), [Data]);
    let config = ScanConfig { min_overlap: Some(2.0), ..ScanConfig::default() };
    assert_eq!(kind(config.check().unwrap_err()), [Request]);
}

#[test]
fn a_scan_has_one_source_of_frames() {
    let mut config = parse("[live]\nmin_depth_m = 0.2\n").unwrap();
    let live = LiveConfig { min_depth_m: 0.2, ..LiveConfig::default() };
    assert_eq!(config.source, SourceConfig::Live(live));
    assert!(config.source.to_recording().unwrap_err().message.starts_with("frames are either recorded or"));
    assert_eq!(parse(&toml::to_string(&config).unwrap()), Ok(config.clone()));
    let json = serde_json::to_string(&config).unwrap();
    assert_eq!(serde_json::from_str::<ScanConfig>(&json).unwrap(), config);
    assert!(json.contains("\"live\":{\"min_depth_m\":0.2"), "{json}");
    assert_eq!(
        faults("views = 2.5\n[recording]\n[live]\nmin_depth_m = -1\n"),
        [
            "3:2 frames are either recorded or come from a user's camera (leave out `recording` or `live`)",
            "1:1 `views` is 2.5, expected a whole number, at least 0",
            "4:1 `live.min_depth_m` is -1, expected 0 or a positive number of metres",
        ]
    );
    let two = serde_json::from_str::<ScanConfig>("{\"recording\": {}, \"live\": {}}").unwrap_err();
    assert!(two.to_string().starts_with("frames are either recorded or come from a user's camera"), "{two}");
    assert_eq!(faults("source = 1\n"), ["1:1 `source` is not a key"]);
    assert_eq!(faults("[recordin]\n"), ["1:2 `recordin` is not a key (did you mean `recording`?)"]);
}

#[test]
fn a_check_opens_no_files() {
    let mut config = ScanConfig::default();
    config.nbv_net.weights = Some("no-such-weights".into());
    config.robot = Some(RobotConfig { arm: "no-such-arm".to_owned(), ..RobotConfig::default() });
    assert_eq!(config.check(), Ok(()));
    let text = toml::to_string(&config).unwrap();
    for faults in [config.check_with_files().unwrap_err(), parse(&text).unwrap_err()] {
        let messages: Vec<_> = faults.iter().map(ToString::to_string).collect();
        assert!(
            messages.len() == 2 && messages[0].contains("no-such-weights: cannot be read"),
            "{messages:?}"
        );
        assert!(messages[1].contains("no-such-arm: cannot be read"), "{messages:?}");
    }
}

#[test]
fn a_sensor_decides_optics_range_and_noise() {
    let text = "sensor = \"d405\"\n[camera]\nwidth = 640\n[noise.depth]\ncorrelated_share = 0\n";
    let config = parse(text).unwrap();
    let depth = SensorNoise { correlated_share: 0.0, ..SensorNoise::of(Sensor::D405) };
    assert_eq!((config.noise.model, config.noise.depth), (NoiseModel::Sensor, depth));
    assert_eq!((config.camera.width(), config.camera.height()), (640, 480));
    assert_eq!(config.camera.focal(), Sensor::D405.intrinsics().focal());
    assert_eq!(config.noise.depth_range(), Sensor::D405.depth_range());
    assert_eq!(parse("sensor = \"l515\"\n[noise]\nmodel = \"none\"\n").unwrap().noise.noise().depth, None);
    assert_eq!(parse("[noise]\nmodel = \"d435i\"\n").unwrap().noise.depth, SensorNoise::d435i());
}

#[test]
fn what_is_saved_of_a_sensor_loads_to_the_same() {
    for sensor in Sensor::ALL {
        let mut config = ScanConfig::default();
        config.set_sensor(SensorName(sensor.to_string())).unwrap();
        // As without a sensor, so only the file sets these values.
        (config.noise.depth.correlated_share, config.noise.depth.flying_share) = (0.0, 0.0);
        assert_eq!(parse(&toml::to_string(&config).unwrap()), Ok(config), "{sensor}");
    }
}

#[test]
fn a_sensor_of_ones_own_differs_from_one_that_there_is() {
    let dir = std::env::temp_dir().join(format!("nextview-sensor-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let file = dir.join("mine.toml");
    let read = |text: &str| {
        std::fs::write(&file, text).unwrap();
        parse(&format!("sensor = '{}'\n", file.display()))
    };
    let own = read("like = \"l515\"\n[camera]\nwidth = 512\n[noise.depth]\nmax_depth_m = 2\n").unwrap();
    let depth = SensorNoise { max_depth: 2.0, ..SensorNoise::of(Sensor::L515) };
    assert_eq!((own.camera.width(), own.noise.depth), (512, depth));
    assert!(own.inputs().contains(&file));
    for (text, expected) in [
        ("[camera]\nwidth = 512\n", "`like` is missing"),
        ("like = \"mine\"\n", "`like` is mine, expected d405, "),
        ("like = \"l515\"\nwidth = 3\n", "line 2, column 1: `width` is not a key"),
        (
            "like = \"l515\"\n[noise.depth]\nedge_loss = 2\n",
            "line 3, column 1: `noise.depth.edge_loss` is 2, expected a probability",
        ),
        ("like = ", "mine.toml, line 1, column 8: "),
    ] {
        let message = read(text).unwrap_err().to_string();
        assert!(message.contains(expected) && message.contains("mine.toml"), "{message}");
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn sensors_that_cannot_be_are_refused() {
    for (text, expected) in [
        ("sensor = \"d999\"\n", "1:1 `sensor` is d999, expected d405, "),
        ("sensor = 3\n", "1:1 `sensor` is 3, expected a string"),
        ("[noise]\nmodel = \"sensor\"\n", "2:1 `noise.model` = sensor needs a `sensor`"),
        (
            "sensor = \"d405\"\n[noise]\nmodel = \"d435i\"\n",
            "3:1 `noise.model` = d435i is not the noise of the `sensor` d405 (leave one of them out)",
        ),
        (
            "sensor = \"d405\"\n[recording]\n[noise]\npose_error_mm = 2\n",
            "3:2 `noise` is for simulations, not for recorded frames (`sensor` names a camera whose error is known",
        ),
    ] {
        let found = faults(text);
        assert!(found.len() == 1 && found[0].starts_with(expected), "{found:?}, expected {expected}");
    }
}
