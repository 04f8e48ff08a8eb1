//! The outcome as one page with figures: a file of its own that needs nothing else.

use super::figures::{Figure, Figures};
use super::unnamed;
use super::{
    BY_FORCES, after_name, at, elsewhere, headline, hold, is_stopped, scores, stated_unit,
    would_tell,
};
use crate::number::{short, unsigned_zero};
use crate::trace::with_places;
use crate::trace::{Basis, Finding, Outcome, Score, Verdict};
use dynamics_codegen::Model;
use dynamics_codegen::dimension::shown_unit;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};
use serde::Serialize;

/// What a page is made from.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// What was found.
    pub outcome: &'a Outcome,
    /// The model that was traced.
    pub model: &'a Model,
    /// The model's file.
    pub file: &'a str,
    /// The change to the file, as a unified diff.
    pub diff: &'a str,
    /// The command that reads the model in the report's folder, where its effects have to be
    /// named.
    pub reading: Option<&'a str>,
    /// The command that gives this page again.
    pub command: &'a str,
}

/// Why a page could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// A figure could not be drawn.
    #[error("a figure of the report could not be drawn: {0}")]
    Figure(Box<dyn std::error::Error + Send + Sync>),
    /// The page's text could not be put together.
    #[error("the page of the report could not be put together: {0}")]
    Template(#[from] minijinja::Error),
}

/// A line of the table of errors.
#[derive(Debug, Serialize)]
struct Row {
    name: String,
    unit: String,
    before: String,
    after: String,
    floor: String,
    /// Whether it opens a group.
    total: bool,
}

#[derive(Debug, Serialize)]
struct Found {
    name: String,
    evidence: String,
    parameters: Vec<[String; 4]>,
    rivals: Vec<[String; 3]>,
    same_on: Option<String>,
    figure: Option<Figure>,
}

/// Candidates listed at most.
const CANDIDATES: usize = 20;

/// The page: plain HTML with inline figures, without scripts, the same for the same outcome.
///
/// # Errors
/// If a figure cannot be drawn or the page not be put together.
pub fn html(page: &Page<'_>) -> Result<String, PageError> {
    let Page { outcome, model, .. } = *page;
    let environment = environment()?;
    let template = environment.get_template("report.html")?;
    let figures = Figures { outcome, model };
    let figure_error = PageError::Figure;
    let described = |findings: &[Finding]| -> Result<Vec<Found>, PageError> {
        let each = findings
            .iter()
            .map(|finding| Ok(describe(finding, figures.explaining(Some(finding))?)));
        each.collect::<Result<_, _>>().map_err(figure_error)
    };
    let found = described(&outcome.findings)?;
    let nearest = match &outcome.nearest {
        Some(nearest) => described(&nearest.findings)?,
        None => Vec::new(),
    };
    let unexplained = match found.is_empty() && nearest.is_empty() {
        true => figures.explaining(None).map_err(figure_error)?,
        false => None,
    };
    let [before, after, _] = scores(outcome);
    let left = left(outcome);
    let split = &outcome.split;
    let details = &outcome.details;
    let contents = serde_json::json!({
        "file": page.file,
        "model": model.name,
        "verdict": verdict(outcome.verdict),
        "columns": super::columns(outcome),
        "columns_sentence": match &outcome.misread {
            Some(misread) if !is_stopped(outcome) => misread.to_string(),
            _ => String::new(),
        },
        "sentence": headline(outcome),
        "after_name": after_name(outcome),
        "rows": rows(outcome, model),
        "horizon": format!("{:.2}", outcome.before.rollout.horizon),
        "windows": outcome.before.rollout.windows,
        "diverged": [before.rollout.diverged, after.rollout.diverged],
        "found": found,
        "nearest": nearest,
        "nearest_title": super::NEAREST,
        "unexplained": unexplained,
        "remains": remains(outcome),
        "unnamed": match &outcome.unnamed {
            Some(unnamed) => unnamed::sentences(unnamed, super::is_left(outcome), model),
            None => Vec::new(),
        },
        "by_forces": outcome.basis == Basis::Forces,
        "misfit": left.0.map(short),
        "shares": left.1.map(|share| short(100.0 * share)),
        "remaining_evidence": nats(outcome.remaining.evidence, 0),
        "over_time": figures.over_time().map_err(figure_error)?,
        "predictions": figures.predictions().map_err(figure_error)?,
        "whiteness": figures.whiteness().map_err(figure_error)?,
        "considered": considered(outcome),
        "considered_count": details.considered.len(),
        "diff": diff_lines(page.diff),
        "split": split,
        "stride": details.series.stride,
        "noise": noise(outcome, model),
        "hold": hold(outcome),
        "seed": outcome.seed,
        "warnings": outcome.warnings,
        "next": outcome.next.iter().map(|advice| [Some(&advice.text), advice.template.as_ref()]).collect::<Vec<_>>(),
        "reading": page.reading,
        "command": page.command,
    });
    Ok(template.render(Serde(contents))?)
}

