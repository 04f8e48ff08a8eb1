//! No two constraints ask for different things.
//!
//! Constraints contradict each other for certain if a combination of them, with constant
//! factors, contains no coordinate and is not zero: `y == 0` and `y == 1` differ by 1
//! wherever the machine is. The combinations are those of the rows of `A` that vanish at
//! every state that is tried.

use super::Places;
use super::states::States;
use crate::derive::System;
use crate::diagnostic::{Diagnostic, Severity};
use crate::model::{Constraint, ConstraintKind, Model};

/// A row is a combination of others if this share of it, or less, is left over: round-off.
const DEPENDENT: f64 = 1e-10;

/// What is left of a combination of constraints counts from this share of its terms.
const MISS: f64 = 1e-9;

/// Factors of constraints: which, and how often.
type Combination = Vec<(usize, f64)>;

/// One finding per constraint that contradicts others before it.
pub(super) fn check(
    model: &Model,
    system: &System,
    states: &States<'_>,
    places: Places<'_>,
) -> Vec<Diagnostic> {
    // A constraint that comes and goes may contradict what it replaces.
    let rows: Vec<usize> = (0..model.constraints.len())
        .filter(|&i| model.constraints[i].active.is_none())
        .collect();
    if rows.len() < 2 {
        return Vec::new();
    }
    let vectors = rows_along(model, system, states, &rows);
    // Of more vectors than they have entries, some combination always vanishes.
    if vectors.iter().any(|vector| vector.len() < rows.len()) {
        return Vec::new();
    }
    let found = combinations(&vectors).into_iter().map(|combination| {
        let named = combination.into_iter().map(|(r, factor)| (rows[r], factor));
        named.collect::<Combination>()
    });
    found
        .filter_map(|combination| {
            let miss = miss(system, states, &combination)?;
            Some(contradiction(model, &combination, miss, places))
        })
        .collect()
}

/// Per constraint its row of `A` at all states, one behind the other.
fn rows_along(
    model: &Model,
    system: &System,
    states: &States<'_>,
    rows: &[usize],
) -> Vec<Vec<f64>> {
    let width = model.coordinates.len();
    let entries = rows
        .iter()
        .flat_map(|&i| system.constraint_matrix[i].iter());
    let tried = states.evaluate(&entries.copied().collect::<Vec<_>>());
    let mut vectors = vec![Vec::new(); rows.len()];
    for (_, values) in &tried {
        for (vector, row) in vectors.iter_mut().zip(values.chunks(width)) {
            vector.extend_from_slice(row);
        }
    }
    vectors
}

/// Combinations of vectors that vanish; the last factor of each is 1. By Gram and
/// Schmidt's method, with the factors kept.
fn combinations(vectors: &[Vec<f64>]) -> Vec<Combination> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let size = |vector: &[f64]| dot(vector, vector).sqrt();
    let mut basis: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    let mut found = Vec::new();
    for (index, vector) in vectors.iter().enumerate() {
        if size(vector) == 0.0 {
            continue;
        }
        let mut rest = vector.clone();
        let mut factors = vec![0.0; vectors.len()];
        factors[index] = 1.0;
        // Twice is enough against round-off.
        for (direction, made_of) in basis.iter().chain(&basis) {
            let along = dot(direction, &rest);
            subtract(&mut rest, along, direction);
            subtract(&mut factors, along, made_of);
        }
        let left = size(&rest);
        if left > DEPENDENT * size(vector) {
            let unit = |x: Vec<f64>| x.into_iter().map(|x| x / left).collect::<Vec<f64>>();
            basis.push((unit(rest), unit(factors)));
            continue;
        }
        let own = size(vector);
        let takes_part =
            |&(j, factor): &(usize, f64)| factor.abs() * size(&vectors[j]) > DEPENDENT * own;
        found.push(factors.into_iter().enumerate().filter(takes_part).collect());
    }
    found
}

/// `x − along d`
fn subtract(x: &mut [f64], along: f64, d: &[f64]) {
    for (x, d) in x.iter_mut().zip(d) {
        *x -= along * d;
    }
}

