use crate::{Failure, stdout};
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A progress bar on stderr; nothing if stderr is not a terminal. It disappears on drop.
pub(crate) struct Progress(pub(super) ProgressBar);

/// The bar uses the width left by the texts: a wrapped line would be redrawn below itself again and again.
const BAR: &str = "{msg} [{wide_bar}] {pos}/{len}, {elapsed} ({eta} left)";

impl Progress {
    pub fn new(work: &'static str, n: usize) -> Self {
        Self::of_template(BAR, work, n)
    }

    /// Shows the rendering of every view before a simulated scan, below a line that explains it.
    pub fn of_baselines(n_views: usize) -> Self {
        let reason = "Before the scan, to measure coverage and skill (see --baselines):";
        Self::of_template(&format!("{reason}\n{BAR}"), "rendering every view", n_views)
    }

    fn of_template(template: &str, work: &'static str, n: usize) -> Self {
        let style = ProgressStyle::with_template(template);
        let bar = ProgressBar::new(n as u64).with_style(style.expect("the template is well formed"));
        bar.set_message(work);
        // A single step may take long; the clock shows activity.
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    pub fn step(&self) {
        self.0.inc(1);
    }

    /// Prints a message to stderr.
    pub fn warn(&self, message: &str) {
        self.0.suspend(|| eprintln!("{message}"));
    }

    /// Prints to stdout, which may be the same terminal.
    pub fn print(&self, text: &str) -> Result<(), Failure> {
        self.0.suspend(|| stdout::print(text))
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
