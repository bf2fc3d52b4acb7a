//! Checks of a configuration that involve several of its parts.

#[cfg(feature = "simulated")]
use super::ReferenceConfig;
use super::millimetres::{in_millimetres, of_least_depth};
use super::planner_name::no_reference;
use super::planner_properties::remedy;
use super::{
    BoxRule, LiveConfig, RecordingConfig, RobotConfig, ScanConfig, SourceConfig, TableRule, ViewRule,
};
use crate::{Fault, Faults};
use nextview::gain::Apora;
use nextview::geometry::Aabb;
use nextview::planner::{Batch, Greedy, MaxFlow, MostSurface};
use nextview::sensor::SurfaceNoise;
use nextview_recording::FARTHEST_POSITION;
#[cfg(feature = "simulated")]
use nextview_sim::inspection::SurfaceDemand;

impl ScanConfig {
    /// Fails with every value that is out of range or contradicts another. Opens no files.
    pub fn check(&self) -> Result<(), Faults> {
        let faults = self.out_of_range().into_iter().chain(self.contradictions());
        Faults::of(faults.collect()).map_or(Ok(()), Err)
    }

    /// Fails with everything that [`check`](Self::check) reports, and with the arm, the weights or the Python
    /// planner that the configuration names if they cannot be loaded.
    pub fn check_with_files(&self) -> Result<(), Faults> {
        let faults = self.out_of_range().into_iter().chain(self.contradictions()).chain(self.unloadable());
        Faults::of(faults.collect()).map_or(Ok(()), Err)
    }

    /// Fails if the configuration does not fit this number of candidates.
    pub fn check_views(&self, n_views: usize) -> Result<(), Faults> {
        Faults::of(of_views(self, n_views)).map_or(Ok(()), Err)
    }

    /// All single values that are out of range. The library's checks report only their first fault;
    /// correcting it may reveal another.
    pub(super) fn out_of_range(&self) -> Vec<Fault> {
        out_of_range(self)
    }

    /// All contradictions between values.
    pub(super) fn contradictions(&self) -> Vec<Fault> {
        contradictions(self)
    }

    /// Every arm, weights or Python planner that cannot be loaded.
    pub(super) fn unloadable(&self) -> Vec<Fault> {
        // The library's own weights need no check: it would take tens of milliseconds.
        let weights = self.nbv_net.weights.as_ref().and_then(|_| self.nbv_net.planner().err());
        let arm = self.robot.as_ref().and_then(RobotConfig::fault_of_file);
        self.planner.check().err().into_iter().chain(weights).chain(arm).collect()
    }
}

fn out_of_range(config: &ScanConfig) -> Vec<Fault> {
    let mut faults = Vec::new();
    let lengths = [
        ("voxel_size_m", config.voxel_size_m),
        ("size_m", config.size_m),
        ("view_distance_m", config.view_distance_m),
        ("view_standoff_m", config.view_standoff_m),
    ];
    for (key, value) in lengths.into_iter().filter_map(|(key, value)| Some((key, value?))) {
        if !(value > 0.0 && value.is_finite()) {
            faults.push(Fault::of_value(key, value, "a positive number of metres"));
        }
    }
    if let Some(time) = config.time_limit_s.filter(|time| time.is_nan() || *time < 0.0) {
        faults.push(Fault::of_value("time_limit_s", time, "a number of seconds, at least 0"));
    }
    if let Some(share) = config.min_overlap.filter(|share| !(0.0..=1.0).contains(share)) {
        faults.push(Fault::of_value("min_overlap", share, "a number in 0..=1"));
    }
    let gap = config.object_box.max_gap_m;
    if !(0.0..=1000.0).contains(&gap) {
        faults.push(Fault::of_value("object_box.max_gap_m", gap, "a number of metres, 0 to 1000"));
    }
    let parts = [
        ("stop", config.stop.check()),
        ("map.sensor_model", config.map.sensor_model.check()),
        ("multi_resolution", config.multi_resolution.check()),
        ("motion", config.motion.check()),
        ("registration", config.registration.check()),
        ("max_flow", MaxFlow::new(config.max_flow).map(drop)),
        // Independent of the gain.
        ("greedy", Greedy::<Apora>::new(config.greedy).map(drop)),
        ("frontier_tour", config.frontier_tour.check()),
        ("receding_horizon", config.receding_horizon.check()),
        ("kaba", config.kaba.check()),
        ("most_surface", MostSurface::new(config.most_surface).map(drop)),
        ("batch", Batch::new(config.batch).map(drop)),
        ("looks", config.looks.map_or(Ok(()), |looks| looks.check())),
    ];
    faults.extend(
        parts.into_iter().filter_map(|(section, result)| Some(Fault::of_part(section, result.err()?))),
    );
    #[cfg(feature = "simulated")]
    faults.extend(config.noise.faults());
    let read = config.source.recording().and_then(|recording| recording.read.check().err());
    faults.extend(read.map(Fault::from));
    faults
}

