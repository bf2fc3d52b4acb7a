use super::motion::MotionConfig;
use super::noise::NoiseConfig;
use super::reach::ReachConfig;
use super::recorded::RecordingConfig;
use super::registration::RegistrationConfig;
use super::{NbvNetConfig, PlannerConfigs, PlannerName};
use crate::Failure;
use crate::commands::Rule;
use clap::ValueEnum;
use nextview::gain::Apora;
use nextview::map::{Background, RayRule, SensorModel};
use nextview::planner::{
    Batch, BatchConfig, Greedy, GreedyConfig, MaxFlow, MaxFlowConfig, MinOverlap, MostSurface,
    MostSurfaceConfig, ViewPlanner,
};
use nextview::sensor::Intrinsics;
use nextview::session::MultiResolution;
use nextview::visibility::FreeSpace;
use nextview_sim::mesh::Unit;
use nextview_sim::truth::TrueVisibility;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// A named set of defaults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Profile {
    /// As published: 5000 candidates, voxels of 1 cm, thin rays, only points on the object, stop at q_thresh = 0.5
    Paper,
    /// What works best: the planner most-surface; what the camera sees past the object carves free space
    Default,
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.to_possible_value().map_or(Ok(()), |value| f.pad(value.get_name()))
    }
}

/// Everything that decides a scan: the file for `--config`, and `config.toml` in the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScanConfig {
    /// A mesh file or `builtin:NAME`; with a recording, where its frames are.
    pub object: String,
    pub profile: Profile,
    pub planner: PlannerName,
    /// Most views to take.
    pub views: usize,
    /// Number of view candidates, where a rule makes them.
    pub candidates: usize,
    /// Number of the view to begin with.
    pub first_view: usize,
    /// Edge of a voxel; by default about a fortieth of the object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxel_size_m: Option<f64>,
    pub view_space: ViewSpaceName,
    pub seed: u64,
    /// Seed of the random shell alone, so that random planners of several seeds may choose among the same candidates; by
    /// default `seed`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_seed: Option<u64>,
    /// Unit of the mesh file: m, mm or auto.
    pub unit: UnitName,
    /// Length that the object's longest side is scaled to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_m: Option<f64>,
    /// Least overlap of the next view with what is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_overlap: Option<f64>,
    /// Whether to compute the random and clairvoyant curves.
    pub baselines: bool,
    /// Most memory that the planning box may need.
    pub memory_limit_mb: u64,
    pub map: MapConfig,
    pub multi_resolution: MultiResolutionConfig,
    pub object_box: ObjectBoxConfig,
    #[serde(default, skip_serializing_if = "ReachConfig::is_default")]
    pub reach: ReachConfig,
    /// Campaigns before there were ways do not tell.
    #[serde(default)]
    pub motion: MotionConfig,
    /// Campaigns before there was registration do not tell.
    #[serde(default, skip_serializing_if = "RegistrationConfig::is_default")]
    pub registration: RegistrationConfig,
    /// Campaigns before there was this planner do not tell.
    #[serde(default)]
    pub most_surface: MostSurfaceConfig,
    pub max_flow: MaxFlowConfig,
    /// Of all planners that are named after a gain.
    pub greedy: GreedyConfig,
    /// Campaigns before there were batches do not tell.
    #[serde(default)]
    pub batch: BatchConfig,
    /// Campaigns before there was NBV-Net do not tell.
    #[serde(default)]
    pub nbv_net: NbvNetConfig,
    pub stop: StopConfig,
    pub camera: Intrinsics,
    #[serde(default)]
    pub noise: NoiseConfig,
    /// The frames are recorded; without it, they are simulated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<RecordingConfig>,
}

/// How scans are written into the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct MapConfig {
    pub rays: RayRule,
    pub background: Background,
    pub sensor_model: SensorModel,
}

/// Whether planning goes from coarse voxels to fine ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct MultiResolutionConfig {
    pub enabled: bool,
    /// Share of the entropy of an unknown map below which the voxels are halved: the paper's q_thresh.
    pub q_thresh: f64,
    /// Voxel size to begin with: the finest times a power of two; by default the coarsest of which 12 fit along the box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coarsest_voxel_size_m: Option<f64>,
}

