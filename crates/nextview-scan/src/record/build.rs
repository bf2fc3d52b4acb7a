use serde::{Deserialize, Serialize};
use std::fmt;

/// The build of the program that made a record. Records of different builds must not be mixed in one
/// campaign.
///
/// Optional features do not change results, so none is named here.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BuildIdentity {
    /// Version of the program.
    pub version: String,
    /// The first 12 digits of the commit; if the sources differ from it, `+` and a hash of them. Without a
    /// repository, the hash alone after `sources-`.
    pub source: String,
}

impl BuildIdentity {
    /// The identity of this program.
    pub fn this() -> Self {
        let (version, source) = (env!("CARGO_PKG_VERSION"), env!("NEXTVIEW_SOURCE"));
        Self { version: version.to_owned(), source: source.to_owned() }
    }
}

impl fmt::Display for BuildIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.version, self.source)
    }
}