fn contradictions(config: &ScanConfig) -> Vec<Fault> {
    let mut faults = Vec::new();
    let knows_no_part = config.planner.properties().needs_reference && config.reference.is_none();
    faults.extend(knows_no_part.then(no_reference));
    #[cfg(feature = "simulated")]
    faults.extend(config.reference.iter().flat_map(of_reference));
    faults.extend(config.reach.faults());
    faults.extend(config.robot.iter().flat_map(RobotConfig::faults));
    #[cfg(feature = "simulated")]
    faults.extend(config.of_sensor());
    faults.extend(match &config.source {
        SourceConfig::Simulated => Vec::new(),
        SourceConfig::Recording(recording) => of_recording(recording, config),
        SourceConfig::Live(live) => of_live(live, config),
    });
    faults.extend(of_turntable(config));
    faults.extend(of_view_distance(config));
    faults.extend(of_stop(config));
    faults.extend(of_goal(config));
    faults.extend(of_looks(config));
    faults.extend(of_seconds(config));
    faults
}

/// All values out of range in the surface demands of a part.
#[cfg(feature = "simulated")]
fn of_reference(reference: &ReferenceConfig) -> impl Iterator<Item = Fault> + '_ {
    let of_demand = |(key, demand): (String, SurfaceDemand)| -> Vec<Fault> {
        demand.faults().into_iter().map(|error| Fault::of_part(&key, error)).collect()
    };
    reference.keyed_demands().flat_map(of_demand)
}

/// The planner must estimate the quantity that stops the scan.
fn of_stop(config: &ScanConfig) -> Option<Fault> {
    let is_estimated = config.stop.completeness.or(config.stop.expected_gain).is_some();
    (is_estimated && !config.planner.properties().estimates_completeness).then(|| {
        let planner = &config.planner;
        let message = format!(
            "the planner {planner} cannot stop by completeness or expected gain, which it does not estimate"
        );
        Fault::request(message).with_remedy(remedy(|planner| planner.estimates_completeness))
    })
}

/// A distance requires a rule that uses one, and a fixed box.
fn of_view_distance(config: &ScanConfig) -> Option<Fault> {
    let stated = [("view_distance_m", config.view_distance_m), ("view_standoff_m", config.view_standoff_m)];
    let mut stated = stated.into_iter().filter_map(|(key, value)| value.map(|_| key));
    let key = stated.next()?;
    let fault = match config.view_space.rule() {
        _ if stated.next().is_some() => Fault::request(
            "`view_distance_m` and `view_standoff_m` both state the distance of the candidates",
        )
        .with_remedy("leave one of them out"),
        None | Some(ViewRule::Shell) => Fault::request(format!(
            "the candidates of `view_space` = {} have no common distance",
            config.view_space.0
        ))
        .with_remedy("use sphere, hemisphere, tammes, rings or ring"),
        Some(_) if config.turntable.is_some() => {
            Fault::request(format!("`{key}` conflicts with `turntable`, which states where the camera is"))
                .with_remedy("leave one of them out")
        }
        Some(_) if config.object_box.rule == BoxRule::Grows => {
            Fault::request(format!("`{key}` needs a known box: candidates move with a box that grows"))
                .with_remedy("leave it out, or set `object_box.rule` = known")
        }
        Some(_) => return None,
    };
    Some(Fault { key: Some(key.to_owned()), ..fault })
}

