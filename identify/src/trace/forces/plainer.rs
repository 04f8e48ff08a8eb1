//! Fewer or plainer terms that do as well once shapes have moved.
//!
//! Terms are chosen in the few shapes that are tried. A load at nearly the right place leaves a rest for
//! which a second effect on the body is taken, and friction that is nearly steep enough one for which a
//! richer law is. Where shapes have moved to where they explain most, neither is needed.

use super::balance::Balance;
use super::choose::{Choice, Chosen};
use super::settle::{Settled, settle};
use crate::machine::SolveError;
use crate::trace::finding::worth;
use crate::trace::settings::SHORTLISTED;
use rayon::prelude::*;

/// Terms that may do as well.
struct Trial {
    terms: Vec<Chosen>,
    /// Where a fit may begin: all parameters.
    values: Vec<f64>,
    /// Nats that they do not cost again.
    spared: f64,
}

/// Terms, and where they explain most.
pub(super) struct Explained {
    pub terms: Vec<Chosen>,
    pub settled: Settled,
}

impl Explained {
    /// Some terms, from values of all parameters.
    ///
    /// # Errors
    /// If a state's equation has no solution along the curve.
    pub fn new(
        (choice, balance): (&Choice<'_>, &Balance),
        terms: Vec<Chosen>,
        values: Vec<f64>,
    ) -> Result<Self, SolveError> {
        let accepted = choice.candidates(&terms);
        let settled = settle(
            choice.dictionary,
            balance,
            choice.equations,
            &accepted,
            values,
        )?;
        Ok(Self { terms, settled })
    }

    /// The same with less: without a term, or with a plainer law or two in the place of one, as often as
    /// that costs less than what it leaves.
    pub fn plainer(self, choice: &Choice<'_>, balance: &Balance) -> Self {
        let mut best = self;
        loop {
            let trials: Vec<Trial> = best
                .without_one(choice)
                .chain(best.with_one_plainer(choice))
                .chain(best.with_two_plainer(choice))
                .collect();
            let trials = trials.into_par_iter().filter_map(|trial| {
                // Where its equations have no solution it is no explanation.
                let found = Self::new((choice, balance), trial.terms, trial.values).ok()?;
                Some((found.cost(choice) - trial.spared, found))
            });
            let next = trials.min_by(|a, b| a.0.total_cmp(&b.0));
            match next.filter(|(cost, _)| *cost < best.cost(choice)) {
                Some((_, next)) => best = next,
                None => return best,
            }
        }
    }

    /// Nats: what is left, and what all that is stated costs.
    fn cost(&self, choice: &Choice<'_>) -> f64 {
        let candidates = choice.candidates(&self.terms).into_iter();
        self.settled.left + candidates.map(|c| choice.price_of(c)).sum::<f64>()
    }

    /// Without each of the terms that are worth least, where a fit may begin.
    fn without_one<'a>(&'a self, choice: &'a Choice<'_>) -> impl Iterator<Item = Trial> + 'a {
        let worth = |i| (self.worth(choice, i), i);
        let mut all: Vec<(f64, usize)> = (0..self.terms.len()).map(worth).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let weak = all.into_iter().take(SHORTLISTED);
        weak.map(|(_, i)| {
            let mut others = self.terms.clone();
            others.remove(i);
            Trial {
                terms: others,
                values: self.values_without(choice, i),
                spared: 0.0,
            }
        })
    }

    /// With each law that is a special case of a term's, or of which both are, and has fewer numbers.
    fn with_one_plainer<'a>(&'a self, choice: &'a Choice<'_>) -> impl Iterator<Item = Trial> + 'a {
        let candidates = choice.candidates(&self.terms);
        let each = candidates.into_iter().enumerate();
        each.flat_map(move |(i, rich)| {
            let plainer = choice.plainer_than(rich).into_iter();
            plainer.filter_map(move |plain| {
                let option = choice.most_like(&self.terms[i], plain)?;
                let shaped = &choice.options[option];
                let mut terms = self.terms.clone();
                terms[i] = Chosen {
                    option,
                    kept: (0..shaped.columns.len()).collect(),
                };
                let mut start = self.values_without(choice, i);
                for &(parameter, value) in &choice.dictionary.candidates[plain].shapes[shaped.shape]
                {
                    start[parameter] = value;
                }
                Some(Trial {
                    terms,
                    values: start,
                    spared: 0.0,
                })
            })
        })
    }

    /// With two laws that are special cases of a term's in its place, where they have fewer numbers: in the shapes
    /// that suit them beside each other and the other terms.
    fn with_two_plainer<'a>(&'a self, choice: &'a Choice<'_>) -> impl Iterator<Item = Trial> + 'a {
        let candidates = choice.candidates(&self.terms).into_iter().enumerate();
        candidates.flat_map(move |(i, rich)| {
            let mut others = self.terms.clone();
            others.remove(i);
            let pairs = choice.pairs_plainer_than(rich).into_iter();
            pairs.filter_map(move |pair| {
                let two = choice.best_beside(&others, pair)?;
                let mut start = self.values_without(choice, i);
                for chosen in &two {
                    let shaped = &choice.options[chosen.option];
                    let shapes = &choice.dictionary.candidates[shaped.candidate].shapes;
                    for &(parameter, value) in &shapes[shaped.shape] {
                        start[parameter] = value;
                    }
                }
                Some(Trial {
                    terms: [&others[..], &two].concat(),
                    values: start,
                    // What a rich law is made of is no more to be looked for than that is.
                    spared: choice.price_of_numbers(0),
                })
            })
        })
    }

    /// Values without a term's.
    fn values_without(&self, choice: &Choice<'_>, term: usize) -> Vec<f64> {
        let candidate = choice.candidates(&self.terms)[term];
        let values = &self.settled.values;
        choice.dictionary.without(&[candidate], values)
    }

    /// Nats that a term is worth to second order.
    fn worth(&self, choice: &Choice<'_>, term: usize) -> f64 {
        let candidates = choice.candidates(&self.terms);
        let all = choice.dictionary.parameters_of(&candidates);
        let known = (&all[..], &self.settled.covariance);
        worth(
            choice.dictionary,
            candidates[term],
            &self.settled.values,
            known,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::dictionary::Dictionary;
    use crate::trace::forces::equations::Equations;
    use crate::trace::forces::reach::reaches;
    use crate::trace::forces::{columns, first_columns, force_options, weighed};
    use crate::trace::wheel::{WHEEL, begun, named, rectangular};
    use std::fmt::Write;

    /// A wheel with dry friction, whose steepness lies between those that are tried, and some viscous friction.
    fn rubbing(viscous: f64) -> String {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(6);
        for k in 0..2000 {
            let t = 0.005 * f64::from(k);
            let q = (3.0 * t).sin() + 0.4 * (7.3 * t).sin();
            let v = 3.0 * (3.0 * t).cos() + 2.92 * (7.3 * t).cos();
            let a = -9.0 * (3.0 * t).sin() - 21.316 * (7.3 * t).sin();
            let friction = 0.05 * (v / 0.037).tanh() + viscous * v;
            let u = 0.02 * a + friction + 1e-3 * noise();
            writeln!(text, "{t},{},{u}", q + 1e-6 * noise()).unwrap();
        }
        text
    }

    fn names(dictionary: &Dictionary, candidates: &[usize]) -> Vec<String> {
        let name = |&c: &usize| dictionary.candidates[c].subject.to_string();
        candidates.iter().map(name).collect()
    }

    /// What becomes of some terms: what they are called then, their values, and nats that more is left.
    fn plainer(log: &str, terms: &[&str]) -> (Vec<String>, Vec<f64>, f64) {
        let (dictionary, start) = begun(WHEEL, log, ["angle", "motor"]);
        let observed = &start.observed;
        let balance = Balance::narrowed(&observed.record, observed.hold, 1).unwrap();
        let missing = balance.missing(&dictionary.machine, &dictionary.defaults);
        let missing = missing.unwrap();
        let columns = columns(&dictionary, &balance).unwrap();
        let options = force_options(&dictionary);
        let equations = weighed(Equations::new(&missing, &columns), &first_columns(&options));
        let (gram, visible) = (equations.gram(), equations.visible());
        let choice = Choice {
            dictionary: &dictionary,
            options: &options,
            gram,
            visible,
            equations: &equations,
            reaches: reaches(&dictionary),
        };
        let terms = terms.iter().map(|name| {
            let candidate = named(&dictionary, name);
            let option = options.iter().position(|o| o.candidate == candidate);
            let option = option.unwrap();
            Chosen {
                option,
                kept: (0..options[option].columns.len()).collect(),
            }
        });
        let defaults = dictionary.defaults.clone();
        let rich = Explained::new((&choice, &balance), terms.collect(), defaults).unwrap();
        let left = rich.settled.left;
        let plain = rich.plainer(&choice, &balance);
        let found = choice.candidates(&plain.terms);
        let values = dictionary.parameters_of(&found).into_iter();
        let values = values.map(|parameter| plain.settled.values[parameter]);
        let left = plain.settled.left - left;
        (names(&dictionary, &found), values.collect(), left)
    }

    #[test]
    fn what_is_dry_friction_is_called_so_alone() {
        // A law that is richer than what is there, and one that is not there at all.
        let (names, values, left) = plainer(&rubbing(0.0), &["stribeck(angle)", "spring(angle)"]);
        assert_eq!(names, ["coulomb(angle)"]);
        assert!(left < 10.0);
        let [f_c, v_s] = values[..] else {
            panic!("two numbers");
        };
        assert!((f_c - 0.05).abs() < 1e-3, "{f_c}");
        assert!((v_s - 0.037).abs() < 5e-3, "{v_s}");
    }

    #[test]
    fn dry_and_viscous_friction_are_called_so() {
        let (names, values, left) = plainer(&rubbing(0.01), &["stribeck(angle)"]);
        assert_eq!(names, ["coulomb(angle)", "viscous(angle)"]);
        assert!(left < 10.0);
        let [f_c, v_s, d] = values[..] else {
            panic!("three numbers");
        };
        assert!((f_c - 0.05).abs() < 1e-3, "{f_c}");
        assert!((v_s - 0.037).abs() < 5e-3, "{v_s}");
        assert!((d - 0.01).abs() < 5e-4, "{d}");
    }
}