impl Default for MultiResolutionConfig {
    fn default() -> Self {
        let MultiResolution { q_thresh, coarsest_voxel_size } = MultiResolution::default();
        Self { enabled: false, q_thresh, coarsest_voxel_size_m: coarsest_voxel_size }
    }
}

impl MultiResolutionConfig {
    /// What the session is told.
    pub fn rule(&self) -> Option<MultiResolution> {
        let Self { enabled, q_thresh, coarsest_voxel_size_m: coarsest_voxel_size } = *self;
        enabled.then_some(MultiResolution { coarsest_voxel_size, q_thresh })
    }
}

impl StopConfig {
    /// What the session is told.
    pub fn rules(&self, max_views: usize) -> nextview::session::StopConfig {
        let Self { entropy_share, completeness, expected_gain, path_length_m: path_length, time_s: _ } =
            *self;
        nextview::session::StopConfig { max_views, entropy_share, completeness, expected_gain, path_length }
    }
}

/// What is known of the object's place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct ObjectBoxConfig {
    pub rule: BoxRule,
    pub table: TableRule,
}

/// How the box around the object comes about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum BoxRule {
    /// Planning is told the box
    #[default]
    Known,
    /// Nothing is known: the box begins with the first image and grows, and the candidates move along
    Grows,
}

/// What the object stands on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum TableRule {
    /// The object floats in the room
    #[default]
    None,
    /// It stands on a table whose height is known
    Known,
    /// It stands on a table that is found in the first image
    Fit,
}

/// When a scan stops before its last view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct StopConfig {
    /// q_thresh of the paper's eq. (9).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub entropy_share: Option<f64>,
    /// Estimated share of the surface that can be seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub completeness: Option<f64>,
    /// Least share that the next view must be expected to add to what was seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<f64>,
    /// Longest path through the views.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path_length_m: Option<f64>,
    /// Longest time from the first decision on; with it, a scan is not the same every time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
}

/// A rule's name or a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct ViewSpaceName(pub String);

impl ViewSpaceName {
    /// The rule; none if it is a file.
    pub fn rule(&self) -> Option<Rule> {
        Rule::from_str(&self.0, false).ok()
    }
}

/// The unit of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum UnitName {
    /// Metres
    M,
    /// Millimetres
    Mm,
    /// Judged by the longest side: up to 2 it is metres, from 20 on millimetres, in between an error
    Auto,
}

impl From<UnitName> for Unit {
    fn from(name: UnitName) -> Self {
        match name {
            UnitName::M => Self::Metres,
            UnitName::Mm => Self::Millimetres,
            UnitName::Auto => Self::Auto,
        }
    }
}

impl ScanConfig {
    /// The profile's values.
    pub fn of_profile(profile: Profile) -> Self {
        let config = Self {
            object: "builtin:teapot".to_owned(),
            profile,
            planner: PlannerName::MostSurface,
            views: 10,
            candidates: 1000,
            first_view: 0,
            voxel_size_m: None,
            view_space: ViewSpaceName("shell".to_owned()),
            seed: 0,
            view_seed: None,
            unit: UnitName::Auto,
            size_m: None,
            min_overlap: None,
            baselines: true,
            memory_limit_mb: 4096,
            map: MapConfig::default(),
            multi_resolution: MultiResolutionConfig::default(),
            object_box: ObjectBoxConfig::default(),
            reach: ReachConfig::default(),
            motion: MotionConfig::default(),
            registration: RegistrationConfig::default(),
            max_flow: MaxFlowConfig::default(),
            greedy: GreedyConfig::default(),
            batch: BatchConfig::default(),
            nbv_net: NbvNetConfig::default(),
            most_surface: MostSurfaceConfig::default(),
            stop: StopConfig::default(),
            camera: Intrinsics::d435i(),
            noise: NoiseConfig::default(),
            recording: None,
        };
        match profile {
            Profile::Default => config,
            // The box is known and the voxel size fixed, as in the paper's comparison of view quality functions (table I).
            Profile::Paper => Self {
                planner: PlannerName::MaxFlow,
                candidates: 5000,
                voxel_size_m: Some(0.01),
                map: MapConfig { background: Background::Ignore, ..MapConfig::default() },
                max_flow: MaxFlowConfig {
                    ray_spacing: 10.0,
                    free_space: FreeSpace::Fades,
                    ..MaxFlowConfig::default()
                },
                greedy: GreedyConfig { ray_spacing: 10.0, ..GreedyConfig::default() },
                batch: BatchConfig { ray_spacing: 10.0, ..BatchConfig::default() },
                stop: StopConfig { entropy_share: Some(0.5), ..StopConfig::default() },
                ..config
            },
        }
    }

