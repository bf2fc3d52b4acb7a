use super::views::N_VIEWS;

/// Channels before, between and after the convolutions.
pub(super) const CHANNELS: [usize; 4] = [1, 10, 12, 8];

/// Units before, between and after the fully connected layers.
pub(super) const UNITS: [usize; 6] = [512, 1500, 500, 100, 50, N_VIEWS];

/// Names of the layers in the published network, and the shapes of their weights.
pub(super) fn layout() -> impl Iterator<Item = (String, Vec<usize>)> {
    let convolutions =
        CHANNELS.windows(2).zip(1..).map(|(n, i)| (format!("conv{i}"), vec![n[1], n[0], 3, 3, 3]));
    convolutions.chain(UNITS.windows(2).zip(1..).map(|(n, i)| (format!("fc{i}"), vec![n[1], n[0]])))
}
