use super::{
    BoxRule, NbvNetConfig, PlannerChoice, PlannerName, Profile, ReachConfig, ReferenceConfig, RobotConfig,
    SizeOf, SourceConfig, TableRule, TurntableConfig, UnitName, ViewSpaceName,
};
use crate::Fault;
use nextview::geometry::Aabb;
use nextview::map::{Background, RayRule, SensorModel};
use nextview::motion::MotionConfig;
use nextview::planner::{BatchConfig, GreedyConfig, MaxFlowConfig, MostSurfaceConfig, RayConfig};
use nextview::registration::{RegistrationConfig, RegistrationMode};
use nextview::sensor::{Intrinsics, SurfaceNoise};
use nextview::session::{MultiResolutionConfig, StopConfig};
use nextview::surface::LooksGoal;
use nextview::visibility::FreeSpace;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::path::{Path, PathBuf};

/// Default maximum number of views.
const DEFAULT_VIEWS: usize = 10;

/// The configuration of a scan: the content of a configuration file, and of `config.toml` in the results.
///
/// Numbers are in SI units, and their keys say so. [`ScanConfig::parse`] reads a file.
// The library's types could check themselves on reading, but would fail without naming the key: `check` does
// that for all of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields, remote = "Self")]
pub struct ScanConfig {
    /// A mesh file or `builtin:NAME`; with a recording, its path; with a user's camera, the name of the
    /// object.
    pub object: String,
    /// The profile that provides the defaults of all other values.
    pub profile: Profile,
    /// The planner that chooses the next view.
    pub planner: PlannerChoice,
    /// Maximum number of views. Default: 10, or all candidates if there are fewer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<usize>,
    /// Number of view candidates that a rule generates.
    pub candidates: usize,
    /// Number of the first view among the candidates, from 0; in a recording, its place among the frames in
    /// use.
    pub first_view: usize,
    /// Edge of a voxel. Default: about a fortieth of the object's longest side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxel_size_m: Option<f64>,
    /// View space: the name of a rule, or a file of poses.
    pub view_space: ViewSpaceName,
    /// Distance of a rule's candidates, except the shell's, from the object's middle. Default: 3 x size.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_distance_m: Option<f64>,
    /// The view distance in excess of half the diagonal of the object's box, instead of `view_distance_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_standoff_m: Option<f64>,
    /// Seed of the planners random and receding-horizon and, without `view_seed`, of the random shell.
    pub seed: u64,
    /// Seed of the random views that define skill 0. With the same number, `seed` gives different draws.
    pub baseline_seed: u64,
    /// Seed of the random shell alone: random planners with different seeds can share candidates. Default:
    /// `seed`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_seed: Option<u64>,
    /// Unit of the mesh file.
    pub unit: UnitName,
    /// Length to which the object is scaled: its longest side, or the length that `size_of` names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_m: Option<f64>,
    /// The length that `size_m` sets.
    #[serde(skip_serializing_if = "SizeOf::is_default")]
    pub size_of: SizeOf,
    /// Minimum share, 0..=1, of known surface in the next view; 0 for none. Default: 0.5 with registration,
    /// which cannot align frames without overlap, except for the planner in-order; otherwise none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_overlap: Option<f64>,
    /// Required accuracy of the surface in each voxel: the standard deviation of its expected error along the
    /// normal. The planner most-surface spends views on it. By default, no second looks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal_mm: Option<f64>,
    /// Required number of looks at each part of the surface. The planner most-surface spends views on it. By
    /// default, no second looks.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "looks")]
    pub looks: Option<LooksGoal>,
    /// Whether to compute the random and clairvoyant curves.
    pub baselines: bool,
    /// Limit on the memory for the planning box.
    pub memory_limit_mb: u64,
    /// Maximum time from the first decision, at least 0; makes a scan irreproducible. By default, no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_limit_s: Option<f64>,
    /// The results of a scan of the same object, which was turned afterwards. Once the turn is found, that
    /// scan's frames are added to map and model. This disables baselines: other planners would not know that
    /// scan's content. In a file, a path that begins with `..` is relative to the file's folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<PathBuf>,
    /// How frames are integrated into the map.
    pub map: MapConfig,
    /// Coarse-to-fine planning.
    #[serde(deserialize_with = "MultiResolutionConfig::deserialize")]
    pub multi_resolution: MultiResolutionConfig,
    /// Prior knowledge of the object's place.
    pub object_box: ObjectBoxConfig,
    /// Options of the final mesh.
    #[serde(skip_serializing_if = "ModelConfig::is_default")]
    pub model: ModelConfig,
    /// Where a robot can hold the camera.
    #[serde(skip_serializing_if = "ReachConfig::is_default")]
    pub reach: ReachConfig,
    /// The arm that holds the camera or the object. By default, the camera can be anywhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotConfig>,
    /// Motion model of a robot, if no arm is stated.
    #[serde(deserialize_with = "MotionConfig::deserialize")]
    pub motion: MotionConfig,
    /// Whether and how frames are aligned to earlier measurements.
    #[serde(deserialize_with = "RegistrationConfig::deserialize")]
    pub registration: RegistrationConfig,
    /// Parameters of the planner most-surface.
    #[serde(deserialize_with = "MostSurfaceConfig::deserialize")]
    pub most_surface: MostSurfaceConfig,
    /// Parameters of the planners max-flow and local.
    #[serde(deserialize_with = "MaxFlowConfig::deserialize")]
    pub max_flow: MaxFlowConfig,
    /// Parameters of all planners named after a gain, and of gains written in Python.
    #[serde(deserialize_with = "GreedyConfig::deserialize")]
    pub greedy: GreedyConfig,
    /// Parameters of the planner frontier-tour.
    #[serde(deserialize_with = "RayConfig::deserialize")]
    pub frontier_tour: RayConfig,
    /// Parameters of the planner receding-horizon.
    #[serde(deserialize_with = "RayConfig::deserialize")]
    pub receding_horizon: RayConfig,
    /// Parameters of the planner kaba.
    #[serde(deserialize_with = "RayConfig::deserialize")]
    pub kaba: RayConfig,
    /// Parameters of the planner batch.
    #[serde(deserialize_with = "BatchConfig::deserialize")]
    pub batch: BatchConfig,
    /// Parameters of the planner nbv-net.
    pub nbv_net: NbvNetConfig,
    /// The CAD model of the part, required by the planner inspection.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceConfig>,
    /// When the scan stops before its last view.
    #[serde(deserialize_with = "StopConfig::deserialize")]
    pub stop: StopConfig,
    /// Depth camera, which sets the defaults of `camera` and `noise`. Without one, these are the optics of
    /// the D435i, and no noise. For recorded and live frames, `noise.depth` is the known error, which
    /// `goal_mm` requires, and is not simulated.
    #[cfg(feature = "simulated")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<super::SensorName>,
    /// The camera's optics.
    pub camera: Intrinsics,
    /// Errors of the simulated camera.
    #[cfg(feature = "simulated")]
    pub noise: super::NoiseConfig,
    /// Where the frames come from: the keys `recording` and `live`.
    // These are read by `source_keys`.
    #[serde(flatten, skip_deserializing)]
    #[cfg_attr(feature = "schema", schemars(!skip_deserializing))]
    pub source: SourceConfig,
    /// A turntable that turns the object in front of a fixed camera: candidates are its angles. Requires
    /// `live` and `view_space` = ring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turntable: Option<TurntableConfig>,
}