/// The planner must count seconds.
fn of_seconds(config: &ScanConfig) -> Option<Fault> {
    (config.most_surface.per_second && !config.planner.properties().counts_seconds).then(|| {
        let message = format!("the planner {} does not plan by time", config.planner);
        let fault = Fault::request(message).with_remedy(remedy(|planner| planner.counts_seconds));
        Fault { key: Some("most_surface.per_second".to_owned()), ..fault }
    })
}

/// A goal requires a planner that takes second looks, and the error of the camera.
fn of_goal(config: &ScanConfig) -> Option<Fault> {
    let goal = config.goal_mm?;
    if !(goal > 0.0 && goal.is_finite()) {
        return Some(Fault::of_value("goal_mm", goal, "a positive number of millimetres"));
    }
    let knows_error = config.surface_error() != SurfaceNoise::default();
    takes_second_looks(config, "goal_mm").or_else(|| {
        (!knows_error).then(|| {
            let fault = Fault::request("`goal_mm` requires a camera whose error is known")
                .with_remedy("`sensor` names a camera whose error is known");
            Fault { key: Some("goal_mm".to_owned()), ..fault }
        })
    })
}

/// Looks require a planner that takes second looks.
fn of_looks(config: &ScanConfig) -> Option<Fault> {
    config.looks.and_then(|_| takes_second_looks(config, "looks"))
}

/// The fault of a goal with a planner that takes no second looks.
fn takes_second_looks(config: &ScanConfig, key: &str) -> Option<Fault> {
    (!config.planner.properties().takes_second_looks).then(|| {
        let message = format!("the planner {} takes no second looks, which `{key}` requires", config.planner);
        let fault = Fault::request(message).with_remedy(remedy(|planner| planner.takes_second_looks));
        Fault { key: Some(key.to_owned()), ..fault }
    })
}

/// All faults for this number of candidates.
fn of_views(config: &ScanConfig, n_views: usize) -> Vec<Fault> {
    let mut faults = Vec::new();
    // Recorded poses stay candidates wherever the table is.
    let has_table = config.object_box.table != TableRule::None && config.source.recording().is_none();
    let which = match (config.reach.is_default(), has_table) {
        (true, false) => None,
        (true, true) => Some("above the table"),
        (false, false) => Some("within reach"),
        (false, true) => Some("within reach and above the table"),
    };
    let with_which = |fault: Fault, rest: &str| match which {
        Some(which) => fault.with_remedy(format!("only candidates {which} count{rest}")),
        None => fault,
    };
    if config.first_view >= n_views {
        let last = n_views.saturating_sub(1);
        let fault = Fault::of_value("first_view", config.first_view, format!("0 to {last}"));
        faults.push(with_which(fault, "; they are renumbered"));
    }
    if let Some(views) = config.views.filter(|views| *views == 0 || *views > n_views) {
        let fault = Fault::of_value("views", views, format!("1 to {n_views} (the candidates)"));
        faults.push(if views == 0 { fault } else { with_which(fault, "") });
    }
    faults
}

/// All faults of a recording, and all keys that only a simulation can have.
fn of_recording(recording: &RecordingConfig, config: &ScanConfig) -> Vec<Fault> {
    let mut faults = of_place("recording", recording.bounds(), recording.table_z_m, config);
    if recording.truth.is_none() && recording.truth_from_world.is_some() {
        faults.push(Fault::request(
            "`recording.truth_from_world` needs `recording.truth`, the mesh that it refers to",
        ));
    }
    let neutral = ScanConfig::of_profile(config.profile);
    let given = [
        ("candidates", config.candidates != neutral.candidates),
        ("view_space", config.view_space != neutral.view_space),
        ("view_seed", config.view_seed != neutral.view_seed),
        ("robot", config.robot.is_some()),
    ];
    let given = given.into_iter().filter(|(_, is_given)| *is_given).map(|(key, _)| key);
    faults.extend(given.chain(simulated_keys(config)).map(|key| only_simulated(key, "recording")));
    faults
}

