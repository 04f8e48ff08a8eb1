//! Kinetic energy is positive: `M` is positive definite, where constraints do not make up
//! for what it lacks.

use super::Places;
use super::states::States;
use crate::derive::System;
use crate::diagnostic::Diagnostic;
use crate::graph::ExprId;
use crate::model::{Model, Parameter};

/// A pivot of the scaled matrix (diagonal ±1) below this is zero: far above round-off, far
/// below the share of inertia that any real coordinate keeps when the others are free.
const ZERO: f64 = 1e-12;

/// A pivot below minus this is negative, not round-off of the expressions.
const NEGATIVE: f64 = 1e-9;

/// What a symmetric matrix is; the coordinate is one that moves in the motion meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Definite,
    Singular(usize),
    Indefinite(usize),
}

/// `M` of a model, and the rows of `A` that may make up for what it lacks.
struct Inertia<'a> {
    model: &'a Model,
    /// The entries of both, `M` first.
    entries: Vec<ExprId>,
}

/// The first thing that is wrong with the mass matrix, unless a finding says it already.
pub(super) fn check(
    model: &Model,
    system: &System,
    states: &States<'_>,
    places: Places<'_>,
    findings: &[Diagnostic],
) -> Option<Diagnostic> {
    let mass = system.mass_matrix.concat();
    let moves = mass.iter().any(|&entry| model.contains_position(entry));
    let entries = [mass, system.constraint_matrix.concat()].concat();
    let inertia = Inertia { model, entries };
    let verdicts = inertia.verdicts(states);
    let negative = verdicts.iter().find_map(|&(trial, verdict)| match verdict {
        Verdict::Indefinite(coordinate) => Some((trial, coordinate)),
        _ => None,
    });
    let finding = if let Some((trial, coordinate)) = negative {
        let name = &model.coordinates[coordinate].name;
        let message = format!(
            "the mass matrix is not positive definite: motion of `{name}` has negative kinetic energy"
        );
        let place = places.coordinate(name).unwrap_or_else(|| places.heading());
        let finding = Diagnostic::warning(place, message);
        if moves {
            let positions = states.positions(trial);
            finding.label(format!("seen at {}", configuration(model, &positions)))
        } else {
            finding
        }
    } else {
        let coordinate = singular_everywhere(&verdicts)?;
        let name = &model.coordinates[coordinate].name;
        // A robot description has been looked at joint by joint.
        let place = places.coordinate(name)?;
        if findings.iter().any(|finding| finding.primary.span == place) {
            return None;
        }
        let message = format!(
            "the mass matrix is singular: motion of `{name}` has no kinetic energy, and no constraint determines it"
        );
        Diagnostic::warning(place, message)
    };
    let blamed = inertia.to_blame(states, &verdicts);
    Some(explained(finding, &blamed, places))
}

/// A coordinate whose inertia is missing in all states.
fn singular_everywhere(verdicts: &[(usize, Verdict)]) -> Option<usize> {
    let coordinates = verdicts.iter().map(|&(_, verdict)| match verdict {
        Verdict::Singular(coordinate) => Some(coordinate),
        _ => None,
    });
    coordinates
        .collect::<Option<Vec<usize>>>()?
        .first()
        .copied()
}

/// How far verdicts are from definite, all together.
fn badness(verdicts: &[(usize, Verdict)]) -> usize {
    let each = verdicts.iter().map(|(_, verdict)| match verdict {
        Verdict::Definite => 0,
        Verdict::Singular(_) => 1,
        Verdict::Indefinite(_) => 2,
    });
    each.sum()
}

impl<'a> Inertia<'a> {
    /// The verdict of every state where all entries are finite.
    fn verdicts(&self, states: &States<'_>) -> Vec<(usize, Verdict)> {
        let n = self.model.coordinates.len();
        let tried = states.evaluate(&self.entries).into_iter();
        tried
            .map(|(trial, values)| (trial, judge_with_rows(&values, n)))
            .collect()
    }

