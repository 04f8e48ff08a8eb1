//! What a person reads: a summary on one page, the change to the model, and both with
//! figures as HTML.

mod axis;
mod chart;
mod explain;
mod figures;
mod fitted;
mod html;
mod learnt;
mod portable;
mod unnamed;

pub use fitted::{FitPage, fit_html};
pub use html::{Page, PageError, html};
pub use portable::{EFFECTS, Portable, portable};

use crate::log::Map;
use crate::number::{rounded, short};
use crate::regression::Hold;
use crate::trace::with_places;
use crate::trace::{Basis, Errors, Finding, HoldIs, Outcome, Score, SeparatingMotion, Verdict};
use dynamics_codegen::Model;
use dynamics_codegen::dimension::shown_unit;
use figures::force_unit;
use learnt::learnt;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The outcome on one page of plain text.
pub fn summary(outcome: &Outcome, model: &Model) -> String {
    let mut lines = Vec::new();
    if let Some(misread) = &outcome.misread {
        lines.extend([misread.to_string(), String::new()]);
        lines.extend(
            columns(outcome)
                .into_iter()
                .map(|line| match line.is_empty() {
                    true => line,
                    false => format!("  {line}"),
                }),
        );
        lines.push(String::new());
    }
    lines.push(match is_stopped(outcome) {
        true => NOT_SEARCHED.to_string(),
        false => verdict(outcome),
    });
    for finding in &outcome.findings {
        lines.push(String::new());
        lines.extend(describe(finding));
    }
    if let Some(nearest) = &outcome.nearest {
        lines.extend([String::new(), format!("  {NEAREST}")]);
        for finding in &nearest.findings {
            lines.push(String::new());
            lines.extend(describe(finding));
        }
    }
    if let Some(unnamed) = &outcome.unnamed {
        lines.push(String::new());
        let sentences = unnamed::sentences(unnamed, is_left(outcome), model).into_iter();
        lines.extend(sentences.map(|sentence| format!("  {sentence}")));
    }
    lines.push(String::new());
    lines.extend(table(outcome, model));
    lines.push(String::new());
    if outcome.basis == Basis::Forces {
        lines.extend([BY_FORCES.to_string(), String::new()]);
    }
    lines.push(learnt(outcome));
    if !is_stopped(outcome) {
        lines.extend(hold(outcome).map(|hold| format!("Between samples inputs {hold}.")));
    }
    lines.extend([String::new(), "What to do next:".to_string()]);
    for advice in &outcome.next {
        lines.push(format!("- {}", advice.text));
        if let Some(template) = &advice.template {
            lines.push(String::new());
            lines.extend(template.lines().map(|line| match line.is_empty() {
                true => String::new(),
                false => format!("    {line}"),
            }));
        }
    }
    lines.join("\n") + "\n"
}

/// What should be known about mistaken columns, and the lines of a map that read them as they are.
fn columns(outcome: &Outcome) -> Vec<String> {
    let Some(misread) = &outcome.misread else {
        return Vec::new();
    };
    let [before, after] = [misread.error_as_read, misread.error_otherwise].map(short);
    let map: Vec<&String> = misread.mistakes.iter().flat_map(|m| &m.map).collect();
    if map.is_empty() {
        let question = "Are both in one unit? A map of the log says it (docs/log-format.md).";
        return vec![question.to_string()];
    }
    let logs = outcome.split.train_log.split(", ").map(Path::new);
    let maps: Vec<String> = logs
        .map(|log| Map::beside(log).display().to_string())
        .collect();
    let mut lines = vec![
        format!(
            "As the columns are read, the model's accelerations are off by {before} of their size; \
             otherwise by {after}."
        ),
        format!(
            "A map of the log says so (docs/log-format.md): {} beside it, with",
            maps.join(", ")
        ),
        String::new(),
        "  [columns]".to_string(),
    ];
    lines.extend(map.iter().map(|line| format!("  {line}")));
    lines
}

/// Whether forces without a name are what findings leave, and not all that is missing.
fn is_left(outcome: &Outcome) -> bool {
    outcome.verdict != Verdict::Unknown
}