/// How frames are integrated into the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct MapConfig {
    /// The rays of a frame to trace.
    pub rays: RayRule,
    /// Effect of rays past the object.
    pub background: Background,
    /// How measurements change the log-odds of voxels.
    #[serde(deserialize_with = "SensorModel::deserialize")]
    pub sensor_model: SensorModel,
}

/// The object's place, as known to planning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ObjectBoxConfig {
    /// How the object's box is determined.
    pub rule: BoxRule,
    /// The surface below the object.
    pub table: TableRule,
    /// Maximum gap between parts of the object if the box grows, 0..=1000. By default, they must touch.
    #[serde(skip_serializing_if = "is_zero")]
    pub max_gap_m: f64,
}

/// Options of the final mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ModelConfig {
    /// Whether to close the mesh where nothing was measured, for printing. A column of its file marks these
    /// vertices. By default, it stays open.
    pub watertight: bool,
}

impl ModelConfig {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Reads looks; the configuration checks their ranges.
fn looks<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<LooksGoal>, D::Error> {
    #[derive(Deserialize)]
    struct Unchecked(#[serde(deserialize_with = "LooksGoal::deserialize")] LooksGoal);
    Ok(Option::<Unchecked>::deserialize(deserializer)?.map(|Unchecked(looks)| looks))
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl ScanConfig {
    /// Returns the profile's values.
    pub fn of_profile(profile: Profile) -> Self {
        let config = Self {
            object: "builtin:teapot".to_owned(),
            profile,
            planner: PlannerName::MostSurface.into(),
            views: None,
            candidates: 1000,
            first_view: 0,
            voxel_size_m: None,
            view_space: ViewSpaceName("shell".to_owned()),
            view_distance_m: None,
            view_standoff_m: None,
            seed: 0,
            baseline_seed: 0,
            view_seed: None,
            unit: UnitName::Auto,
            size_m: None,
            size_of: SizeOf::default(),
            min_overlap: None,
            goal_mm: None,
            looks: None,
            baselines: true,
            memory_limit_mb: 4096,
            time_limit_s: None,
            after: None,
            map: MapConfig::default(),
            multi_resolution: MultiResolutionConfig::default(),
            object_box: ObjectBoxConfig::default(),
            model: ModelConfig::default(),
            reach: ReachConfig::default(),
            robot: None,
            motion: MotionConfig::default(),
            registration: RegistrationConfig::default(),
            max_flow: MaxFlowConfig::default(),
            greedy: GreedyConfig::default(),
            frontier_tour: RayConfig::default(),
            receding_horizon: RayConfig::default(),
            kaba: RayConfig::default(),
            batch: BatchConfig::default(),
            nbv_net: NbvNetConfig::default(),
            reference: None,
            most_surface: MostSurfaceConfig::default(),
            stop: StopConfig::default(),
            #[cfg(feature = "simulated")]
            sensor: None,
            camera: Intrinsics::d435i(),
            #[cfg(feature = "simulated")]
            noise: super::NoiseConfig::default(),
            source: SourceConfig::Simulated,
            turntable: None,
        };
        match profile {
            Profile::Default => config,
            // A known box and a fixed voxel size, as in the paper's comparison of view quality functions
            // (table I).
            Profile::Paper => Self {
                planner: PlannerName::MaxFlow.into(),
                candidates: 5000,
                voxel_size_m: Some(0.01),
                map: MapConfig { background: Background::Ignore, ..MapConfig::default() },
                max_flow: MaxFlowConfig {
                    ray_spacing: 10.0,
                    free_space: FreeSpace::Fades,
                    ..MaxFlowConfig::default()
                },
                greedy: GreedyConfig { ray_spacing: 10.0, ..GreedyConfig::default() },
                frontier_tour: RayConfig { ray_spacing: 10.0 },
                receding_horizon: RayConfig { ray_spacing: 10.0 },
                kaba: RayConfig { ray_spacing: 10.0 },
                batch: BatchConfig { ray_spacing: 10.0, ..BatchConfig::default() },
                stop: StopConfig { entropy_share: Some(0.5), progress: 0.0, ..StopConfig::default() },
                ..config
            },
        }
    }

    /// The folder for the results of this scan if those of both placements go to another one. Fails if the
    /// object has no table.
    pub fn first_placement(&self, results: &Path) -> Result<PathBuf, Fault> {
        if self.object_box.table == TableRule::None {
            let fault = Fault::request("an object without a table has no underside to turn up");
            return Err(fault.with_remedy("`object_box.table` = fit lets the scan find its table"));
        }
        let mut dir = results.as_os_str().to_owned();
        dir.push("-placement-1");
        Ok(dir.into())
    }

    /// The scan that continues this one, whose results are in a folder, with new camera errors.
    pub fn going_on_after(mut self, results: PathBuf) -> Self {
        self.after = Some(results);
        #[cfg(feature = "simulated")]
        {
            self.noise.seed = self.noise.seed.wrapping_add(1);
        }
        self
    }

    /// Sets the penalty on long moves of all planners that have one.
    pub fn set_theta(&mut self, theta: f64) {
        self.most_surface.theta = theta;
        self.max_flow.theta = theta;
        self.greedy.theta = theta;
        self.batch.theta = theta;
    }

    /// Sets the CAD model of the part and keeps the demands on its surfaces.
    pub fn set_reference(&mut self, mesh: PathBuf) {
        match &mut self.reference {
            Some(reference) => reference.mesh = mesh,
            None => self.reference = Some(ReferenceConfig::of(mesh)),
        }
    }

    /// Whether the scan requires the truth: the surface that every candidate truly sees.
    pub fn needs_truth(&self) -> bool {
        self.baselines && self.after.is_none() || self.planner.properties().needs_truth
    }

    /// Maximum number of views for this number of candidates.
    pub fn max_views(&self, n_candidates: usize) -> usize {
        self.views.unwrap_or(DEFAULT_VIEWS.min(n_candidates))
    }

    /// All files and folders named by the configuration that a scan reads.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let is_file = match &self.source {
            SourceConfig::Simulated => !self.object.starts_with("builtin:"),
            SourceConfig::Recording(_) => true,
            SourceConfig::Live(_) => false,
        };
        let object = is_file.then_some(&self.object);
        let views = self.view_space.rule().is_none().then_some(&self.view_space.0);
        let recording = self.source.recording().into_iter();
        let truth = recording.flat_map(|recording| [&recording.truth, &recording.truth_from_world]).flatten();
        let named = object.into_iter().chain(views).chain(truth).map(PathBuf::from);
        let named = named.chain(self.reference.iter().map(|reference| reference.mesh.clone()));
        let named = named.chain(self.nbv_net.weights.clone()).chain(self.after.clone());
        let urdf = self.robot.iter().filter_map(|robot| robot.file());
        let named = named.chain(urdf.map(PathBuf::from));
        #[cfg(feature = "simulated")]
        let named = named.chain(self.sensor.iter().filter_map(|sensor| Some(sensor.file()?.to_owned())));
        named.collect()
    }

    /// The part of the configuration that determines the simulated object and its truth; the rest is as in
    /// the default profile. Scans with equal parts can share them.
    pub fn of_object(&self) -> Self {
        let neutral = Self::of_profile(Profile::Default);
        Self {
            profile: neutral.profile,
            planner: neutral.planner,
            views: Some(1),
            first_view: 0,
            seed: neutral.seed,
            baseline_seed: neutral.baseline_seed,
            view_seed: Some(self.view_seed()),
            min_overlap: None,
            goal_mm: None,
            looks: None,
            baselines: self.needs_truth(),
            map: neutral.map,
            max_flow: neutral.max_flow,
            greedy: neutral.greedy,
            frontier_tour: neutral.frontier_tour,
            receding_horizon: neutral.receding_horizon,
            kaba: neutral.kaba,
            batch: neutral.batch,
            nbv_net: neutral.nbv_net,
            reference: None,
            most_surface: neutral.most_surface,
            stop: neutral.stop,
            time_limit_s: None,
            multi_resolution: neutral.multi_resolution,
            registration: neutral.registration,
            motion: neutral.motion,
            model: neutral.model,
            object_box: ObjectBoxConfig { table: self.object_box.table, ..neutral.object_box },
            ..self.clone()
        }
    }

    /// When frames are aligned. By default, those of a camera or a recording as soon as their poses disagree,
    /// and others never.
    pub(crate) fn registration_mode(&self) -> RegistrationMode {
        let is_simulated = self.source.is_simulated();
        let usual = if is_simulated { RegistrationMode::Off } else { RegistrationMode::Auto };
        self.registration.enabled.unwrap_or(usual)
    }

    /// The random error of the camera, as far as it is configured.
    pub fn surface_error(&self) -> SurfaceNoise {
        #[cfg(feature = "simulated")]
        if let Some(depth) = self.noise.noise().depth {
            return depth.surface_error();
        }
        SurfaceNoise::default()
    }

    /// The configured distance of candidates from the middle of an object with this box, in metres.
    pub(crate) fn view_distance(&self, bounds: &Aabb) -> Option<f64> {
        let beyond_box = self.view_standoff_m.map(|standoff| 0.5 * bounds.size().length() + standoff);
        self.view_distance_m.or(beyond_box)
    }

    /// Seed of the random shell.
    pub fn view_seed(&self) -> u64 {
        self.view_seed.unwrap_or(self.seed)
    }
}

impl Serialize for ScanConfig {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl Default for ScanConfig {
    fn default() -> Self {
        Self::of_profile(Profile::Default)
    }
}
