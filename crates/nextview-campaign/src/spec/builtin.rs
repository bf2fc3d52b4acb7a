//! The specifications of the paper's tables and of other authors' protocols.

const SPECS: [(&str, &str, &str); 9] = [
    ("paper-1", "table I: voxel coverage of all planners", include_str!("specs/paper-1.toml")),
    (
        "paper-2",
        "table II: time and memory; run it with one job at a time",
        include_str!("specs/paper-2.toml"),
    ),
    ("paper-3", "table III: planning from coarse voxels to fine ones", include_str!("specs/paper-3.toml")),
    ("paper-4", "table IV: gamma, with and without history", include_str!("specs/paper-4.toml")),
    ("paper-5", "table V: q_thresh, the threshold for finer voxels", include_str!("specs/paper-5.toml")),
    ("paper-6", "table VI: only the planners compared", include_str!("specs/paper-6.toml")),
    ("paper-7", "table VII: theta, the weight of movement", include_str!("specs/paper-7.toml")),
    (
        "objview",
        "the protocol of ObjView-Bench, whole sphere: 30 moves among 360 candidates",
        include_str!("specs/objview.toml"),
    ),
    (
        "pb-nbv",
        "the protocol of PB-NBV, all around: ten views among 800 candidates",
        include_str!("specs/pb-nbv.toml"),
    ),
];

/// Lists the name and purpose of each.
pub fn list() -> impl Iterator<Item = (&'static str, &'static str)> {
    SPECS.iter().map(|(name, about, _)| (*name, *about))
}

/// Returns the specification with this name, as TOML.
pub fn by_name(name: &str) -> Option<&'static str> {
    SPECS.iter().find(|(known, ..)| *known == name).map(|(.., text)| *text)
}
