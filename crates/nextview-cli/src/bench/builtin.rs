//! The specifications of the paper's tables.

const SPECS: [(&str, &str, &str); 7] = [
    ("paper-1", "table I: voxel coverage of all planners", include_str!("specs/paper-1.toml")),
    ("paper-2", "table II: time and memory; run it with --jobs 1", include_str!("specs/paper-2.toml")),
    ("paper-3", "table III: planning from coarse voxels to fine ones", include_str!("specs/paper-3.toml")),
    ("paper-4", "table IV: gamma, with and without history", include_str!("specs/paper-4.toml")),
    ("paper-5", "table V: q_thresh, when to go over to finer voxels", include_str!("specs/paper-5.toml")),
    ("paper-6", "table VI: the compared planners alone", include_str!("specs/paper-6.toml")),
    ("paper-7", "table VII: theta, the weight of movement", include_str!("specs/paper-7.toml")),
];

/// The names.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    SPECS.iter().map(|(name, ..)| *name)
}

/// The specification with this name, as TOML.
pub(super) fn by_name(name: &str) -> Option<&'static str> {
    SPECS.iter().find(|(known, ..)| *known == name).map(|(.., text)| *text)
}

/// Name and purpose of each, a line each.
pub(crate) fn list() -> String {
    SPECS.iter().map(|(name, about, _)| format!("{name}  {about}\n")).collect()
}
