//! The comparison, for people.

use super::process::FLAT;
use super::{Base, Comparison, Kind, Row};
use std::fmt::Write;

/// One table of errors, and what the processes look like.
pub fn page(table: &Comparison) -> String {
    let mut out = String::new();
    // Writing into a string cannot fail.
    let _ = write(table, &mut out);
    out
}

/// Letters for the columns of the table by coordinate.
const LETTERS: &[u8] = b"abcdefgh";
/// Variables shown of each process.
const SHOWN: usize = 4;

fn name(row: &Row) -> &'static str {
    match (row.model, row.base) {
        (Kind::Analytic, Base::Given) => "analytic, as given",
        (Kind::Analytic, Base::Fitted) => "analytic, fitted",
        (Kind::OutputResidual, _) => "  + output residual GP",
        (Kind::LatentForce, _) => "  + latent force GP (GP²)",
        (Kind::ContactInvariant, _) => "  + contact-invariant residual",
    }
}

fn write(table: &Comparison, out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "semi-parametric models: held-out error in acceleration"
    )?;
    writeln!(
        out,
        "  {}; accelerations {}\n  {} points of {} samples by farthest point sampling, judged by \
         {} samples; seed {}\n",
        table.split, table.measured, table.points, table.candidates, table.judged, table.seed
    )?;
    let (constraint, unit) = match table.rows.iter().any(|row| row.constraint.is_some()) {
        true => ("‖A a − b‖", "largest"),
        false => ("", ""),
    };
    writeln!(
        out,
        "  {:<35} {:>9} {constraint:>11} {:>10} {:>10}",
        "", "error", "evidence", "training"
    )?;
    writeln!(
        out,
        "  {:<35} {:>9} {unit:>11} {:>10} {:>10}",
        "", "share", "nats", "s"
    )?;
    for (letter, row) in LETTERS.iter().zip(&table.rows) {
        let miss = row
            .constraint
            .map_or(String::new(), |c| format!("{:.1e}", c.max));
        let seconds = row
            .training_seconds
            .map_or(String::new(), |s| format!("{s:.1}"));
        let nats = row
            .evidence
            .map_or(String::new(), |nats| format!("{nats:.0}"));
        writeln!(
            out,
            "  {} {:<33} {:>9.4} {miss:>11} {nats:>10} {seconds:>10}",
            char::from(*letter),
            name(row),
            row.acceleration.total
        )?;
    }
    by_coordinate(table, out)?;
    processes(table, out)?;
    for note in &table.notes {
        writeln!(out, "note: {note}")?;
    }
    Ok(())
}

fn by_coordinate(table: &Comparison, out: &mut String) -> std::fmt::Result {
    let Some(first) = table.rows.first() else {
        return Ok(());
    };
    writeln!(
        out,
        "\nroot mean square by coordinate, rad/s² or m/s²; the share above is of the \
         acceleration's own deviation"
    )?;
    write!(out, "  {:<16}", "")?;
    for letter in LETTERS.iter().take(table.rows.len()) {
        write!(out, " {:>9}", char::from(*letter))?;
    }
    writeln!(out)?;
    for name in first.acceleration.per_coordinate.keys() {
        write!(out, "  {name:<16}")?;
        for row in &table.rows {
            write!(out, " {:>9.4}", row.acceleration.per_coordinate[name])?;
        }
        writeln!(out)?;
    }
    writeln!(out)
}

fn processes(table: &Comparison, out: &mut String) -> std::fmt::Result {
    if table.rows.iter().all(|row| row.processes.is_empty()) {
        return Ok(());
    }
    writeln!(
        out,
        "hyper-parameters: deviation of the prior, and the shortest length-scales in deviations \
         of their variable"
    )?;
    for (letter, row) in LETTERS.iter().zip(&table.rows) {
        let what = match row.model {
            Kind::Analytic => continue,
            Kind::OutputResidual => "acceleration",
            Kind::LatentForce | Kind::ContactInvariant => "force",
        };
        for process in row.processes.iter().filter(|process| process.learnt) {
            let mut lengths: Vec<(&String, f64)> = (process.length_scales.iter())
                .map(|(variable, &length)| (variable, length))
                .filter(|(_, length)| *length < FLAT)
                .collect();
            lengths.sort_by(|a, b| a.1.total_cmp(&b.1));
            let shown: Vec<String> = (lengths.iter().take(SHOWN))
                .map(|(variable, length)| format!("{variable} {length:.2}"))
                .collect();
            let shown = match shown.is_empty() {
                true => "no variable matters".to_string(),
                false => shown.join(", "),
            };
            writeln!(
                out,
                "  {} {:<42} {:>10.3e}  {shown}",
                char::from(*letter),
                format!("{what} {}", process.of),
                process.signal_sd
            )?;
        }
        let idle: Vec<&str> = (row.processes.iter())
            .filter(|process| !process.learnt)
            .map(|process| process.of.as_str())
            .collect();
        if !idle.is_empty() {
            writeln!(
                out,
                "  {} no better than white noise, not used: {}",
                char::from(*letter),
                idle.join(", ")
            )?;
        }
    }
    writeln!(out)
}