/// All faults of a user's camera, and all keys that only a simulation can have.
fn of_live(live: &LiveConfig, config: &ScanConfig) -> Vec<Fault> {
    let mut faults = of_place("live", live.bounds(), live.table_z_m, config);
    if !(live.min_depth_m >= 0.0 && live.min_depth_m.is_finite()) {
        faults.push(Fault::of_value(
            "live.min_depth_m",
            live.min_depth_m,
            "0 or a positive number of metres",
        ));
    } else if let Some(fault) = of_least_depth("live.min_depth_m", live.min_depth_m) {
        faults.push(fault);
    } else if live.depth_range().check().is_err() {
        let expected = "a finite number of metres above `live.min_depth_m`";
        faults.push(Fault::of_value("live.max_depth_m", live.max_depth_m, expected));
    }
    // Recorded frames may come with a true mesh, whose unit this is.
    let has_unit = config.unit != ScanConfig::of_profile(config.profile).unit;
    let given = simulated_keys(config).chain(has_unit.then_some("unit"));
    faults.extend(given.map(|key| only_simulated(key, "live")));
    faults
}

/// All faults of a turntable, which requires a user's camera.
fn of_turntable(config: &ScanConfig) -> Vec<Fault> {
    let Some(turntable) = &config.turntable else { return Vec::new() };
    let mut faults = turntable.faults();
    let mut refuse = |problem: &str, remedy: &str| {
        let fault = Fault::request(problem).with_remedy(remedy);
        faults.push(Fault { key: Some("turntable".to_owned()), ..fault });
    };
    if config.view_space.rule() != Some(ViewRule::Ring) {
        refuse("the views of a `turntable` are a ring", "set `view_space` = ring");
    }
    match config.source.live() {
        None => refuse(
            "`turntable` is for a camera of your own",
            "`view_space` = ring alone simulates a turntable; add `live` for a camera of your own",
        ),
        Some(live) if !live.poses.is_empty() => {
            refuse("the candidates of a `turntable` are angles", "leave out `live.poses`");
        }
        Some(_) => (),
    }
    faults
}

/// All faults in the object's place, as stated by this section of the configuration.
fn of_place(section: &str, bounds: Option<Aabb>, table_z_m: Option<f64>, config: &ScanConfig) -> Vec<Fault> {
    let mut faults = Vec::new();
    if let Some(Aabb { min, max }) = bounds {
        let (key, value) = (format!("{section}.box_m"), format!("{min} to {max}"));
        if !(min.is_finite() && max.is_finite() && min.cmplt(max).all()) {
            faults.push(Fault::of_value(&key, value, "finite corners, the lowest first"));
        } else if min.abs().max(max.abs()).length() > FARTHEST_POSITION {
            let expected = format!("corners within {FARTHEST_POSITION} m of the origin");
            faults.push(in_millimetres(Fault::of_value(&key, value, expected)));
        }
    }
    let key = format!("{section}.table_z_m");
    if let Some(z) = table_z_m.filter(|z| !z.is_finite()) {
        faults.push(Fault::of_value(&key, z, "a finite number of metres"));
    }
    if table_z_m.is_some() && config.object_box.table != TableRule::None {
        let fault =
            Fault::request(format!("`{key}` states the table's height, so there is no table to find"));
        faults.push(fault.with_remedy(format!("leave out `{key}` or `object_box.table`")));
    }
    faults
}

/// The keys with a value that only a simulation can have.
fn simulated_keys(config: &ScanConfig) -> impl Iterator<Item = &'static str> {
    let neutral = ScanConfig::of_profile(config.profile);
    let given = [
        ("size_m", config.size_m != neutral.size_m),
        ("size_of", config.size_of != neutral.size_of),
        #[cfg(feature = "simulated")]
        ("noise", config.simulates_noise()),
        ("object_box.table", config.object_box.table == TableRule::Known),
    ];
    given.into_iter().filter(|(_, is_given)| *is_given).map(|(key, _)| key)
}

fn only_simulated(key: &str, section: &str) -> Fault {
    let remedy = match (key, section) {
        ("object_box.table", _) => &format!(
            "`{section}.table_z_m` states its height, `object_box.table` = fit finds it in the first image"
        ),
        ("noise", _) => "`sensor` names a camera whose error is known, and `noise.depth` changes it",
        (_, "live") => "the frames of your camera are not changed; leave it out",
        _ => "recorded frames are not changed; leave it out",
    };
    let whose = if section == "live" { "a camera of your own" } else { "recorded frames" };
    let fault = Fault::request(format!("`{key}` is for simulations, not for {whose}"));
    Fault { key: Some(key.to_owned()), ..fault.with_remedy(remedy) }
}
