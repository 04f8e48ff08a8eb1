//! Velocities that are not the rates of their positions. No model is needed to see that.

use super::mistake::{Column, Kind, Mistake, UNITS};
use super::seen::Seen;

/// A velocity that follows the rate of a position this closely (their correlation through zero)
/// is that rate, but for a factor.
const FOLLOWS: f64 = 0.9;
/// A factor that is at least this far from one, as a share of it, is not a calibration.
const ANOTHER_UNIT: f64 = 0.2;
/// A factor within this share of a unit's is that unit: no two units are as near.
const NEAR: f64 = 0.1;

/// A velocity that is not the rate of its position.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Odd {
    /// Of which coordinate.
    pub coordinate: usize,
    /// How many times the rate it is.
    pub factor: f64,
    /// The mistakes that would explain it; none where no unit has this factor.
    pub mistakes: Vec<Mistake>,
}

/// The first velocity that is not the rate of its position and is not among the `known`.
pub(super) fn odd(seen: &Seen, is_angle: &[bool], known: &[usize]) -> Option<Odd> {
    let coordinates = 0..seen.coordinates();
    let swapped = || coordinates.clone().find_map(|i| swapped(seen, i));
    let scaled = |i: usize| {
        let (factor, likeness) = compared(seen, i, i)?;
        let is_odd = likeness.abs() > FOLLOWS && (factor - 1.0).abs() > ANOTHER_UNIT;
        is_odd.then(|| Odd {
            coordinate: i,
            factor,
            mistakes: explanations(i, factor, is_angle[i]),
        })
    };
    let mut unknown = coordinates.clone().filter(|i| !known.contains(i));
    unknown.find_map(scaled).or_else(swapped)
}

/// By what factor and how closely the velocity of one coordinate follows the rate of another.
fn compared(seen: &Seen, of: usize, beside: usize) -> Option<(f64, f64)> {
    let (logged, rate) = seen.rates(of, beside)?;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (both, own, other) = (
        product(logged, rate),
        product(rate, rate),
        product(logged, logged),
    );
    // What stands still is like nothing.
    (own > 0.0 && other > 0.0).then(|| (both / own, both / (own * other).sqrt()))
}

/// Two coordinates whose velocities are the rates of each other's positions, not of their own.
fn swapped(seen: &Seen, i: usize) -> Option<Odd> {
    let follows = |of: usize, beside: usize| {
        let same = |(factor, likeness): (f64, f64)| {
            likeness > FOLLOWS && (factor - 1.0).abs() < ANOTHER_UNIT
        };
        compared(seen, of, beside).map(same)
    };
    let crossed = |k: &usize| {
        let (own, other) = (
            [follows(i, i), follows(*k, *k)],
            [follows(i, *k), follows(*k, i)],
        );
        own == [Some(false); 2] && other == [Some(true); 2]
    };
    let k = (i + 1..seen.coordinates()).find(crossed)?;
    let exchanged =
        |kind: Kind| Mistake::Swapped(vec![(Column { kind, index: i }, Column { kind, index: k })]);
    Some(Odd {
        coordinate: i,
        factor: 1.0,
        mistakes: vec![exchanged(Kind::Position), exchanged(Kind::Velocity)],
    })
}

/// The mistakes by which a velocity is `factor` times the rate of its position.
fn explanations(coordinate: usize, factor: f64, angle: bool) -> Vec<Mistake> {
    let near = |expected: f64| (factor.abs() / expected - 1.0).abs() < NEAR;
    let reversed = factor < 0.0;
    let column = |kind: Kind| Column {
        kind,
        index: coordinate,
    };
    let both = [Kind::Velocity, Kind::Position];
    if near(1.0) {
        let each = both.map(|kind| Mistake::reversed(vec![column(kind)]));
        return each.into();
    }
    let own = UNITS.iter().filter(|unit| unit.angle == angle);
    let tried = own.flat_map(|unit| both.map(|kind| (unit, kind)));
    let explains = tried.filter(|&(unit, kind)| match kind {
        Kind::Velocity => near(1.0 / unit.size),
        _ => !unit.speed && near(unit.size),
    });
    let mistake = |(unit, kind)| Mistake::Scaled {
        columns: vec![column(kind)],
        reversed,
        unit: Some(unit),
    };
    explains.map(mistake).collect()
}