    /// The parameters that are not positive and, were they, would change what is found,
    /// for nothing worse.
    fn to_blame(&self, states: &States<'_>, found: &[(usize, Verdict)]) -> Vec<&'a Parameter> {
        let symbols = self.model.graph.symbols_in(&self.entries);
        let parameters = self.model.parameters.iter();
        let unfit = parameters.filter(|p| p.nominal <= 0.0 && symbols.contains(&p.symbol));
        unfit
            .filter(|p| {
                let value = if p.nominal < 0.0 { -p.nominal } else { 1.0 };
                let changed = self.verdicts(&states.with(p, value));
                changed != found && badness(&changed) <= badness(found)
            })
            .collect()
    }
}

/// With the parameters whose values are to blame, or what else to look at.
fn explained(finding: Diagnostic, blamed: &[&Parameter], places: Places<'_>) -> Diagnostic {
    let Some(first) = blamed.first() else {
        return finding.help(
            "kinetic energy is positive: look for a wrong sign in `kinetic`, or an inertia that is missing",
        );
    };
    let help = format!(
        "give `{}` a value above zero, and a bound that keeps it there: `in 1e-6..`",
        first.name
    );
    let labelled = blamed.iter().fold(finding, |finding, p| {
        let text = format!("its value is {}, which its bounds allow", p.nominal);
        match places.parameter(&p.name) {
            Some(place) => finding.also(place, text),
            None => finding,
        }
    });
    labelled.help(help)
}

/// `x = 0.62, phi = 0`
fn configuration(model: &Model, positions: &[f64]) -> String {
    let named = model.coordinates.iter().zip(positions);
    let shown = named
        .take(SHOWN)
        .map(|(c, value)| format!("{} = {value:.3}", c.name));
    let mut text = shown.collect::<Vec<_>>().join(", ");
    if model.coordinates.len() > SHOWN {
        text.push_str(", …");
    }
    text
}

/// Nobody reads more coordinates of a configuration than this.
const SHOWN: usize = 6;

/// `M`, `n×n`, then `A`, row by row: `M` alone, or with what constraints hold.
fn judge_with_rows(values: &[f64], n: usize) -> Verdict {
    let (mass, rows) = values.split_at(n * n);
    let mut matrix: Vec<Vec<f64>> = mass.chunks(n).map(<[f64]>::to_vec).collect();
    let alone = judge(&matrix);
    if !matches!(alone, Verdict::Singular(_)) {
        return alone;
    }
    let weight = (0..n).fold(0.0_f64, |w, i| w.max(matrix[i][i].abs()));
    let weight = if weight > 0.0 { weight } else { 1.0 };
    for row in rows.chunks(n) {
        let length: f64 = row.iter().map(|x| x * x).sum();
        if length == 0.0 {
            continue;
        }
        for i in 0..n {
            for j in 0..n {
                matrix[i][j] += weight * row[i] * row[j] / length;
            }
        }
    }
    judge(&matrix)
}

/// By Cholesky's factorisation with pivots, of the matrix scaled to a diagonal of ±1: it
/// is semidefinite if and only if what is left at a zero pivot is zero.
fn judge(matrix: &[Vec<f64>]) -> Verdict {
    let mut work = scaled(matrix);
    let mut left: Vec<usize> = (0..work.len()).collect();
    while let Some(place) = (0..left.len()).max_by(|&a, &b| {
        let diagonal = |place: usize| work[left[place]][left[place]];
        diagonal(a).total_cmp(&diagonal(b))
    }) {
        let k = left[place];
        let pivot = work[k][k];
        if pivot <= ZERO {
            return judge_rest(&work, &left, k);
        }
        left.swap_remove(place);
        for &i in &left {
            let share = work[i][k] / pivot;
            for &j in &left {
                work[i][j] -= share * work[k][j];
            }
        }
    }
    Verdict::Definite
}

/// What is left where no pivot is positive any more.
fn judge_rest(work: &[Vec<f64>], left: &[usize], pivot: usize) -> Verdict {
    let negative = left.iter().find(|&&i| work[i][i] < -NEGATIVE);
    let crossed = left
        .iter()
        .find(|&&i| left.iter().any(|&j| i != j && work[i][j].abs() > NEGATIVE));
    match negative.or(crossed) {
        Some(&coordinate) => Verdict::Indefinite(coordinate),
        None => Verdict::Singular(pivot),
    }
}

/// Units do not matter: every row and column divided by the root of its diagonal.
fn scaled(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let entries = matrix.iter().flatten();
    let largest = entries
        .fold(0.0_f64, |l, x| l.max(x.abs()))
        .max(f64::MIN_POSITIVE);
    let lengths: Vec<f64> = (matrix.iter().enumerate())
        .map(|(i, row)| match row[i].abs() {
            own if own > 0.0 => own.sqrt(),
            _ => largest.sqrt(),
        })
        .collect();
    (matrix.iter().zip(&lengths))
        .map(|(row, a)| row.iter().zip(&lengths).map(|(x, b)| x / (a * b)).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict<const N: usize>(matrix: [[f64; N]; N]) -> Verdict {
        judge(&matrix.map(|row| row.to_vec()))
    }

    #[test]
    fn matrices_are_told_apart() {
        use Verdict::{Definite, Indefinite, Singular};
        assert_eq!(verdict([[1e-9]]), Definite);
        assert_eq!(verdict([[0.0]]), Singular(0));
        assert_eq!(verdict([[-1e-9]]), Indefinite(0));
        // A tonne beside a milligram.
        assert_eq!(verdict([[1e3, 0.0], [0.0, 1e-6]]), Definite);
        assert_eq!(verdict([[1e3, 0.0], [0.0, -1e-6]]), Indefinite(1));
        assert_eq!(verdict([[2.0, 1.0], [1.0, 2.0]]), Definite);
        assert!(matches!(verdict([[1.0, 1.0], [1.0, 1.0]]), Singular(_)));
        assert!(matches!(verdict([[1.0, 2.0], [2.0, 1.0]]), Indefinite(_)));
        assert!(matches!(verdict([[0.0, 1.0], [1.0, 0.0]]), Indefinite(_)));
        assert!(matches!(verdict([[1.0, 1.0], [1.0, 0.0]]), Indefinite(_)));
    }

    #[test]
    fn a_constraint_makes_up_for_inertia() {
        // The second coordinate is massless.
        let mass = [3.0, 0.0, 0.0, 0.0];
        assert_eq!(judge_with_rows(&mass, 2), Verdict::Singular(1));
        let tied = [&mass[..], &[1.0, -1.0]].concat();
        assert_eq!(judge_with_rows(&tied, 2), Verdict::Definite);
    }
}
