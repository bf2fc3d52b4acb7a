/// A file of numbers next to the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DataFile {
    /// A row per variant and measure.
    Statistics,
    /// A row per variant and number of views.
    Progress,
    /// A row per object and variant.
    Objects,
    /// A row per pair of variants and measure.
    Differences,
    /// A row per variant and class of estimates, or number of views ahead.
    Estimates,
}
