//! The part of a configuration that a sensor sets.

use super::load::read_over;
use super::{NoiseConfig, NoiseModel, Positions, ScanConfig, SensorName, read_value};
use crate::{Fault, Faults, files};
use nextview::sensor::{Intrinsics, Sensor};
use nextview_sim::noise::SensorNoise;
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::Table;

/// Maximum size of a sensor file in bytes: a hundred times that of one with all keys.
const MAX_BYTES: u64 = 1 << 16;

impl ScanConfig {
    /// Sets optics, range and noise to those of the sensor. Fails if there is no such sensor.
    pub fn set_sensor(&mut self, name: SensorName) -> Result<(), Faults> {
        let camera = SensorOptics::load(&name)?;
        self.sensor = Some(name);
        self.camera = camera.intrinsics;
        self.noise.model = NoiseModel::Sensor;
        self.noise.depth = camera.depth;
        Ok(())
    }

    /// Whether there is noise beyond the error of the sensor, which a real camera has anyway.
    pub(super) fn simulates_noise(&self) -> bool {
        let NoiseConfig { model, depth, .. } = match self.sensor {
            Some(_) => self.noise,
            None => NoiseConfig::default(),
        };
        self.noise != NoiseConfig { model, depth, ..NoiseConfig::default() }
    }

    /// The fault of combining a sensor with the noise model, if any.
    pub(super) fn of_sensor(&self) -> Option<Fault> {
        match (&self.sensor, self.noise.model) {
            (None, NoiseModel::Sensor) => {
                let fault = Fault::request("`noise.model` = sensor needs a `sensor`");
                let fault = fault.with_remedy("name one, or use `noise.model` = d435i");
                Some(Fault { key: Some("noise.model".to_owned()), ..fault })
            }
            (Some(SensorName(name)), NoiseModel::D435i) => {
                let fault =
                    Fault::request(format!("`noise.model` = d435i is not the noise of the `sensor` {name}"));
                let fault = fault.with_remedy("leave one of them out");
                Some(Fault { key: Some("noise.model".to_owned()), ..fault })
            }
            _ => None,
        }
    }
}

/// Optics and depth noise of a sensor.
struct SensorOptics {
    intrinsics: Intrinsics,
    depth: SensorNoise,
}

impl SensorOptics {
    /// Fails if there is no such sensor, or the file does not describe one.
    fn load(name: &SensorName) -> Result<Self, Faults> {
        match name.file() {
            Some(file) => {
                let text = files::read_text(file, MAX_BYTES)?;
                of_text(&text, file)
            }
            None => name.0.parse().map(Self::of).map_err(|error| match error {
                nextview::Error::InvalidParameter { value, expected, .. } => {
                    Fault::of_value("sensor", value, format!("{expected}, or a .toml file")).into()
                }
                error => error.into(),
            }),
        }
    }

    fn of(sensor: Sensor) -> Self {
        Self { intrinsics: sensor.intrinsics(), depth: SensorNoise::of(sensor) }
    }
}

/// The file of a sensor; missing values are those of the sensor it is like.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorFile {
    like: String,
    camera: Intrinsics,
    noise: NoiseSection,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NoiseSection {
    #[serde(deserialize_with = "SensorNoise::deserialize")]
    depth: SensorNoise,
}

fn of_text(text: &str, file: &Path) -> Result<SensorOptics, Faults> {
    let (positions, mut table) = Positions::read(text, Some(file))?;
    let placed = |fault| positions.place(fault, "");
    let like = table.get("like").ok_or_else(|| {
        let message = "`like` is missing, expected the name of a similar sensor";
        Fault { key: Some("like".to_owned()), ..Fault::data(message) }
    });
    let like: String = like.and_then(|like| read_value("like", like)).map_err(placed)?;
    let sensor: Sensor = like.parse().map_err(|error| placed(of_like(error)))?;
    let SensorOptics { intrinsics, depth } = SensorOptics::of(sensor);
    let base = SensorFile { like, camera: intrinsics, noise: NoiseSection { depth } };
    let base = Table::try_from(base).map_err(Fault::data)?;
    let mut faults = Vec::new();
    let out_of_range = |file: &SensorFile| {
        file.noise.depth.check().err().map(|e| Fault::of_part("noise.depth", e)).into_iter().collect()
    };
    let read = read_over(&base, &mut table, out_of_range, &mut faults);
    match read {
        Some(SensorFile { camera, noise, .. }) if faults.is_empty() => {
            Ok(SensorOptics { intrinsics: camera, depth: noise.depth })
        }
        _ => Err(Faults::of(faults.into_iter().map(placed).collect()).expect("what is not read is at fault")),
    }
}

/// The fault of an unknown sensor name.
fn of_like(error: nextview::Error) -> Fault {
    match error {
        nextview::Error::InvalidParameter { value, expected, .. } => Fault::of_value("like", value, expected),
        error => error.into(),
    }
}
