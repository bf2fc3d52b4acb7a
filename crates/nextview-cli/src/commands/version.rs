use nextview_scan::BuildIdentity;
use std::sync::LazyLock;

/// The version, with the build as in the records of campaigns, its target and its profile.
pub(super) fn long() -> &'static str {
    static LONG: LazyLock<String> = LazyLock::new(|| {
        let BuildIdentity { version, source } = BuildIdentity::this();
        format!("{version} ({source}, {}, {})", env!("NEXTVIEW_TARGET"), env!("NEXTVIEW_PROFILE"))
    });
    &LONG
}