/// The first sentence of the page: mistaken columns beyond doubt, else what was found.
fn headline(outcome: &Outcome) -> String {
    match &outcome.misread {
        Some(misread) if is_stopped(outcome) => misread.to_string(),
        _ => verdict(outcome),
    }
}

/// Whether nothing was searched for, as columns are mistaken.
fn is_stopped(outcome: &Outcome) -> bool {
    outcome.misfit_before.is_nan()
}

const NOT_SEARCHED: &str = "Nothing else was searched for: what is found in mistaken columns is not \
    true. If they are right, --trust-columns searches all the same.";

/// Above what was found wanting.
const NEAREST: &str = "Nearest, but no explanation; none of it is written into the model:";

/// What errors beside those before are of, in a word or two.
fn after_name(outcome: &Outcome) -> &'static str {
    match &outcome.nearest {
        Some(_) => "nearest",
        None if is_stopped(outcome) => "read so",
        None => "after",
    }
}

/// The errors of the model as given, of what is said to be better, and of noise alone.
fn scores(outcome: &Outcome) -> [&Score; 3] {
    let nearest = outcome.nearest.as_ref().map(|nearest| &nearest.errors);
    let after = nearest.unwrap_or(&outcome.after);
    [&outcome.before, after, &outcome.noise_floor]
}

/// The errors on data that nothing was fitted to.
fn table(outcome: &Outcome, model: &Model) -> Vec<String> {
    let split = &outcome.split;
    let after = after_name(outcome);
    let mut lines = vec![
        format!(
            "Errors on {} samples of {} ({}):",
            split.test_samples, split.test_log, split.method
        ),
        format!(
            "  {:34}{:>11}{after:>11}{:>13}",
            "", "before", "noise floor"
        ),
    ];
    let mut row = |name: String, pick: &dyn Fn(&Score) -> f64| {
        let [before, after, floor] = scores(outcome).map(|score| short(pick(score)));
        lines.push(format!("  {name:34}{before:>11}{after:>11}{floor:>13}"));
    };
    let by_forces = outcome.basis == Basis::Forces;
    row("acceleration, share of its scale".into(), &|s| {
        s.acceleration.total
    });
    let positions = model.positions();
    for coordinate in positions.iter().filter(|_| !by_forces) {
        let unit = stated_unit(&coordinate.unit);
        let name = &coordinate.name;
        row(format!("  {name}, {unit}/s^2"), &|s| {
            at(&s.acceleration, name)
        });
    }
    row("force, share of its scale".into(), &|s| s.force.total);
    for coordinate in positions.iter().filter(|_| by_forces) {
        let unit = force_unit(&stated_unit(&coordinate.unit));
        let name = &coordinate.name;
        row(format!("  {name}, {unit}"), &|s| at(&s.force, name));
    }
    let horizon = outcome.before.rollout.horizon;
    row(format!("prediction over {horizon:.2} s"), &|s| {
        s.rollout.errors.total
    });
    lines
}

/// What inputs are taken to do between samples, and why.
fn hold(outcome: &Outcome) -> Option<String> {
    outcome.details.series.inputs.first()?;
    let (hold, flag, other) = match outcome.input_hold {
        Hold::Linear => (GO_STRAIGHT, "previous", STAY),
        Hold::Previous => (STAY, "linear", GO_STRAIGHT),
    };
    let why = match outcome.input_hold_is {
        HoldIs::Stated => "as stated",
        HoldIs::Found => "as the log shows best",
        HoldIs::Undecided => "which the log does not tell from the other",
        HoldIs::Assumed => "which was assumed",
    };
    let times = |of: &BTreeMap<String, f64>, joint: &str| {
        let each = of.iter();
        let each = each.map(|(name, time)| format!("{name}{joint}{} ms", short(1e3 * time)));
        each.collect::<Vec<_>>().join(", ")
    };
    let mut said = format!("{hold}, {why}");
    if !outcome.if_held_otherwise.is_empty() {
        let times = times(&outcome.if_held_otherwise, " = ");
        said += &format!("; if they {other} (--hold {flag}), {times}");
    }
    if !outcome.between_samples.is_empty() {
        let times = times(&outcome.between_samples, " ");
        said += &format!("; late by less than half a sample, which is no finding: {times}");
    }
    Some(said)
}

