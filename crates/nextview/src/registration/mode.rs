use serde::{Deserialize, Serialize};

/// When a session aligns frames: `false`, `"auto"` or `true` in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(from = "Written", into = "Written")]
pub enum RegistrationMode {
    /// Never: poses are used as given.
    Off,
    /// Once the frames show that the given poses are wrong; all frames are aligned then, those observed
    /// before included. Until then, poses are used as given, to the bit. Alignment is given up if it fails
    /// for at least five frames and more than half of all.
    Auto,
    /// Always.
    On,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "expected true, false or \"auto\"")]
enum Written {
    Always(bool),
    When(When),
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
enum When {
    Auto,
}

impl From<Written> for RegistrationMode {
    fn from(written: Written) -> Self {
        match written {
            Written::Always(false) => Self::Off,
            Written::When(When::Auto) => Self::Auto,
            Written::Always(true) => Self::On,
        }
    }
}

impl From<RegistrationMode> for Written {
    fn from(mode: RegistrationMode) -> Self {
        match mode {
            RegistrationMode::Off => Self::Always(false),
            RegistrationMode::Auto => Self::When(When::Auto),
            RegistrationMode::On => Self::Always(true),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_is_a_switch_or_auto() {
        use RegistrationMode::{Auto, Off, On};
        for (mode, written) in [(Off, "false"), (Auto, "\"auto\""), (On, "true")] {
            assert_eq!(serde_json::to_string(&mode).unwrap(), written);
            assert_eq!(serde_json::from_str::<RegistrationMode>(written).unwrap(), mode);
        }
        let error = serde_json::from_str::<RegistrationMode>("\"always\"").unwrap_err().to_string();
        assert!(error.contains("expected true, false or \"auto\""), "{error}");
    }
}
