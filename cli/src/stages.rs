//! A long job as a person at a terminal sees it: what is being done now, and afterwards
//! how long each stage took.

use crate::output;
use crate::signals::{self, Patient};
use dynamics_codegen::diagnostic::visible;
use identify::trace::{Ended, Progress, Stage};
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use std::fmt::Write;
use std::io;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Shows the current stage on standard error, if that is a terminal, and keeps the time.
#[derive(Debug)]
pub struct Stages {
    bar: ProgressBar,
    clock: Mutex<Clock>,
    began: Instant,
    limit: Option<Duration>,
    /// While a job runs an interrupt asks it to end early.
    patient: Mutex<Option<Patient>>,
}

#[derive(Debug)]
struct Clock {
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

impl Stages {
    /// Starts the clock of a job that is to take no longer than a limit, if there is one.
    ///
    /// # Errors
    /// If the system will not let us wait for an interrupt.
    pub fn new(limit: Option<Duration>) -> io::Result<Self> {
        // Hidden by itself where standard error is not a terminal.
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed:>4}{prefix} {wide_msg}")
        {
            bar.set_style(style);
        }
        if let Some(limit) = limit {
            bar.set_prefix(format!(" of at most {}", HumanDuration(limit)));
        }
        bar.enable_steady_tick(Duration::from_millis(120));
        Ok(Self {
            bar,
            clock: Mutex::new(Clock {
                current: None,
                spent: Vec::new(),
            }),
            began: Instant::now(),
            limit,
            patient: Mutex::new(Some(Patient::begin()?)),
        })
    }

    /// `12.3 s: smooth 0.5 s, derive 1.1 s, …`; takes the line at the terminal away.
    pub fn finish(&self) -> String {
        self.bar.finish_and_clear();
        *self.patient.lock().unwrap_or_else(PoisonError::into_inner) = None;
        let mut clock = self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        clock.stop();
        let mut line = format!("{:.1} s:", self.began.elapsed().as_secs_f64());
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

    fn ended(&self) -> Option<Ended> {
        let is_late = self
            .limit
            .is_some_and(|limit| self.began.elapsed() >= limit);
        match () {
            () if signals::asked_to_end() => Some(Ended::Interrupt),
            () if is_late => Some(Ended::TimeLimit),
            () => None,
        }
    }
}