/// What inputs do between samples.
const GO_STRAIGHT: &str = "go straight from one sample to the next";
const STAY: &str = "stay at the earlier sample's value";

/// What a reader should know where effects were found in the balance of forces.
const BY_FORCES: &str = "Nothing makes the motion likely up to sensor noise: what is missing was found \
    in the balance of the measured forces, all of it together. Inputs are taken to be right; a model \
    that cannot move as given has no accelerations and predictions (-).";

fn at(errors: &Errors, name: &str) -> f64 {
    errors.per_coordinate.get(name).copied().unwrap_or(f64::NAN)
}

/// The unit that the model states; a question mark if it does not.
fn stated_unit(unit: &str) -> String {
    if unit.is_empty() {
        "?".to_string()
    } else {
        shown_unit(unit)
    }
}

/// What is said first: what was found, and before that whether the search was ended early.
fn verdict(outcome: &Outcome) -> String {
    let found = found(outcome);
    match outcome.unfinished {
        Some(ended) => format!("Unfinished: {ended} ended the search. Until then: {found}"),
        None => found,
    }
}

/// What was found, in one sentence.
fn found(outcome: &Outcome) -> String {
    let names = names(outcome.findings.iter());
    let left = match &outcome.unnamed {
        Some(_) => what_is_left(outcome),
        None => String::new(),
    };
    match outcome.verdict {
        Verdict::None => match outcome.unfinished {
            Some(_) => "Nothing tried so far explains the log better than the model.".to_string(),
            None => "The log agrees with the model: nothing is missing.".to_string(),
        },
        Verdict::Effect => format!("The model lacks {names}.{left}"),
        Verdict::Channel => format!("A channel is not what it seems: {names}.{left}"),
        Verdict::Parameter => match left.is_empty() {
            true => format!("Only the value of a parameter is off: {names}."),
            false => format!("The value of a parameter is off: {names}.{left}"),
        },
        Verdict::Unknown => {
            let mut sentence = match outcome.findings.is_empty() {
                true => "Something is missing".to_string(),
                false => format!(
                    "A drive does not do what it is told: {names}. Beside that something is missing"
                ),
            };
            sentence.push_str(match outcome.unfinished {
                Some(_) => " that nothing tried so far explains",
                None => " that no effect of the library explains",
            });
            if let Some(nearest) = &outcome.nearest {
                let nearest = self::names(nearest.findings.iter());
                sentence.push_str(&format!("; nearest, but not near: {nearest}"));
            }
            sentence + "."
        }
    }
}

/// How much findings leave that has no name, in one sentence.
fn what_is_left(outcome: &Outcome) -> String {
    let of = match outcome.basis {
        Basis::Motion => "the accelerations",
        Basis::Forces => "what the inputs exert",
    };
    let remaining = &outcome.remaining;
    let [before, after] = [remaining.share_before, remaining.share_after];
    let [before, after] = [before, after].map(|share| rounded(100.0 * share));
    format!(" That leaves {after} % of {of} unexplained ({before} % before).")
}

