//! `trace`: what a log says that a model lacks.

use crate::error::{Error, raised};
use crate::log::{Recording, Recordings};
use crate::model::Model;
use crate::report::Report;
use crate::terms::Equations;
use crate::wait::wait;
use cli::commands::trace::Found;
use cli::mistake::Mistake;
use identify::machine::Hold;
use identify::trace::{Ended, Progress, Request, Stage, TraceError, trace};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What is asked beside model and logs.
struct Wish {
    hold: Option<Hold>,
    horizon: f64,
    seed: u64,
    trust_columns: bool,
    /// What the page says was called.
    call: String,
}

/// Until when a search goes on.
#[derive(Debug)]
struct Patience {
    began: Instant,
    limit: Option<Duration>,
    interrupted: Arc<AtomicBool>,
}

impl Progress for Patience {
    fn enter(&self, _: Stage, _: &[String]) {}

    fn notice(&self, _: &str) {}

    fn ended(&self) -> Option<Ended> {
        let is_late = self
            .limit
            .is_some_and(|limit| self.began.elapsed() >= limit);
        match () {
            () if self.interrupted.load(Ordering::SeqCst) => Some(Ended::Interrupt),
            () if is_late => Some(Ended::TimeLimit),
            () => None,
        }
    }
}

/// Traces logs; the package's `trace` says what the arguments are.
#[pyfunction(name = "trace")]
#[allow(clippy::too_many_arguments)]
pub fn trace_logs(
    py: Python<'_>,
    model: &Model,
    train: Vec<Recording>,
    test: Vec<Recording>,
    map: Option<PathBuf>,
    hold: Option<&str>,
    horizon: f64,
    seed: u64,
    time_limit: f64,
    trust_columns: bool,
    call: String,
) -> PyResult<Report> {
    if !(horizon > 0.0 && horizon.is_finite()) {
        let message = format!("`horizon={horizon}` is not a duration; give seconds, such as 0.5");
        return Err(Error::new_err(message));
    }
    let hold = match hold {
        None => None,
        Some("linear") => Some(Hold::Linear),
        Some("previous") => Some(Hold::Previous),
        Some(other) => {
            let message = format!("`hold` is \"linear\" or \"previous\", not {other:?}");
            return Err(Error::new_err(message));
        }
    };
    let limit = match time_limit == f64::INFINITY {
        true => None,
        false => Some(Duration::try_from_secs_f64(time_limit).map_err(|_| {
            Error::new_err(format!(
                "`time_limit={time_limit}` is not a duration; give seconds, or `math.inf`"
            ))
        })?),
    };
    let interrupted = Arc::new(AtomicBool::new(false));
    let patience = Patience {
        began: Instant::now(),
        limit,
        interrupted: Arc::clone(&interrupted),
    };
    let wish = Wish {
        hold,
        horizon,
        seed,
        trust_columns,
        call,
    };
    let recordings = Recordings { train, test, map };
    let (equations, values) = (Arc::clone(&model.equations), model.values.clone());
    let work = move || found(equations, &values, recordings, &wish, &patience);
    wait(py, &interrupted, work)?.map_err(|error| raised(&error))
}

fn found(
    equations: Arc<Equations>,
    values: &[f64],
    recordings: Recordings,
    wish: &Wish,
    patience: &Patience,
) -> anyhow::Result<Report> {
    let loaded = equations.with_values(values);
    let model = &loaded.compiled.model;
    let (text, path) = loaded.text();
    let (train, test) = recordings.read(model)?;
    let name = loaded.path.display().to_string();
    let outcome = trace(&Request {
        model_name: &name,
        model_text: &text,
        library: &loaded.library,
        parameters: loaded.overrides(),
        train: &train,
        test: test.as_ref(),
        hold: wish.hold,
        horizon: wish.horizon,
        seed: wish.seed,
        trust_columns: wish.trust_columns,
        progress: patience,
    })
    .map_err(|error| match error {
        TraceError::Model(report) => Mistake::from(*report),
        other => Mistake::new(other.to_string()),
    })?;
    let found = Found::new(outcome, &loaded, &text, &path)?;
    let html = found.html(model, &wish.call)?;
    let processes = found.processes().into_iter();
    let more = processes.map(|(name, text)| (name, text.to_owned()));
    let more = more.collect();
    Ok(Report {
        series: serde_json::to_string(&found.outcome.details)?,
        html,
        more,
        json: found.json,
        summary: found.summary,
        diff: found.diff,
        text: found.outcome.patched_model,
        portable: found.portable,
        equations,
    })
}