    /// The profile's values (that of `profile`, or else the file's, or else the default one), overridden by a file's.
    pub fn load(profile: Option<Profile>, file: Option<&Path>) -> Result<Self, Failure> {
        let Some(path) = file else { return Ok(Self::of_profile(profile.unwrap_or(Profile::Default))) };
        let text = std::fs::read_to_string(path)
            .map_err(|e| Failure::data(format!("cannot be read: {e}")).in_file(path))?;
        let bad = |e: toml::de::Error| Failure::data(e.to_string().trim_end()).in_file(path);
        let mut table: toml::Table = toml::from_str(&text).map_err(bad)?;
        if let Some(profile) = profile {
            table.insert("profile".to_owned(), toml::Value::try_from(profile).map_err(Failure::data)?);
        }
        Self::from_table(table).map_err(|failure| failure.in_file(path))
    }

    /// The values of the table's profile, or else of the default one, overridden by the table's.
    pub fn from_table(table: toml::Table) -> Result<Self, Failure> {
        let bad = |e: toml::de::Error| Failure::data(e.to_string().trim_end());
        let profile = table.get("profile").cloned().map(toml::Value::try_into::<Profile>).transpose();
        let base = Self::of_profile(profile.map_err(bad)?.unwrap_or(Profile::Default));
        let base = toml::Table::try_from(&base).map_err(Failure::data)?;
        let config: Self = merged(base, table).try_into().map_err(bad)?;
        config.check()?;
        Ok(config)
    }

    /// Whether the scan needs to know what every candidate truly sees.
    pub fn needs_truth(&self) -> bool {
        self.baselines || self.planner == PlannerName::Clairvoyant
    }

    /// What of the configuration decides the setting and its truth; all else is as in the default profile. Scans with equal
    /// ones can share them.
    pub fn of_setting(&self) -> Self {
        let neutral = Self::of_profile(Profile::Default);
        Self {
            profile: neutral.profile,
            planner: neutral.planner,
            views: 1,
            first_view: 0,
            seed: neutral.seed,
            view_seed: Some(self.view_seed()),
            min_overlap: None,
            baselines: self.needs_truth(),
            map: neutral.map,
            max_flow: neutral.max_flow,
            greedy: neutral.greedy,
            batch: neutral.batch,
            nbv_net: neutral.nbv_net,
            most_surface: neutral.most_surface,
            stop: neutral.stop,
            multi_resolution: neutral.multi_resolution,
            registration: neutral.registration,
            motion: neutral.motion,
            object_box: ObjectBoxConfig { rule: neutral.object_box.rule, ..self.object_box },
            ..self.clone()
        }
    }

    /// The planner, which is told the truth if it is known.
    pub fn build_planner(&self, truth: Option<Arc<TrueVisibility>>) -> Result<Box<dyn ViewPlanner>, Failure> {
        let configs = PlannerConfigs {
            most_surface: self.most_surface,
            max_flow: self.max_flow,
            greedy: self.greedy,
            batch: self.batch,
            nbv_net: self.nbv_net.clone(),
        };
        let planner = self.planner.build(configs, self.seed, truth)?;
        match self.min_overlap {
            Some(share) => Ok(Box::new(MinOverlap::new(share, planner)?)),
            None => Ok(planner),
        }
    }

    /// Seed of the random shell.
    pub fn view_seed(&self) -> u64 {
        self.view_seed.unwrap_or(self.seed)
    }

