//! Progress of long work: a bar on a terminal, nothing in a pipe.

use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use dermis::report;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::console::Console;

/// A bar that follows stages, and the time that each stage took.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    stages: Mutex<Vec<Stage>>,
}

/// A stage of the preparation, from its first word to the next stage's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage {
    pub(crate) name: &'static str,
    pub(crate) begin: Instant,
    pub(crate) end: Instant,
}

impl Progress {
    /// Hidden where standard error is no terminal (indicatif's own test) or the user wants quiet.
    pub(crate) fn new(console: &Console) -> Self {
        let target = if console.quiet() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let style = ProgressStyle::with_template("{msg:<24} {bar:32} {pos}/{len} {elapsed}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self {
            bar,
            stages: Mutex::new(Vec::new()),
        }
    }

    /// Shows `progress`; safe to call from several threads.
    pub(crate) fn show(&self, progress: report::Progress) {
        let now = Instant::now();
        let mut stages = self.stages.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = stages.last_mut() {
            last.end = now;
        }
        if stages.iter().all(|s| s.name != progress.stage) {
            self.bar.set_message(progress.stage);
            stages.push(Stage {
                name: progress.stage,
                begin: now,
                end: now,
            });
        }
        self.bar.set_length(progress.total as u64);
        self.bar.set_position(progress.done as u64);
    }

    /// Removes the bar; the stages in the order in which they began.
    pub(crate) fn finish(self) -> Vec<Stage> {
        self.bar.finish_and_clear();
        let mut stages = self
            .stages
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = stages.last_mut() {
            last.end = Instant::now();
        }
        stages
    }
}
