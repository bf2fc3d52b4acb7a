use crate::Failure;
use crate::scan::{ScanConfig, TableRule};
use glam::DVec3;
use nextview::geometry::Aabb;
use nextview_recording::ReadOptions;
use serde::{Deserialize, Serialize};

/// What decides a scan of recorded frames, besides what decides every scan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct RecordingConfig {
    /// The box that the object lies in, by its lowest and its highest corner; without it, the box grows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub box_m: Option<[f64; 6]>,
    /// Height of the table that the object stands on; without it, there is none, or one is found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table_z_m: Option<f64>,
    /// A mesh of the true object, in the unit of the scan's `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<String>,
    /// A file of the matrix that takes points of the recording to the mesh; without it, they are in the same place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth_from_world: Option<String>,
    /// How the files are read.
    pub read: ReadOptions,
}

impl RecordingConfig {
    /// The box, if it is known.
    pub fn bounds(&self) -> Option<Aabb> {
        self.box_m
            .map(|[x0, y0, z0, x1, y1, z1]| Aabb { min: DVec3::new(x0, y0, z0), max: DVec3::new(x1, y1, z1) })
    }

    /// Fails on what is out of range, and on what only a simulation can be told.
    pub fn check(&self, config: &ScanConfig) -> Result<(), Failure> {
        if let Some(Aabb { min, max }) = self.bounds()
            && !(min.is_finite() && max.is_finite() && min.cmplt(max).all())
        {
            let problem = "expected finite corners, the lowest first";
            return Err(Failure::usage(format!("box_m is {min} to {max}, {problem}")));
        }
        if let Some(z) = self.table_z_m.filter(|z| !z.is_finite()) {
            return Err(Failure::usage(format!("table_z_m is {z}, expected a finite number of metres")));
        }
        if self.table_z_m.is_some() && config.object_box.table != TableRule::None {
            return Err(Failure::usage("table_z_m states the table, so that there is none to be found")
                .with_hint("leave out one of --table-z-m and --table"));
        }
        if self.truth.is_none() && self.truth_from_world.is_some() {
            return Err(Failure::usage("truth_from_world needs truth, the mesh that it leads to"));
        }
        let neutral = ScanConfig::of_profile(config.profile);
        let untold = [
            ("candidates", config.candidates == neutral.candidates),
            ("view_space", config.view_space == neutral.view_space),
            ("view_seed", config.view_seed == neutral.view_seed),
            ("size_m", config.size_m == neutral.size_m),
            ("noise", config.noise == neutral.noise),
            ("table", config.object_box.table != TableRule::Known),
        ];
        let told = untold.into_iter().find(|(_, is_neutral)| !is_neutral);
        told.map_or(Ok(()), |(name, _)| {
            let hint = match name {
                "table" => "--table-z-m states its height, --table fit finds it in the first image",
                _ => "recorded frames are as they are; leave it out",
            };
            Err(Failure::usage(format!("{name} is for simulations, not for recorded frames")).with_hint(hint))
        })
    }
}
