use serde::{Deserialize, Serialize};
use std::fmt;

/// Which build of the program made a record. Records of different builds must not be mixed in one campaign.
///
/// No optional feature changes results, so that none is named here.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BuildIdentity {
    /// Version of the program.
    pub version: String,
    /// The first 12 digits of the commit, with `+` and a hash of the sources where they differ from it; of a
    /// build without a repository, the hash alone behind `sources-`.
    pub source: String,
}

impl BuildIdentity {
    /// That of this program.
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
