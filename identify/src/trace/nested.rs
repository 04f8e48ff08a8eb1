//! Laws that are special cases of others: a joint has one law of each kind.

use super::dictionary::{Dictionary, Ranges};
use super::remembered::is_memoryless;
use super::screen::{ShapedCandidate, options};
use crate::machine::{SensitivityTape, States};
use crate::regression::{Gram, INVISIBLE};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Squared multiple correlation from which a law is in another.
const CONTAINED: f64 = 0.999;
/// States at which laws are compared.
const STATES: usize = 300;

/// Pairs of candidates of one place that are one law in two shapes: one does in some shape what the
/// other does, or both do what a third does. Friction that differs by direction is Coulomb's where it
/// does not differ, and so is Stribeck's where breaking away takes no more than sliding. No hypothesis
/// holds both.
#[derive(Debug, Clone, Default)]
pub struct Nested {
    /// The pairs, the smaller number first.
    one: BTreeSet<(usize, usize)>,
    /// A law, and a special case of it.
    special: BTreeSet<(usize, usize)>,
}

impl Nested {
    /// Compares the forces of laws at states drawn from where a log goes, with velocities of either
    /// sign. Laws that remember, or are about channels, are not compared.
    pub(super) fn new(dictionary: &Dictionary, ranges: &Ranges) -> Self {
        let mut places: BTreeMap<Vec<String>, Vec<ShapedCandidate>> = BTreeMap::new();
        for option in options(dictionary, &[]) {
            if is_memoryless(dictionary, option.candidate) {
                let on = dictionary.candidates[option.candidate].subject.on();
                places.entry(on).or_default().push(option);
            }
        }
        places.retain(|_, options| options.iter().any(|o| o.candidate != options[0].candidate));
        if places.is_empty() {
            return Self::default();
        }
        let forces = forces(dictionary, ranges);
        let places: Vec<Vec<ShapedCandidate>> = places.into_values().collect();
        let each = places.par_iter().map(|options| contained(options, &forces));
        Self::of(each.flatten_iter().collect())
    }

    /// Of candidates in which others are contained: a special case, and in what.
    fn of(contained: BTreeSet<(usize, usize)>) -> Self {
        let ordered = |(a, b): (usize, usize)| (a.min(b), a.max(b));
        let siblings = contained.iter().flat_map(|&(special, a)| {
            let others = contained.range((special, a + 1)..(special + 1, 0));
            others.map(move |&(_, b)| (a, b))
        });
        let pairs = contained.iter().copied();
        let special = contained.iter().map(|&(special, law)| (law, special));
        // Two laws that each contain the other are one by two names.
        let special = special.filter(|pair| !contained.contains(pair));
        Self {
            one: pairs.chain(siblings).map(ordered).collect(),
            special: special.collect(),
        }
    }

    /// What a candidate is in some of its shapes, and is not in all.
    pub fn special_cases(&self, candidate: usize) -> impl Iterator<Item = usize> {
        let own = (candidate, 0)..(candidate + 1, 0);
        self.special.range(own).map(|&(_, special)| special)
    }

    /// Whether two candidates are one law.
    pub fn are_one(&self, a: usize, b: usize) -> bool {
        self.one.contains(&(a.min(b), a.max(b)))
    }

    /// Whether some candidates hold two that are one law.
    pub fn doubles(&self, candidates: &[usize]) -> bool {
        let mut each = candidates.iter().enumerate();
        each.any(|(i, &a)| candidates[i + 1..].iter().any(|&b| self.are_one(a, b)))
    }

    /// What is one law with a candidate.
    pub fn beside(&self, candidate: usize) -> impl Iterator<Item = usize> {
        let of = move |&(a, b): &(usize, usize)| match candidate {
            c if c == a => Some(b),
            c if c == b => Some(a),
            _ => None,
        };
        self.one.iter().filter_map(of)
    }
}

/// Candidates that are others in some shape of these, among the options of one place: each with what it is in.
fn contained(options: &[ShapedCandidate], forces: &[Vec<Vec<f64>>]) -> BTreeSet<(usize, usize)> {
    let mut columns: Vec<usize> = options.iter().flat_map(|o| o.columns.clone()).collect();
    columns.sort_unstable();
    columns.dedup();
    let rows = forces[0].len() * STATES;
    let of_column = |column: &usize| forces[*column].iter().flatten().copied();
    let entries = std::iter::repeat_n(0.0, rows).chain(columns.iter().flat_map(of_column));
    let entries = DMatrix::from_iterator(rows, columns.len() + 1, entries);
    let gram = Gram::new(&entries, std::slice::from_ref(&(0..rows)), rows);
    let own = |option: &ShapedCandidate| -> Vec<usize> {
        let places = option.columns.iter();
        let places = places.map(|column| columns.partition_point(|c| c < column));
        places
            .filter(|&place| gram.size(place) > INVISIBLE)
            .collect()
    };
    let mut contained = BTreeSet::new();
    for special in options.iter().filter(|option| option.shape == 0) {
        let wanted = own(special);
        let others = options.iter().filter(|o| o.candidate != special.candidate);
        for other in others {
            let theirs = own(other);
            let pair = (special.candidate, other.candidate);
            if wanted.is_empty() || theirs.len() < wanted.len() || contained.contains(&pair) {
                continue;
            }
            let is_in = |&column: &usize| gram.explained_by(column, &theirs) > CONTAINED;
            if wanted.iter().all(is_in) {
                contained.insert(pair);
            }
        }
    }
    contained
}

