//! Progress on stderr.

mod bar;
mod campaign;

pub(crate) use bar::Progress;
pub(crate) use campaign::CampaignProgress;

#[cfg(test)]
mod tests {
    use super::*;
    use indicatif::{ProgressBar, ProgressDrawTarget, TermLike};
    use std::io;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU16, Ordering};

    /// Default number of terminal columns.
    const WIDTH: u16 = 80;

    /// A terminal that records the longest line written to it.
    #[derive(Clone, Debug, Default)]
    struct Screen(Arc<AtomicU16>);

    /// Length of the longest line of a bar at the beginning and near the end.
    fn widest_line(bar: &ProgressBar) -> u16 {
        let screen = Screen::default();
        bar.set_draw_target(ProgressDrawTarget::term_like(Box::new(screen.clone())));
        bar.force_draw();
        bar.set_position(bar.length().unwrap_or_default() - 1);
        bar.force_draw();
        screen.0.load(Ordering::Relaxed)
    }

    impl TermLike for Screen {
        fn width(&self) -> u16 {
            WIDTH
        }

        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn write_line(&self, text: &str) -> io::Result<()> {
            self.write_str(text)
        }

        fn write_str(&self, text: &str) -> io::Result<()> {
            let widest = text.lines().map(|line| line.chars().count()).max().unwrap_or_default();
            self.0.fetch_max(u16::try_from(widest).unwrap_or(u16::MAX), Ordering::Relaxed);
            Ok(())
        }

        fn clear_line(&self) -> io::Result<()> {
            Ok(())
        }

        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn no_line_wraps() {
        for progress in [
            Progress::new("scanning", 10_000),
            Progress::new("scanning objects", 1_000_000),
            Progress::of_baselines(100_000),
        ] {
            assert_eq!(widest_line(&progress.0), WIDTH);
        }
    }

    #[test]
    fn no_line_of_a_campaign_wraps() {
        let progress = CampaignProgress::new(1_000_000);
        assert_eq!(widest_line(&progress.bar), WIDTH);
        progress.begin(500_000);
        assert_eq!(widest_line(&progress.bar), WIDTH);
    }
}