    /// Fails on values out of range that only a file can hold.
    fn check(&self) -> Result<(), Failure> {
        let coarsest = self.multi_resolution.coarsest_voxel_size_m;
        let lengths = [
            ("voxel_size_m", self.voxel_size_m),
            ("size_m", self.size_m),
            ("coarsest_voxel_size_m", coarsest),
        ];
        if let Some(time) = self.stop.time_s.filter(|time| time.is_nan() || *time < 0.0) {
            return Err(Failure::data(format!("time_s is {time}, expected a number of seconds, at least 0")));
        }
        for (name, value) in lengths.into_iter().filter_map(|(name, value)| Some((name, value?))) {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Failure::data(format!(
                    "{name} is {value}, expected a positive number of metres"
                )));
            }
        }
        self.stop.rules(self.views).check()?;
        let q_thresh = self.multi_resolution.q_thresh;
        if !(0.0..=1.0).contains(&q_thresh) {
            return Err(Failure::data(format!("q_thresh is {q_thresh}, expected a number in 0..=1")));
        }
        self.map.sensor_model.check()?;
        self.check_given()?;
        if let Some(share) = self.min_overlap.filter(|share| !(0.0..=1.0).contains(share)) {
            return Err(Failure::data(format!("min_overlap is {share}, expected a number in 0..=1")));
        }
        MaxFlow::new(self.max_flow)?;
        Greedy::<Apora>::new(self.greedy)?; // the parameters are checked alike for every gain
        MostSurface::new(self.most_surface)?;
        Batch::new(self.batch)?;
        self.nbv_net.weights.as_ref().map_or(Ok(()), |_| self.nbv_net.planner().map(drop))
    }

    /// Fails on values that options may have put out of range.
    pub fn check_given(&self) -> Result<(), Failure> {
        self.noise.check()?;
        self.registration.check()?;
        self.motion.check()?;
        self.reach.check()?;
        self.recording.as_ref().map_or(Ok(()), |recording| recording.check(self))
    }

    /// Fails if the planner does not estimate what the scan is to stop by.
    pub fn check_stop(&self) -> Result<(), Failure> {
        let is_estimated = self.stop.completeness.or(self.stop.expected_gain).is_some();
        if is_estimated && self.planner != PlannerName::MostSurface {
            return Err(Failure::usage(format!(
                "the planner {} cannot stop by completeness or expected gain, which it does not estimate",
                self.planner
            ))
            .with_hint("--planner most-surface does"));
        }
        Ok(())
    }

    /// Fails if the configuration does not fit this number of candidates.
    pub fn check_views(&self, n_views: usize) -> Result<(), Failure> {
        if self.first_view >= n_views {
            let (first, last) = (self.first_view, n_views - 1);
            let failure = Failure::usage(format!("--first-view is {first}, expected 0 to {last}"));
            return Err(match self.reach.is_default() {
                true => failure,
                false => failure.with_hint("only candidates within reach count; they are numbered anew"),
            });
        }
        if self.views == 0 || self.views > n_views {
            return Err(Failure::usage(format!(
                "--views is {}, expected 1 to {n_views} (the candidates)",
                self.views
            )));
        }
        Ok(())
    }
}

