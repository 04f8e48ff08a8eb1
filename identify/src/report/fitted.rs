//! What a fit found as one page with figures: a file of its own that needs nothing else.

use super::chart::{AFTER, BEFORE, Chart, ChartError, Layer, MEASURED, Mark};
use super::figures::{Figure, broken, force_unit, line, named};
use super::html::{PageError, diff_lines, environment};
use super::stated_unit;
use crate::fit::{Curves, Fit, ForceSeries, page, percent, rows};
use crate::number::short;
use dynamics_codegen::Model;
use minijinja::value::Serde;

/// What a page is made from.
#[derive(Debug, Clone, Copy)]
pub struct FitPage<'a> {
    /// What was found.
    pub fit: &'a Fit,
    /// The model that was fitted.
    pub model: &'a Model,
    /// The model's file.
    pub file: &'a str,
    /// The log that was learnt from.
    pub log: &'a str,
    /// The change to the file, as a unified diff.
    pub diff: &'a str,
    /// The command that reads the model in the report's folder, where its effects have to be
    /// named.
    pub reading: Option<&'a str>,
    /// The command that gives this page again.
    pub command: &'a str,
}

/// The page: plain HTML with inline figures, without scripts, the same for the same fit.
///
/// # Errors
/// If a figure cannot be drawn or the page not be put together.
pub fn fit_html(page: &FitPage<'_>) -> Result<String, PageError> {
    let FitPage { fit, model, .. } = *page;
    let environment = environment()?;
    let template = environment.get_template("fitted.html")?;
    let figures = |draw: &dyn Fn(&Curves, &ForceSeries, &str) -> Result<Figure, ChartError>| {
        let each = fit.curves.coordinates.iter().map(|series| {
            let mut positions = model.positions().into_iter();
            let own = positions.find(|c| c.name == series.name);
            draw(
                &fit.curves,
                series,
                &stated_unit(&own.map_or(String::new(), |c| c.unit)),
            )
        });
        each.collect::<Result<Vec<Figure>, ChartError>>()
            .map_err(PageError::Figure)
    };
    let rows: Vec<[String; 6]> = rows(fit)
        .iter()
        .map(|row| {
            let share = |error: f64| percent(100.0 * error / row.measured);
            [
                row.name.to_string(),
                short(row.before),
                share(row.before),
                short(row.after),
                share(row.after),
                short(row.floor),
            ]
        })
        .collect();
    let contents = serde_json::json!({
        "file": page.file,
        "log": page.log,
        "sentence": sentence(fit),
        "rows": rows,
        "samples": fit.samples,
        "found": self::page(fit),
        "forces": figures(&over_time)?,
        "speeds": figures(&over_speed)?,
        "diff": diff_lines(page.diff),
        "reading": page.reading,
        "warnings": fit.warnings,
        "command": page.command,
    });
    Ok(template.render(Serde(contents))?)
}

/// What was found, in one sentence.
fn sentence(fit: &Fit) -> String {
    let names = fit
        .terms
        .iter()
        .map(|t| format!("{} ({})", t.term, t.on.join(", ")));
    let names: Vec<String> = names.collect();
    let errors = [fit.before.total, fit.after.total].map(short);
    let [before, after] = errors;
    match (names.is_empty() && fit.inertial.is_empty(), fit.worse) {
        (true, _) => "No term predicts what it was not fitted to: nothing is missing.".to_string(),
        (_, true) => format!("What fits this log makes other motion worse: {before} to {after}."),
        _ => format!("The error of the forces falls from {before} to {after}."),
    }
}

/// The force that was measured, and what either model makes of it.
fn over_time(curves: &Curves, series: &ForceSeries, unit: &str) -> Result<Figure, ChartError> {
    let predicted = |left: &[f64]| -> Vec<f64> {
        let pairs = series.measured.iter().zip(left);
        pairs.map(|(measured, left)| measured - left).collect()
    };
    let along = |values: &[f64]| broken(&curves.t, values);
    let chart = Chart {
        x: "time [s]".into(),
        y: format!("force, {} [{}]", series.name, force_unit(unit)),
        layers: vec![
            Layer {
                mark: Mark::Broad,
                colour: MEASURED,
                points: along(&series.measured),
            },
            line(BEFORE, along(&predicted(&series.before))),
            line(AFTER, along(&predicted(&series.after))),
        ],
        ..Chart::default()
    };
    named(&series.name, &chart)
}

/// What either model leaves of it, against the velocity.
fn over_speed(_: &Curves, series: &ForceSeries, unit: &str) -> Result<Figure, ChartError> {
    let scatter = |colour, left: &[f64]| Layer {
        mark: Mark::Dots,
        colour,
        points: series
            .velocity
            .iter()
            .copied()
            .zip(left.iter().copied())
            .collect(),
    };
    let chart = Chart {
        x: format!("velocity of {} [{unit}/s]", series.name),
        y: format!("missing force, {} [{}]", series.name, force_unit(unit)),
        layers: vec![
            scatter(BEFORE, &series.before),
            scatter(AFTER, &series.after),
        ],
        ..Chart::default()
    };
    named(&series.name, &chart)
}
