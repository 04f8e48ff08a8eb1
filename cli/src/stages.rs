//! A long job as a person at a terminal sees it: what is being done now, and afterwards
//! how long each stage took.

use crate::output;
use dynamics_codegen::diagnostic::visible;
use identify::trace::{Progress, Stage};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Write;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shows the current stage on standard error, if that is a terminal, and keeps the time.
#[derive(Debug)]
pub struct Stages {
    bar: ProgressBar,
    clock: Mutex<Clock>,
}

#[derive(Debug)]
struct Clock {
    began: Instant,
    current: Option<(Stage, Instant)>,
    /// In the order of their first appearance.
    spent: Vec<(Stage, Duration)>,
}

impl Clock {
    fn stop(&mut self) {
        let Some((stage, since)) = self.current.take() else {
            return;
        };
        match self.spent.iter_mut().find(|(known, _)| *known == stage) {
            Some((_, spent)) => *spent += since.elapsed(),
            None => self.spent.push((stage, since.elapsed())),
        }
    }
}

impl Default for Stages {
    fn default() -> Self {
        Self::new()
    }
}

impl Stages {
    /// Starts the clock.
    pub fn new() -> Self {
        // Hidden by itself where standard error is not a terminal.
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed:>4} {wide_msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Self {
            bar,
            clock: Mutex::new(Clock {
                began: Instant::now(),
                current: None,
                spent: Vec::new(),
            }),
        }
    }

    /// `12.3 s: smooth 0.5 s, derive 1.1 s, …`; takes the line at the terminal away.
    pub fn finish(&self) -> String {
        self.bar.finish_and_clear();
        let mut clock = self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        clock.stop();
        let mut line = format!("{:.1} s:", clock.began.elapsed().as_secs_f64());
        for (index, (stage, spent)) in clock.spent.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            // Writing to a string cannot fail.
            let _ = write!(line, "{comma} {stage} {:.1} s", spent.as_secs_f64());
        }
        line
    }
}

impl Progress for Stages {
    fn enter(&self, stage: Stage, found: &[String]) {
        let mut clock = self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        clock.stop();
        clock.current = Some((stage, Instant::now()));
        let found = match found {
            [] => String::new(),
            found => format!(" ({})", found.join(", ")),
        };
        let message = format!("{stage}{found}");
        self.bar.set_message(visible(&message).into_owned());
    }

    fn notice(&self, text: &str) {
        // Above the line of progress, if there is one.
        self.bar.suspend(|| output::complain(text));
    }
}