/// What is left of a combination of constraints that contains no coordinate, or of rates
/// that contains no velocity; `None` if nothing is. Such a combination of rates may still
/// be zero somewhere, `dot(x) == 0` and `dot(x) == x` at x = 0: it must be the same
/// everywhere.
fn miss(system: &System, states: &States<'_>, combination: &Combination) -> Option<f64> {
    let kinds = combination.iter().map(|&(i, _)| system.constraint_kinds[i]);
    let holonomic = kinds
        .into_iter()
        .all(|kind| kind == ConstraintKind::Holonomic);
    let terms = if holonomic {
        &system.constraint_residual
    } else {
        &system.constraint_rate
    };
    let expressions: Vec<_> = combination.iter().map(|&(i, _)| terms[i]).collect();
    let (mut sums, mut scale) = (Vec::new(), 0.0_f64);
    for (_, values) in states.evaluate(&expressions) {
        let parts = || {
            combination
                .iter()
                .zip(&values)
                .map(|((_, factor), x)| factor * x)
        };
        sums.push(parts().sum::<f64>());
        scale = scale.max(parts().map(f64::abs).sum());
    }
    let first = *sums.first()?;
    let same = sums.iter().all(|sum| (sum - first).abs() <= MISS * scale);
    let largest = sums.iter().fold(0.0_f64, |l, sum| l.max(sum.abs()));
    (largest > MISS * scale && (holonomic || same)).then_some(largest)
}

fn contradiction(
    model: &Model,
    combination: &Combination,
    miss: f64,
    places: Places<'_>,
) -> Diagnostic {
    let constraints: Vec<&Constraint> = (combination.iter())
        .map(|&(i, _)| &model.constraints[i])
        .collect();
    let names: Vec<String> = constraints
        .iter()
        .map(|c| format!("`{}`", c.name))
        .collect();
    let message = format!("the constraints {} contradict each other", names.join(", "));
    // A combination ends with the constraint that it was found for.
    let (others, last) = constraints.split_at(constraints.len() - 1);
    let when = if constraints.iter().any(|c| c.time_dependent) {
        "in the course of time"
    } else {
        "wherever the machine is"
    };
    let place = |c: &Constraint| places.constraint(&c.name);
    let own = place(last[0]).unwrap_or_else(|| places.heading());
    let finding = Diagnostic::error(own, message).label(format!("off by {} {when}", rounded(miss)));
    let elsewhere = others.iter().filter_map(|constraint| place(constraint));
    let mut finding = elsewhere.fold(finding, |finding, span| finding.also(span, ""));
    let residuals: Vec<_> = constraints.iter().map(|c| c.residual).collect();
    let symbols = model.graph.symbols_in(&residuals);
    if model.parameters.iter().any(|p| symbols.contains(&p.symbol)) {
        finding.severity = Severity::Warning;
        return finding
            .help("they do so with the nominal parameters: correct a value, or drop one of them");
    }
    finding.help("drop one of them, or correct a side")
}

/// Four significant digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_vectors_are_found_with_their_factors() {
        let vectors = [
            vec![1.0, 0.0, 2.0],
            vec![0.0, 3.0, 0.0],
            vec![0.0, 0.0, 0.0],
            vec![2.0, 3.0, 4.0],
            vec![0.0, 0.0, 1.0],
            vec![0.0, -6.0, 0.0],
        ];
        let found = combinations(&vectors);
        assert_eq!(found.len(), 2, "{found:?}");
        for (combination, last) in found.iter().zip([3, 5]) {
            assert_eq!(combination.last(), Some(&(last, 1.0)));
            for k in 0..3 {
                let sum: f64 = combination.iter().map(|&(i, f)| f * vectors[i][k]).sum();
                assert!(sum.abs() < 1e-12, "{combination:?}");
            }
        }
        let of_the_fourth: Vec<usize> = found[0].iter().map(|&(i, _)| i).collect();
        assert_eq!(of_the_fourth, [0, 1, 3]);
    }
}
