//! What a person reads: a summary on one page, the change to the model, and both with
//! figures as HTML.

mod axis;
mod chart;
mod explain;
mod figures;
mod html;
mod portable;
mod unnamed;

pub use html::{Page, PageError, html};
pub use portable::{EFFECTS, Portable, portable};

use crate::trace::{
    Basis, Errors, Finding, Outcome, ParameterEstimate, Score, SeparatingMotion, Verdict,
};
use dynamics_codegen::Model;
use figures::force_unit;
use std::fmt::Write;

/// The outcome on one page of plain text.
pub fn summary(outcome: &Outcome, model: &Model) -> String {
    let mut page = String::new();
    let mut line = |text: String| {
        page.push_str(&text);
        page.push('\n');
    };
    line(sentence(outcome));
    for mistake in &outcome.misread {
        line(String::new());
        line(format!("  But {mistake}."));
    }
    for finding in &outcome.findings {
        line(String::new());
        describe(finding).into_iter().for_each(&mut line);
    }
    if let Some(unnamed) = &outcome.unnamed {
        line(String::new());
        for sentence in unnamed::sentences(unnamed, model) {
            line(format!("  {sentence}"));
        }
    }
    line(String::new());
    let split = &outcome.split;
    line(format!(
        "Errors on {} samples of {} ({}):",
        split.test_samples, split.test_log, split.method
    ));
    line(format!(
        "  {:34}{:>11}{:>11}{:>13}",
        "", "before", "after", "noise floor"
    ));
    let mut row = |name: String, pick: &dyn Fn(&Score) -> f64| {
        let [before, after, floor] =
            [&outcome.before, &outcome.after, &outcome.noise_floor].map(|score| short(pick(score)));
        line(format!("  {name:34}{before:>11}{after:>11}{floor:>13}"));
    };
    let by_forces = outcome.basis == Basis::Forces;
    row("acceleration, share of its scale".into(), &|s| {
        s.acceleration.total
    });
    for coordinate in model.coordinates.iter().filter(|_| !by_forces) {
        let unit = stated_unit(&coordinate.unit);
        let name = &coordinate.name;
        row(format!("  {name}, {unit}/s^2"), &|s| {
            at(&s.acceleration, name)
        });
    }
    row("force, share of its scale".into(), &|s| s.force.total);
    for coordinate in model.coordinates.iter().filter(|_| by_forces) {
        let unit = force_unit(stated_unit(&coordinate.unit));
        let name = &coordinate.name;
        row(format!("  {name}, {unit}"), &|s| at(&s.force, name));
    }
    let horizon = outcome.before.rollout.horizon;
    row(format!("prediction over {horizon:.2} s"), &|s| {
        s.rollout.errors.total
    });
    line(String::new());
    if by_forces {
        line(BY_FORCES.to_string());
        line(String::new());
    }
    let learnt = format!(
        "Learnt from {} samples of {}",
        split.train_samples, split.train_log
    );
    let [before, after] = [outcome.misfit_before, outcome.misfit_after].map(short);
    let left = short(100.0 * outcome.remaining.share_after);
    let seed = outcome.seed;
    line(match outcome.basis {
        Basis::Motion => format!(
            "{learnt}; mean squared prediction error in units of sensor noise {before} -> {after}; \
             unexplained: {left} % of the accelerations. Seed {seed}."
        ),
        Basis::Forces => format!(
            "{learnt}; mean squared force error in units of what all effects together leave \
             {before} -> {after}; unexplained: {left} % of what the inputs exert. Seed {seed}."
        ),
    });
    page
}

/// What a reader should know where effects were found in the balance of forces.
const BY_FORCES: &str = "So much is missing that no effect alone makes the motion likely: all were \
    found together in the balance of the measured forces. Inputs are taken to be right; a model that \
    cannot move as given has no accelerations and predictions (-).";

fn at(errors: &Errors, name: &str) -> f64 {
    errors.per_coordinate.get(name).copied().unwrap_or(f64::NAN)
}

