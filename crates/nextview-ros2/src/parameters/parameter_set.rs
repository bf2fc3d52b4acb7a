use super::RosArguments;
use nextview::sensor::Intrinsics;
use nextview_scan::{Faults, ScanConfig, merged, nested};
use std::path::PathBuf;
use toml::{Table, Value};

/// The settings of the node, derived from its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// The world frame of boxes, views and maps. Default `map`.
    pub global_frame: String,
    /// Whether poses come from transforms instead of the topic `pose`. Default true.
    pub use_tf_transforms: bool,
    /// The folder of the scan: its journal, and its results. By default, nothing is kept.
    pub directory: Option<PathBuf>,
    /// Whether to take an image as soon as the camera rests near the next view. Default false.
    pub auto_capture: bool,
    /// Maximum distance from the next view in metres. Default 0.01.
    pub capture_distance: f64,
    /// Maximum angle between actual and wanted viewing direction in radians. Default 3 degrees.
    pub capture_angle: f64,
    /// Maximum wait in seconds for an image and its pose. Default 5.
    pub capture_timeout: f64,
    /// All other parameters: keys of a configuration.
    config: Table,
}

/// Parameters named differently in octomap_server and nvblox than in a configuration.
const OTHER_NAMES: [(&str, &str); 8] = [
    ("voxel_size", "voxel_size_m"),
    ("resolution", "voxel_size_m"),
    ("sensor_model.max_range", "live.max_depth_m"),
    ("sensor_model.hit", "map.sensor_model.hit"),
    ("sensor_model.miss", "map.sensor_model.miss"),
    ("sensor_model.min", "map.sensor_model.clamp_min"),
    ("sensor_model.max", "map.sensor_model.clamp_max"),
    ("frame_id", "global_frame"),
];

impl Parameters {
    /// Builds the settings from the arguments.
    ///
    /// # Errors
    /// All invalid values, one per line.
    pub fn new(arguments: &RosArguments) -> Result<Self, String> {
        let mut faults = Vec::new();
        let mut own = Table::new();
        let mut config = Table::new();
        for (name, value) in &arguments.parameters {
            let key =
                OTHER_NAMES.iter().find(|(other, _)| other == name).map_or(name.as_str(), |(_, key)| key);
            match key {
                // ROS sets it for every node of a simulation; stamps of images are the only clock here.
                "use_sim_time" => (),
                "camera" | "recording" | "object" | "sensor" => {
                    faults
                        .push(format!("`{name}` is not a parameter: images and camera_info come on topics"));
                }
                _ if OWN.contains(&key) => _ = own.insert(key.to_owned(), value.clone()),
                _ => config = merged(config, nested(key, value.clone())),
            }
        }
        let mut read = ParameterReader { own: &own, faults: &mut faults };
        let parameters = Self {
            global_frame: read.text("global_frame").unwrap_or_else(|| "map".to_owned()),
            use_tf_transforms: read.truth("use_tf_transforms").unwrap_or(true),
            directory: read.text("directory").filter(|path| !path.is_empty()).map(PathBuf::from),
            auto_capture: read.truth("auto_capture").unwrap_or(false),
            capture_distance: read.positive("capture_distance_m").unwrap_or(0.01),
            capture_angle: read.positive("capture_angle_deg").unwrap_or(3.0).to_radians(),
            capture_timeout: read.positive("capture_timeout_s").unwrap_or(5.0),
            config,
        };
        if parameters.global_frame.is_empty() {
            faults.push("`global_frame` is empty, expected the name of a frame".to_owned());
        }
        if let Err(refused) = parameters.scan_config(Intrinsics::d435i()) {
            faults.extend(refused.iter().map(|fault| match &fault.remedy {
                Some(remedy) => format!("{fault}: {remedy}"),
                None => fault.to_string(),
            }));
        }
        if faults.is_empty() { Ok(parameters) } else { Err(faults.join("\n")) }
    }

    /// The configuration of a scan with this camera.
    pub fn scan_config(&self, camera: Intrinsics) -> Result<ScanConfig, Faults> {
        let named = nested("object", Value::String("object".to_owned()));
        let live = nested("live", Value::Table(Table::new()));
        let mut config = ScanConfig::from_table(merged(merged(named, live), self.config.clone()))?;
        config.camera = camera;
        // Opening the camera checks all other requirements of a scan.
        nextview_scan::OwnCamera::open(&mut config.clone())?;
        Ok(config)
    }
}

/// The parameters that are not keys of a configuration.
const OWN: [&str; 7] = [
    "global_frame",
    "use_tf_transforms",
    "directory",
    "auto_capture",
    "capture_distance_m",
    "capture_angle_deg",
    "capture_timeout_s",
];

/// Reads the node's own parameters, and records faults in their types.
struct ParameterReader<'a> {
    own: &'a Table,
    faults: &'a mut Vec<String>,
}

impl ParameterReader<'_> {
    fn text(&mut self, name: &str) -> Option<String> {
        self.get(name, "a string", |value| value.as_str().map(str::to_owned))
    }

    fn truth(&mut self, name: &str) -> Option<bool> {
        self.get(name, "true or false", Value::as_bool)
    }

    fn positive(&mut self, name: &str) -> Option<f64> {
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|number| number as f64));
        self.get(name, "a positive number", |value| {
            number(value).filter(|number| *number > 0.0 && number.is_finite())
        })
    }

    fn get<T>(&mut self, name: &str, expected: &str, read: impl Fn(&Value) -> Option<T>) -> Option<T> {
        let value = self.own.get(name)?;
        let found = read(value);
        if found.is_none() {
            self.faults.push(format!("`{name}` is {value}, expected {expected}"));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(text: &str) -> Result<Parameters, String> {
        let words = text.split_whitespace().flat_map(|given| ["-p".to_owned(), given.to_owned()]);
        Parameters::new(&RosArguments::parse(words).unwrap())
    }

    const BOX: &str = "live.box_m:=[0,0,0,0.2,0.2,0.2]";

    #[test]
    fn names_of_other_nodes_are_understood() {
        let text =
            format!("{BOX} frame_id:=base resolution:=0.01 sensor_model.max_range:=2 sensor_model.hit:=0.8");
        let parameters = parameters(&text).unwrap();
        let config = parameters.scan_config(Intrinsics::d435i()).unwrap();
        let live = config.source.live().unwrap();
        assert_eq!((parameters.global_frame.as_str(), config.voxel_size_m), ("base", Some(0.01)));
        assert_eq!(
            (live.max_depth_m, config.map.sensor_model.hit, parameters.auto_capture),
            (2.0, 0.8, false)
        );
    }

    #[test]
    fn all_faults_are_told_at_once() {
        let text = "auto_capture:=3 capture_timeout_s:=-1 global_frame:='' camera.width:=3 camera:=x";
        let error = parameters(&format!("{BOX} {text}")).unwrap_err();
        for expected in
            ["`auto_capture` is 3, expected true or false", "`capture_timeout_s` is -1", "`global_frame`"]
        {
            assert!(error.contains(expected), "{expected}: {error}");
        }
        let unknown = parameters(&format!("{BOX} viewz:=3")).unwrap_err();
        assert!(unknown.contains("viewz") && unknown.contains("views"), "{unknown}");
        // The object's place must be known somehow.
        assert!(parameters("views:=3").unwrap_err().contains("live.box_m"));
    }
}
