//! The command line options for configuration keys, and paths in commands.

use std::borrow::Cow;
use std::path::Path;

/// Keys and their options.
const FLAGS: [(&str, &str); 55] = [
    ("planner", "--planner"),
    ("most_surface.per_second", "--per-second"),
    ("views", "--views"),
    ("stop.completeness", "--complete"),
    ("stop.path_length_m", "--max-path-m"),
    ("time_limit_s", "--max-time-s"),
    ("after", "--after"),
    ("candidates", "--candidates"),
    ("first_view", "--first-view"),
    ("voxel_size_m", "--voxel-size-m"),
    ("multi_resolution.enabled", "--multi-resolution"),
    ("object_box.rule", "--box"),
    ("object_box.max_gap_m", "--max-gap-m"),
    ("object_box.table", "--table"),
    ("sensor", "--sensor"),
    ("noise.model", "--noise"),
    ("noise.pose_error_mm", "--pose-error-mm"),
    ("noise.pose_error_deg", "--pose-error-deg"),
    ("registration.enabled", "--register"),
    ("min_overlap", "--min-overlap"),
    ("goal_mm", "--goal-mm"),
    ("looks", "--looks"),
    ("looks.n", "--looks"),
    ("reference.mesh", "--reference"),
    ("view_space", "--view-space"),
    ("model.watertight", "--watertight"),
    ("reach", "--reach"),
    ("robot.arm", "--robot"),
    ("robot.world_from_base", "--robot-base"),
    ("robot.flange_from_camera", "--hand-eye"),
    ("seed", "--seed"),
    ("profile", "--profile"),
    ("unit", "--unit"),
    ("size_m", "--size-m"),
    ("center", "--center"),
    ("baselines", "--baselines"),
    ("recording", "--frames"),
    ("recording.box_m", "--box-m"),
    ("recording.table_z_m", "--table-z-m"),
    ("recording.truth", "--truth"),
    ("recording.truth_from_world", "--truth-from-world"),
    ("recording.read.pose_columns", "--pose-columns"),
    ("recording.read.camera_axes", "--camera-axes"),
    ("recording.read.poses", "--poses"),
    ("jobs", "--jobs"),
    ("out", "--out"),
    ("force", "--force"),
    ("resume", "--resume"),
    ("shard", "--shard"),
    ("visited", "--visited"),
    ("box", "--box"),
    ("listen", "--listen"),
    ("token_file", "--token-file"),
    ("host", "--host"),
    ("dir", "--dir"),
];

/// Keys in messages that only a configuration file can set.
const FILE_KEYS: [&str; 16] = [
    "memory_limit_mb",
    "size_of",
    "view_distance_m",
    "view_standoff_m",
    "view_seed",
    "reach.base_m",
    "reach.min_radius_m",
    "reach.max_radius_m",
    "robot.home",
    "robot.base_from_camera",
    "robot.flange_from_world",
    "recording.read.depth_topic",
    "recording.read.pose_topic",
    "recording.read.pose_tolerance_s",
    "recording.read.world_frame",
    "recording.read.color_topic",
];

/// Replaces the keys in a text, which are in backticks, by options: `` `table` = fit `` becomes `--table
/// fit`, and true becomes on. Other keys are those of a configuration file.
pub(crate) fn word(text: &str) -> String {
    let mut worded = String::new();
    let mut parts = text.split('`');
    worded += parts.next().unwrap_or_default();
    while let Some(key) = parts.next() {
        let Some(rest) = parts.next() else { return worded + "`" + key };
        match FLAGS.iter().find(|(known, _)| *known == key) {
            Some((_, flag)) => {
                worded += flag;
                worded += &match (rest.strip_prefix(" = "), rest.strip_prefix(" = true")) {
                    (_, Some(rest)) => format!(" on{rest}"),
                    (Some(value), None) => format!(" {value}"),
                    (None, None) => rest.to_owned(),
                };
            }
            None if FILE_KEYS.contains(&key) => worded += &format!("{key} in --config{rest}"),
            // A quotation.
            None => worded += &format!("`{key}`{rest}"),
        }
    }
    worded
}

/// Quotes a path for a shell.
pub(crate) fn quoted(path: &Path) -> String {
    let path = path.display().to_string();
    shlex::try_quote(&path).map(Cow::into_owned).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_become_options() {
        assert_eq!(
            word("use a larger `voxel_size_m`, or `memory_limit_mb`"),
            "use a larger --voxel-size-m, or memory_limit_mb in --config"
        );
        assert_eq!(word("`object_box.table` = fit finds it"), "--table fit finds it");
        assert_eq!(word("`registration.enabled` = true aligns"), "--register on aligns");
        assert_eq!(word("integer `7`, expected"), "integer `7`, expected");
        assert_eq!(word("frame a`b"), "frame a`b");
    }
}