/// The pages, and what they share.
pub(super) fn environment() -> Result<Environment<'static>, PageError> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    // Texts are escaped by the name's ending.
    environment.add_template("style.css", include_str!("style.css"))?;
    environment.add_template("parts.html", include_str!("parts.html"))?;
    environment.add_template("report.html", include_str!("report.html"))?;
    environment.add_template("fitted.html", include_str!("fitted.html"))?;
    Ok(environment)
}

/// The kind of error, in a word or two.
fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Effect => "missing effect",
        Verdict::Parameter => "wrong parameter",
        Verdict::Channel => "wrong channel",
        Verdict::None => "nothing missing",
        Verdict::Unknown => "unknown",
    }
}

/// The misfit on the training log and the unexplained share, of the model as given and of what is
/// said to be better.
fn left(outcome: &Outcome) -> ([f64; 2], [f64; 2]) {
    let after = match &outcome.nearest {
        Some(nearest) => (nearest.misfit, nearest.share),
        None => (outcome.misfit_after, outcome.remaining.share_after),
    };
    (
        [outcome.misfit_before, after.0],
        [outcome.remaining.share_before, after.1],
    )
}

/// What the findings leave, in one sentence.
fn remains(outcome: &Outcome) -> &'static str {
    match outcome.verdict {
        _ if is_stopped(outcome) => super::NOT_SEARCHED,
        Verdict::Unknown => {
            "Forces remain that sensor noise does not explain and that no effect of the \
             library describes; the model file is left as it is."
        }
        _ if outcome.unnamed.is_some() => {
            "Forces remain that no effect of the library describes; what was found holds beside \
             them."
        }
        _ if outcome.basis == Basis::Forces => BY_FORCES,
        _ if outcome.misfit_after < NEARLY_NOISE => {
            "What remains is about what the sensors' noise explains."
        }
        _ => {
            "More remains than the sensors' noise alone explains, but too little to move the \
             machine noticeably or to be named."
        }
    }
}

/// Mean squared prediction errors in units of sensor noise that count as noise.
const NEARLY_NOISE: f64 = 1.2;

fn rows(outcome: &Outcome, model: &Model) -> Vec<Row> {
    let scores = scores(outcome);
    let row = |name: &str, unit: String, total: bool, pick: &dyn Fn(&Score) -> f64| {
        let [before, after, floor] = scores.map(|score| short(pick(score)));
        Row {
            name: name.into(),
            unit,
            before,
            after,
            floor,
            total,
        }
    };
    let one = || "1".to_string();
    let positions = model.positions();
    let units = || positions.iter().map(|c| (&c.name, stated_unit(&c.unit)));
    let mut rows = vec![row("acceleration, share of its scale", one(), true, &|s| {
        s.acceleration.total
    })];
    for (name, unit) in units() {
        let unit = format!("{unit}/s²");
        rows.push(row(name, unit, false, &|s| at(&s.acceleration, name)));
    }
    rows.push(row(
        "generalised force, share of its scale",
        one(),
        true,
        &|s| s.force.total,
    ));
    for (name, unit) in units() {
        let unit = super::figures::force_unit(&unit);
        rows.push(row(name, unit, false, &|s| at(&s.force, name)));
    }
    let horizon = outcome.before.rollout.horizon;
    let title = format!("prediction over {horizon:.2} s, share of its scale");
    rows.push(row(&title, one(), true, &|s| s.rollout.errors.total));
    for (name, unit) in units() {
        rows.push(row(name, unit, false, &|s| at(&s.rollout.errors, name)));
    }
    rows
}

