//! What was fitted, for people.

use super::{Doubt, Fit, Inertia, InertialParameter, Term, Value};
use crate::number::{short, with_error};
use std::fmt::Write;

/// One page of text.
pub fn page(fit: &Fit) -> String {
    let mut out = String::new();
    // Writing into a string cannot fail.
    let _ = write(fit, &mut out);
    out
}

fn write(fit: &Fit, out: &mut String) -> std::fmt::Result {
    let (learnt, judged) = fit.samples;
    writeln!(
        out,
        "learnt from {learnt} samples, judged by {judged} others\n"
    )?;
    for left_out in &fit.left_out {
        writeln!(out, "{left_out}: it is left out")?;
    }
    if !fit.left_out.is_empty() {
        writeln!(out, "(--trust-columns fits all efforts)\n")?;
    }
    errors(fit, out)?;
    terms(fit, out)?;
    if fit.inertia == Inertia::Fixed {
        return writeln!(out, "inertial parameters held at the model's values");
    }
    writeln!(
        out,
        "inertial parameters: {} in all, {} combinations show in motion, {} are determined by this log",
        fit.inertial.len(),
        fit.base_parameters,
        fit.determined
    )?;
    for p in fit.inertial.iter().filter(|p| p.determined > 0.5) {
        let remark = format!("{:.0} % determined", 100.0 * p.determined);
        inertial(p, &remark, out)?;
    }
    for p in &fit.inertial {
        let remark = match p.doubt {
            Some(Doubt::AtBound) => "at the edge of what a rigid body can have: not determined",
            Some(Doubt::FarFromStated) => {
                "far from what the model states: something else may be missing"
            }
            None => continue,
        };
        inertial(p, remark, out)?;
    }
    let others = fit.inertial.iter();
    let others = others.filter(|p| p.determined <= 0.5 && p.doubt.is_none());
    writeln!(
        out,
        "  m mass, h = m c first moment, I about the body's origin, in the body's axes\n  \
         the other {} keep near the model's values, or show in combinations only: see --json",
        others.count()
    )
}

fn errors(fit: &Fit, out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "root mean square of what is left of the forces, N or N·m, and in % of what they vary by"
    )?;
    let floor = fit.noise_floor.as_ref();
    writeln!(
        out,
        "  {:<16} {:>10} {:>8} {:>10} {:>8} {:>12}",
        "", "before", "%", "after", "%", "noise floor"
    )?;
    for row in rows(fit) {
        let [before, after] = [row.before, row.after].map(|error| {
            let share = 100.0 * error / row.measured;
            (short(error), percent(share))
        });
        let floor = floor.map_or("-".to_string(), |_| short(row.floor));
        writeln!(
            out,
            "  {:<16} {:>10} {:>8} {:>10} {:>8} {floor:>12}",
            row.name, before.0, before.1, after.0, after.1
        )?;
    }
    writeln!(out)
}

/// A line of the table of errors.
pub(crate) struct Row<'a> {
    pub name: &'a str,
    pub before: f64,
    pub after: f64,
    /// Not a number where it is not known.
    pub floor: f64,
    /// What the force varies by.
    pub measured: f64,
}

/// The lines of the table of errors: every coordinate, then all together.
pub(crate) fn rows(fit: &Fit) -> Vec<Row<'_>> {
    let floor = fit.noise_floor.as_ref();
    let names = fit.before.by_coordinate.keys();
    let each = names.map(|name| Row {
        name,
        before: fit.before.by_coordinate[name],
        after: fit.after.by_coordinate[name],
        floor: floor.map_or(f64::NAN, |floor| floor.by_coordinate[name]),
        measured: fit.measured.by_coordinate[name],
    });
    let all = Row {
        name: "all",
        before: fit.before.total,
        after: fit.after.total,
        floor: floor.map_or(f64::NAN, |floor| floor.total),
        measured: fit.measured.total,
    };
    each.chain([all]).collect()
}

/// Three digits of a share; a dash where there is none.
pub(crate) fn percent(share: f64) -> String {
    match share.is_finite() {
        true if share < 99.95 => format!("{share:.1}"),
        true => format!("{share:.0}"),
        false => "-".to_string(),
    }
}

fn terms(fit: &Fit, out: &mut String) -> std::fmt::Result {
    if fit.terms.is_empty() {
        return writeln!(out, "no further term predicts what it was not fitted to\n");
    }
    writeln!(
        out,
        "{}",
        match fit.worse {
            false => "terms that the model lacks, in the order found",
            true => "terms that fit the log learnt from, but make other motion worse",
        }
    )?;
    for term in &fit.terms {
        let name = format!("{}({})", term.term, term.on.join(", "));
        let values = term
            .coefficients
            .iter()
            .map(|(name, v)| coefficient(term, name, v));
        let values: Vec<String> = values.collect();
        let gain = 100.0 * term.gain;
        writeln!(
            out,
            "  {name:<32} {}  (removes {gain:.1} %)",
            values.join(", ")
        )?;
        if term.may_be_body {
            writeln!(
                out,
                "    it is in the body's own centre of mass: a load, or the body itself is heavier"
            )?;
        }
    }
    writeln!(out)
}

/// A place that is known no better than this, m, is what was believed before.
const ANYWHERE: f64 = 0.25;

/// A coefficient with its error, in words where it has none.
fn coefficient(term: &Term, name: &str, v: &Value) -> String {
    let details = &term.details;
    let own = details.coefficients.iter().position(|c| c.name == name);
    let is_place = details.is_load && own.is_some_and(|position| position > 0);
    if is_place && v.std > ANYWHERE {
        return format!("{name} is not determined");
    }
    let value = match v.std.is_nan() && v.value == 0.0 {
        true => format!("{name} = 0 (held: no less is possible)"),
        false => format!("{name} = {}", with_error(v.value, v.std)),
    };
    let value = match own.filter(|_| details.is_load) {
        Some(position) => format!("{value} {}", details.coefficients[position].unit),
        None => value,
    };
    match term.stated.get(name) {
        Some(stated) => format!("{value} (the model states {})", short(*stated)),
        None => value,
    }
}

fn inertial(p: &InertialParameter, remark: &str, out: &mut String) -> std::fmt::Result {
    let name = format!("{}.{}", p.body, p.parameter);
    let unit = match p.parameter {
        "m" => "kg",
        "hx" | "hy" | "hz" => "kg·m",
        _ => "kg·m²",
    };
    let estimate = with_error(p.estimate.value, p.estimate.std);
    writeln!(
        out,
        "  {name:<24} {:>12} -> {estimate} {unit:<6} ({remark})",
        short(p.stated)
    )
}