/// The unit as the model writes it; a question mark if it does not.
fn stated_unit(unit: &str) -> &str {
    if unit.is_empty() { "?" } else { unit }
}

/// What was found, in one sentence.
fn sentence(outcome: &Outcome) -> String {
    let names = names(outcome.findings.iter());
    if outcome.verdict == Verdict::Unknown {
        let (drives, nearest): (Vec<&Finding>, Vec<&Finding>) = outcome
            .findings
            .iter()
            .partition(|finding| finding.is_measured);
        let mut sentence = match drives.is_empty() {
            true => "Something is missing".to_string(),
            false => format!(
                "A drive does not do what it is told: {}. Beside that something is missing",
                self::names(drives.into_iter())
            ),
        };
        sentence.push_str(" that no effect of the library explains");
        if !nearest.is_empty() {
            let nearest = self::names(nearest.into_iter());
            sentence.push_str(&format!("; nearest, but not near: {nearest}"));
        }
        return sentence + ".";
    }
    match outcome.verdict {
        Verdict::None => "The log agrees with the model: nothing is missing.".to_string(),
        Verdict::Effect => format!("The model lacks {names}."),
        Verdict::Channel => format!("A channel is not what it seems: {names}."),
        Verdict::Parameter => format!("Only the value of a parameter is off: {names}."),
        Verdict::Unknown => String::new(),
    }
}

/// Effects with their places, as a list.
fn names<'a>(findings: impl Iterator<Item = &'a Finding>) -> String {
    let names: Vec<String> = findings.map(|f| with_places(&f.effect, &f.on)).collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// An effect and where it acts; a tilt of gravity acts nowhere in particular.
fn with_places(effect: &str, on: &[String]) -> String {
    match on {
        [] => effect.to_string(),
        on => format!("{effect} ({})", on.join(", ")),
    }
}

fn describe(finding: &Finding) -> Vec<String> {
    let mut lines = vec![format!(
        "  {}, evidence {:.0} nats",
        with_places(&finding.effect, &finding.on),
        finding.evidence
    )];
    for (name, p) in &finding.parameters {
        lines.push(match is_open(p) {
            true => format!("    {name} is not determined by this log"),
            false => format!(
                "    {name} = {} ± {} {}",
                short(p.value),
                short(p.std),
                p.unit
            ),
        });
    }
    for rival in &finding.confounded_with {
        let name = with_places(&rival.effect, &rival.on);
        lines.push(format!("    cannot be told from {name} with this log"));
        if let Some(motion) = &rival.separating_motion {
            lines.push(format!("      {}", would_tell(motion)));
        }
    }
    lines
}

/// Times its value by which a shape parameter may be off and still be called known.
const OPEN: f64 = 10.0;

/// Whether the log says nothing about a parameter: how quickly friction turns over where it
/// never does.
fn is_open(p: &ParameterEstimate) -> bool {
    p.std.is_infinite() || p.std > OPEN * p.value.abs() && p.value != 0.0
}

/// What to do to tell two explanations apart, and how much that does.
fn would_tell(motion: &SeparatingMotion) -> String {
    format!(
        "the same motion {} would tell: {} {} apart in {}, here {}",
        motion.motion,
        short(motion.apart),
        motion.unit,
        motion.coordinate,
        short(motion.apart_in_log)
    )
}

/// Four digits; a dash where there is no number.
fn short(value: f64) -> String {
    if !value.is_finite() {
        return "-".to_string();
    }
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = if value == 0.0 {
            0
        } else {
            (3 - value.abs().log10().floor() as i32).max(0)
        };
        format!("{value:.precision$}", precision = digits as usize)
    } else {
        format!("{value:.2e}")
    }
}

/// The change to the model file as a unified diff; empty if there is none.
pub fn diff(name: &str, before: &str, after: &str) -> String {
    let mut text = String::new();
    let changes = similar::TextDiff::from_lines(before, after);
    if before != after {
        write!(
            text,
            "{}",
            changes.unified_diff().context_radius(2).header(name, name)
        )
        .ok();
    }
    text
}
