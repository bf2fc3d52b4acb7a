use crate::{Failure, stdout};
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use std::fmt::Write;
use std::io::{IsTerminal, stderr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two lines where there is no terminal to show a bar on.
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// How far a campaign is, on stderr: a bar, or else a line now and then.
pub(super) struct Progress {
    bar: ProgressBar,
    /// When the last line was; none where there is a bar.
    last_line: Option<Mutex<Instant>>,
}

impl Progress {
    /// A campaign of this many runs, of which some are done already.
    pub fn new(n_runs: usize, n_done: usize) -> Self {
        let style = ProgressStyle::with_template("{pos} of {len} runs [{bar:30}] {elapsed} ({left})");
        let style = style.expect("the template is well formed");
        let left = move |state: &ProgressState, writer: &mut dyn Write| {
            // Before the first run there is nothing to judge by, and nobody to tell if a line cannot be drawn.
            let _ = match state.pos() > n_done as u64 {
                true => write!(writer, "{:#} left", HumanDuration(state.eta())),
                false => write!(writer, "looking at the first object"),
            };
        };
        let bar = ProgressBar::new(n_runs as u64).with_style(style.with_key("left", left));
        bar.set_position(n_done as u64);
        bar.reset_eta();
        bar.enable_steady_tick(Duration::from_millis(200));
        let last_line = (!stderr().is_terminal()).then(|| Mutex::new(Instant::now()));
        Self { bar, last_line }
    }

    /// A run is done.
    pub fn step(&self) {
        self.bar.inc(1);
        let Some(last_line) = &self.last_line else { return };
        let mut last_line = last_line.lock().unwrap_or_else(PoisonError::into_inner);
        let (n_done, n_runs) = (self.bar.position(), self.bar.length().unwrap_or_default());
        if last_line.elapsed() >= BETWEEN_LINES && n_done < n_runs {
            *last_line = Instant::now();
            eprintln!("{n_done} of {n_runs} runs, about {} left", HumanDuration(self.bar.eta()));
        }
    }

    /// Prints to stdout, which may be the same terminal.
    pub fn print(&self, text: &str) -> Result<(), Failure> {
        self.bar.suspend(|| stdout::print(text))
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