/// What a unit of each column of [`options`] adds to the force on each coordinate at each state.
fn forces(dictionary: &Dictionary, ranges: &Ranges) -> Vec<Vec<Vec<f64>>> {
    let machine = &dictionary.machine;
    let (states, accelerations) = drawn(ranges);
    let of = |tape: &SensitivityTape, values: &[f64]| {
        tape.forces(&machine.at_rest(&states, values), values, &accelerations)
    };
    let defaults = &dictionary.defaults;
    let mut forces = of(&dictionary.by_parameter, defaults);
    for (shape, further) in dictionary.by_shape.iter().enumerate() {
        let mut values = defaults.clone();
        for candidate in &dictionary.candidates {
            for &(parameter, value) in candidate.shapes.get(shape + 1).into_iter().flatten() {
                values[parameter] = value;
            }
        }
        forces.extend(of(&further.slopes, &values));
    }
    forces
}

/// States all over where a log goes, and accelerations. The same each time.
fn drawn(ranges: &Ranges) -> (States, Vec<Vec<f64>>) {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut column = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..STATES).map(|_| of(random.random())).collect()
    };
    let mut within = |sorted: &Vec<f64>| {
        let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied();
        column(&|share| at(share).unwrap_or(0.0))
    };
    let q = ranges.positions.iter().map(&mut within).collect();
    let u = ranges.inputs.iter().map(&mut within).collect();
    let mut of_either_sign = |&size: &f64| column(&|share| 2.0 * size * (2.0 * share - 1.0));
    let v = ranges.speeds.iter().map(&mut of_either_sign).collect();
    let a = ranges.speeds.iter().map(&mut of_either_sign).collect();
    let states = States {
        t: vec![0.0; STATES],
        q,
        v,
        u,
        ..States::default()
    };
    (states, a)
}

#[cfg(test)]
mod tests {
    use crate::trace::wheel::{WHEEL, begun, named, turned};
    use std::fmt::Write;

    #[test]
    fn a_joint_has_one_law_of_dry_friction() {
        let log = turned([(1.0, 3.0), (0.0, 7.0)], (6, 1e-5), |[_, _, a]| 0.02 * a);
        let (dictionary, _) = begun(WHEEL, &log, ["angle", "motor"]);
        let is_one = |a: &str, b: &str| {
            let [a, b] = [a, b].map(|name| named(&dictionary, &format!("{name}(angle)")));
            dictionary.nested.are_one(a, b)
        };
        assert!(is_one("coulomb", "asymmetric_coulomb") && is_one("viscous", "stribeck"));
        let is_special = |a: &str, b: &str| {
            let [a, b] = [a, b].map(|name| named(&dictionary, &format!("{name}(angle)")));
            let mut special = dictionary.nested.special_cases(b);
            special.any(|case| case == a)
        };
        assert!(is_special("coulomb", "stribeck") && is_special("viscous", "stribeck"));
        assert!(!is_special("stribeck", "coulomb"));
        assert!(!is_special("asymmetric_coulomb", "stribeck"));
        // Neither is the other, but both are Coulomb's.
        assert!(is_one("stribeck", "asymmetric_coulomb"));
        assert!(!is_one("coulomb", "viscous") && !is_one("viscous", "spring"));
    }

    /// A wheel that never turns back shows friction as a constant force; they are two laws still.
    #[test]
    fn what_one_log_cannot_tell_apart_are_two_laws() {
        let mut log = String::from("t,q_angle,u_motor\n");
        for k in 0..1000 {
            let t = 0.005 * f64::from(k);
            writeln!(
                log,
                "{t},{},{}",
                6.0 * t + (3.0 * t).sin(),
                -0.18 * (3.0 * t).sin()
            )
            .unwrap();
        }
        let (dictionary, _) = begun(WHEEL, &log, ["angle", "motor"]);
        let [dry, constant] =
            ["coulomb(angle)", "constant_force(angle)"].map(|name| named(&dictionary, name));
        assert!(!dictionary.nested.are_one(dry, constant));
        let rich = named(&dictionary, "stribeck(angle)");
        assert!(dictionary.nested.doubles(&[dry, constant, rich]));
        assert!(!dictionary.nested.doubles(&[dry, constant]));
    }
}