fn describe(finding: &Finding, figure: Option<Figure>) -> Found {
    let parameters = finding.parameters.iter().map(|(name, p)| {
        let error = if p.is_open() {
            "not determined".into()
        } else if p.std.is_finite() {
            short(p.std)
        } else {
            "not estimated".into()
        };
        [name.clone(), short(p.value), error, shown_unit(&p.unit)]
    });
    let rivals = finding.confounded_with.iter().map(|rival| {
        let name = with_places(&rival.effect, &rival.on);
        let motion = rival.separating_motion.as_ref();
        let motion = motion.map_or_else(|| "—".to_string(), would_tell);
        [name, format!("{:+.1}", rival.evidence_difference), motion]
    });
    Found {
        name: with_places(&finding.effect, &finding.on),
        evidence: nats(finding.evidence, 0),
        parameters: parameters.collect(),
        rivals: rivals.collect(),
        same_on: elsewhere(finding),
        figure,
    }
}

/// Name, evidence, gain and held-out gain of the best candidates, and whether each was
/// accepted.
fn considered(outcome: &Outcome) -> Vec<([String; 5], bool)> {
    let best = outcome.details.considered.iter().take(CANDIDATES);
    best.map(|candidate| {
        let nearest = outcome.nearest.iter().flat_map(|nearest| &nearest.findings);
        let accepted = outcome
            .findings
            .iter()
            .chain(nearest)
            .any(|f| f.effect == candidate.effect && f.on == candidate.on);
        let texts = [
            candidate.effect.clone(),
            candidate.on.join(", "),
            nats(candidate.evidence, 1),
            nats(candidate.gain, 1),
            candidate
                .held_out_gain
                .map_or_else(|| "one place".into(), |gain| nats(gain, 1)),
        ];
        (texts, accepted)
    })
    .collect()
}

/// With so many decimals, and no sign before zero.
fn nats(value: f64, decimals: usize) -> String {
    unsigned_zero(&format!("{value:.decimals$}")).to_string()
}

/// Lines of a diff with the class that colours them.
pub(super) fn diff_lines(diff: &str) -> Vec<[&str; 2]> {
    let class = |line: &str| match line.as_bytes() {
        [b'+', b'+', b'+', ..] | [b'-', b'-', b'-', ..] => "file",
        [b'+', ..] => "plus",
        [b'-', ..] => "minus",
        [b'@', ..] => "place",
        _ => "same",
    };
    diff.lines().map(|line| [class(line), line]).collect()
}

/// Sensor, its noise and unit.
fn noise(outcome: &Outcome, model: &Model) -> Vec<[String; 3]> {
    let mut rows = Vec::new();
    for coordinate in &model.positions() {
        let unit = stated_unit(&coordinate.unit);
        for (prefix, per) in [("q", ""), ("dq", "/s"), ("ddq", "/s²")] {
            let name = format!("{prefix}_{}", coordinate.name);
            if let Some(&sd) = outcome.sensor_noise.get(&name) {
                rows.push([name, short(sd), format!("{unit}{per}")]);
            }
        }
    }
    // Of inputs where it was no torque.
    for input in &model.inputs {
        let name = format!("u_{}", input.name);
        if let Some(&sd) = outcome.sensor_noise.get(&name) {
            rows.push([name, short(sd), stated_unit(&input.unit)]);
        }
    }
    rows
}
