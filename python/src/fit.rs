//! `fit`: inertias, friction and couplings of a machine whose forces were measured.

use crate::error::{Error, raised};
use crate::log::{Recording, Recordings};
use crate::model::Model;
use crate::report::Report;
use crate::terms::Equations;
use crate::wait::wait;
use cli::commands::fit::{Change, Found};
use cli::mistake::Mistake;
use identify::fit::{Inertia, Request, Source, fit};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Fits logs; the package's `fit` says what the arguments are.
#[pyfunction(name = "fit")]
pub fn fit_logs(
    py: Python<'_>,
    model: &Model,
    train: Vec<Recording>,
    test: Vec<Recording>,
    map: Option<PathBuf>,
    choices: (String, Vec<String>, bool),
    call: String,
) -> PyResult<Report> {
    let (inertia, leave_out, trust_columns) = choices;
    let inertia = match inertia.as_str() {
        "fixed" => Inertia::Fixed,
        "linear" => Inertia::Linear,
        "consistent" => Inertia::Consistent,
        other => {
            let message =
                format!("`inertia` is \"fixed\", \"linear\" or \"consistent\", not {other:?}");
            return Err(Error::new_err(message));
        }
    };
    let recordings = Recordings { train, test, map };
    let (equations, values) = (Arc::clone(&model.equations), model.values.clone());
    let choices = Choices {
        inertia,
        leave_out,
        trust_columns,
    };
    let work = move || found(equations, &values, recordings, &choices, &call);
    wait(py, &Arc::new(AtomicBool::new(false)), work)?.map_err(|error| raised(&error))
}

/// What may be chosen.
struct Choices {
    inertia: Inertia,
    leave_out: Vec<String>,
    trust_columns: bool,
}

fn found(
    equations: Arc<Equations>,
    values: &[f64],
    recordings: Recordings,
    choices: &Choices,
    call: &str,
) -> anyhow::Result<Report> {
    let loaded = equations.with_values(values);
    let (text, path) = loaded.text();
    let (train, test) = recordings.read(&loaded.compiled.model)?;
    let name = path.display().to_string();
    let request = Request {
        source: Source {
            name: &name,
            text: &text,
            library: &loaded.library,
        },
        compiled: &loaded.compiled,
        parameters: &loaded.parameters,
        train: &train,
        test: test.as_ref(),
        inertia: choices.inertia,
        leave_out: &choices.leave_out,
        trust_columns: choices.trust_columns,
    };
    let mut fitted = fit(&request).map_err(|error| Mistake::new(error.to_string()))?;
    let change = Change::new(&mut fitted, &request, &loaded, &path)?;
    let (portable, html) = change.html(&fitted, &request, call)?;
    let series = serde_json::to_string(&fitted.curves)?;
    let (changed, diff) = (change.text.clone(), change.diff.clone());
    let found = Found {
        fit: Some(fitted),
        comparison: None,
    };
    Ok(Report {
        json: serde_json::to_string_pretty(&found)?,
        summary: found.summary(),
        series,
        diff,
        html,
        text: changed,
        more: Vec::new(),
        portable,
        equations,
    })
}