/// The first table with the second's values in place of its own. A value replaces its whole sum type, so that a file
/// may choose another kind of lens.
pub(crate) fn merged(mut base: toml::Table, over: toml::Table) -> toml::Table {
    for (key, value) in over {
        let value = match (base.remove(&key), value) {
            (Some(toml::Value::Table(base)), toml::Value::Table(over)) if key != "distortion" => {
                toml::Value::Table(merged(base, over))
            }
            (_, value) => value,
        };
        base.insert(key, value);
    }
    base
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str) -> Result<ScanConfig, String> {
        let path =
            std::env::temp_dir().join(format!("nextview-config-{:?}.toml", std::thread::current().id()));
        std::fs::write(&path, text).unwrap();
        let config = ScanConfig::load(None, Some(&path));
        std::fs::remove_file(&path).unwrap();
        config.map_err(|e| e.to_string())
    }

    #[test]
    fn what_is_saved_loads_to_the_same() {
        for profile in [Profile::Paper, Profile::Default] {
            let config = ScanConfig::of_profile(profile);
            assert_eq!(load(&toml::to_string(&config).unwrap()), Ok(config));
        }
    }

    #[test]
    fn a_file_overrides_its_profile() {
        let config = load("profile = \"paper\"\nviews = 3\n[max_flow]\ngamma = 0.25\n").unwrap();
        assert_eq!((config.views, config.candidates, config.max_flow.gamma), (3, 5000, 0.25));
        assert_eq!(config.max_flow.ray_spacing, 10.0);
    }

    #[test]
    fn the_candidates_may_have_their_own_seed() {
        let seeds = |text: &str| load(text).map(|config| (config.seed, config.view_seed()));
        assert_eq!(seeds("seed = 3\n"), Ok((3, 3)));
        assert_eq!(seeds("seed = 3\nview_seed = 0\n"), Ok((3, 0)));
    }

    #[test]
    fn unknown_fields_and_wrong_values_are_named() {
        assert!(load("voxels = 3\n").unwrap_err().contains("voxels"));
        assert!(load("[object_box]\ntable = \"oak\"\n").unwrap_err().contains("fit"));
        assert!(load("[map]\nrays = \"some\"\n").unwrap_err().contains("every-point"));
        assert!(load("views = \n").unwrap_err().contains("line 1"));
        for (text, expected) in [
            ("voxel_size_m = nan\n", "voxel_size_m is NaN"),
            ("size_m = -1\n", "size_m is -1"),
            ("[stop]\nentropy_share = 7\n", "entropy_share is 7"),
            ("[map.sensor_model]\nhit = 0.2\n", "hit is 0.2"),
            ("[max_flow]\ngamma = 2\n", "gamma is 2"),
            ("[multi_resolution]\nq_thresh = 1.5\n", "q_thresh is 1.5"),
            ("[multi_resolution]\ncoarsest_voxel_size_m = -1\n", "coarsest_voxel_size_m is -1"),
            ("[greedy]\ntheta = -1\n", "theta is -1"),
            ("[noise]\npose_error_mm = -1\n", "pose_error_mm is -1, expected 0 to 1000"),
            ("[noise.depth]\nedge_loss = 2\n", "edge_loss is 2"),
            ("[motion]\nspeed_m_per_s = 0\n", "motion.speed_m_per_s is 0, expected 0.001 to 100"),
            ("[motion]\nacceleration_m_per_s2 = nan\n", "motion.acceleration_m_per_s2 is NaN"),
            ("[motion]\nclearance_m = -1\n", "motion.clearance_m is -1, expected a number from 0 on"),
            ("[motion]\nsensing_time_s = inf\n", "motion.sensing_time_s is inf"),
            ("[reach]\nmax_radius_m = 1\n", "reach.base_m and reach.max_radius_m need each other"),
            ("[reach]\nmin_radius_m = 1\n", "reach.min_radius_m needs reach.base_m"),
            ("[reach]\nbase_m = [0, 0, 0]\nmax_radius_m = -1\n", "reach: reach is 0 to -1 m, expected"),
            ("[reach]\nallowed_boxes_m = [[0, 0, 0, 1, 1, -1]]\n", "the lowest first"),
            ("[reach]\nforbidden_boxes_m = [[0, 0]]\n", "invalid length 2"),
            ("min_overlap = 2\n", "min_overlap is 2"),
            ("[registration]\nspacing_mm = 0\n", "spacing_mm is 0"),
            ("[registration]\nposition_uncertainty_mm = -1\n", "position_uncertainty_mm is -1"),
            ("[registration]\nrotation_uncertainty_deg = 181\n", "rotation_uncertainty_deg is 181"),
            ("[registration]\nmin_overlap = 2\n", "registration.min_overlap is 2"),
            ("[batch]\nn_views = 0\n", "n_views is 0"),
            ("[batch]\nleast_share = 2\n", "least_share is 2"),
            ("[nbv_net]\nweights = 'no-such-file'\n", "no-such-file: cannot be read"),
        ] {
            let error = load(text).unwrap_err();
            assert!(error.contains(".toml: ") && error.contains(expected), "{error}");
        }
    }
}