/// Effects with their places, as a list.
fn names<'a>(findings: impl Iterator<Item = &'a Finding>) -> String {
    let names: Vec<String> = findings.map(|f| with_places(&f.effect, &f.on)).collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// So many effects that a finding cannot be told from are listed below it, which the page and the JSON have all of: a
/// weak finding in an arm has dozens.
const RIVALS: usize = 4;

fn describe(finding: &Finding) -> Vec<String> {
    let mut lines = vec![format!(
        "  {}, evidence {:.0} nats",
        with_places(&finding.effect, &finding.on),
        finding.evidence
    )];
    for (name, p) in &finding.parameters {
        lines.push(match p.is_open() {
            true => format!("    {name} is not determined by this log"),
            false => format!(
                "    {name} = {} ± {} {}",
                short(p.value),
                short(p.std),
                shown_unit(&p.unit)
            ),
        });
    }
    lines.extend(elsewhere(finding).map(|same| format!("    {same}")));
    let rivals = &finding.confounded_with;
    for rival in rivals.iter().take(RIVALS) {
        let name = with_places(&rival.effect, &rival.on);
        lines.push(format!("    cannot be told from {name} with this log"));
        if let Some(motion) = &rival.separating_motion {
            lines.push(format!("      {}", would_tell(motion)));
        }
    }
    match rivals.len().saturating_sub(RIVALS) {
        0 => {}
        1 => lines.push("    nor from another one, which --json and --report list".to_string()),
        others => lines.push(format!(
            "    nor from {others} others, which --json and --report list"
        )),
    }
    lines
}

/// On what else a finding would be the same law.
fn elsewhere(finding: &Finding) -> Option<String> {
    let (own, others) = (finding.on.join(", "), finding.same_on.join(", "));
    (!others.is_empty()).then(|| format!("as well on {others}, rigidly connected with {own}"))
}

/// What to do to tell two explanations apart, and how much that does.
fn would_tell(motion: &SeparatingMotion) -> String {
    format!(
        "the same motion {} would tell: {} {} apart in {}, here {}",
        motion.motion,
        short(motion.apart),
        shown_unit(&motion.unit),
        motion.coordinate,
        short(motion.apart_in_log)
    )
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use crate::trace::{Ended, Progress, Request, Rival, Silent, Stage, trace};
    use dynamics_codegen::Library;

    /// A search without time.
    #[derive(Debug)]
    struct Over;

    impl Progress for Over {
        fn enter(&self, _: Stage, _: &[String]) {}

        fn notice(&self, _: &str) {}

        fn ended(&self) -> Option<Ended> {
            Some(Ended::TimeLimit)
        }
    }

    /// Only who has looked at everything may say that nothing is missing.
    #[test]
    fn a_search_that_is_over_does_not_say_that_nothing_is_missing() {
        let model = "model wheel; coordinate angle: rad; input motor: N*m;\n\
                     parameter i: kg*m^2 = 0.02; kinetic i/2*dot(angle)^2; force angle = input(motor);";
        let mut text = String::from("t,q_angle,u_motor\n");
        for k in 0..600 {
            let (t, noise) = (0.01 * f64::from(k), f64::from(k * k % 7) - 2.0);
            let q = (3.0 * t).sin() + 0.4 * (7.0 * t).sin();
            let a = -9.0 * (3.0 * t).sin() - 19.6 * (7.0 * t).sin();
            writeln!(text, "{t},{},{}", q + 2e-5 * noise, 0.02 * a).unwrap();
        }
        let log = Log::from_bytes("wheel.csv", text.as_bytes()).unwrap();
        let library = Library::builtin();
        let said = |progress: &dyn Progress| {
            let request = Request::new("wheel", model, &library, &log);
            verdict(
                &trace(&Request {
                    progress,
                    ..request
                })
                .unwrap(),
            )
        };
        assert_eq!(
            [said(&Silent), said(&Over)],
            [
                "The log agrees with the model: nothing is missing.",
                "Unfinished: the time limit ended the search. Until then: Nothing tried so far \
                 explains the log better than the model."
            ]
        );
    }

    /// A load without much to tell it by may be any of the places and laws of an arm.
    #[test]
    fn of_many_rivals_the_first_are_listed() {
        let rival = |joint: usize| Rival {
            effect: "spring".into(),
            on: vec![format!("j{joint}")],
            evidence_difference: joint as f64,
            separating_motion: None,
        };
        let finding = |rivals: usize| Finding {
            effect: "cogging".into(),
            on: vec!["j1".into()],
            places: Vec::new(),
            parameters: BTreeMap::new(),
            evidence: 12.0,
            confounded_with: (2..2 + rivals).map(rival).collect(),
            same_on: Vec::new(),
            is_measured: false,
        };
        assert_eq!(describe(&finding(RIVALS)).len(), 1 + RIVALS);
        for (further, others) in [(1, "another one"), (3, "3 others")] {
            let described = describe(&finding(RIVALS + further));
            let said = format!("    nor from {others}, which --json and --report list");
            assert_eq!(described[RIVALS + 1..], [said]);
        }
    }
}
