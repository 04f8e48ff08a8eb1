//! What was fitted, for people.

use super::{Fit, Inertia};
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
    writeln!(
        out,
        "root mean square of what is left of the forces, N or N·m"
    )?;
    writeln!(out, "  {:<16} {:>10} {:>10}", "", "before", "after")?;
    for (name, before) in &fit.before.by_coordinate {
        let after = fit.after.by_coordinate[name];
        writeln!(out, "  {name:<16} {before:>10.4} {after:>10.4}")?;
    }
    let (before, after) = (fit.before.total, fit.after.total);
    writeln!(out, "  {:<16} {before:>10.4} {after:>10.4}\n", "all")?;
    if fit.terms.is_empty() {
        writeln!(out, "no further term predicts what it was not fitted to\n")?;
    } else {
        writeln!(out, "terms that the model lacks, in the order found")?;
        for term in &fit.terms {
            let name = format!("{}({})", term.term, term.on.join(", "));
            let values: Vec<String> = (term.coefficients.iter())
                .map(|(name, v)| format!("{name} = {:.4} ± {:.4}", v.value, v.std))
                .collect();
            let gain = 100.0 * term.gain;
            writeln!(
                out,
                "  {name:<32} {}  (removes {gain:.1} %)",
                values.join(", ")
            )?;
        }
        writeln!(out)?;
    }
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
        let name = format!("{}.{}", p.body, p.parameter);
        let unit = match p.parameter {
            "m" => "kg",
            "hx" | "hy" | "hz" => "kg·m",
            _ => "kg·m²",
        };
        writeln!(
            out,
            "  {name:<24} {:>12.5} -> {:>12.5} ± {:.5} {unit:<6} ({:.0} % determined)",
            p.stated,
            p.estimate.value,
            p.estimate.std,
            100.0 * p.determined
        )?;
    }
    let others = fit.inertial.iter().filter(|p| p.determined <= 0.5).count();
    writeln!(
        out,
        "  m mass, h = m c first moment, I about the body's origin, in the body's axes\n  \
         the other {others} keep near the model's values, or show in combinations only: see --json"
    )
}
