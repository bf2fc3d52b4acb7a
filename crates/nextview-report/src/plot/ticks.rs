//! Round numbers along an axis.

/// View 1 and round numbers, at most about ten.
pub(crate) fn view_ticks(n_views: usize) -> Vec<usize> {
    let round = (0..).flat_map(|e| [1, 2, 5].map(|m| m * 10_usize.pow(e)));
    let step = round.into_iter().find(|step| n_views / step <= 10).unwrap_or(1);
    let rest = (1..=n_views / step).map(|i| i * step).filter(|&view| view > 1);
    std::iter::once(1).chain(rest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_and_round() {
        assert_eq!(view_ticks(4), [1, 2, 3, 4]);
        assert_eq!(view_ticks(12), [1, 2, 4, 6, 8, 10, 12]);
        assert_eq!(view_ticks(100), [1, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100]);
    }
}
