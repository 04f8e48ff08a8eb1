//! Fewer or plainer terms that do as well once shapes have moved.
//!
//! Terms are chosen in the few shapes that are tried. A load at nearly the right place leaves a rest for
//! which a second effect on the body is taken, and friction that is nearly steep enough one for which a
//! richer law is. Where shapes have moved to where they explain most, neither is needed.

use super::balance::Balance;
use super::choose::{Choice, Chosen};
use super::settle::{Settled, settle};
use crate::machine::SolveError;
use crate::trace::settings::FAR_BEHIND;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

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

    /// The same with less: without a term, or with a plainer law in the place of one, as often as that
    /// costs less than what it leaves.
    pub fn plainer(self, choice: &Choice<'_>, balance: &Balance) -> Self {
        let mut best = self;
        loop {
            let trials: Vec<(Vec<Chosen>, Vec<f64>)> = best
                .without_one(choice)
                .chain(best.with_one_plainer(choice))
                .collect();
            let trials = trials.into_par_iter().filter_map(|(terms, values)| {
                // Where its equations have no solution it is no explanation.
                Self::new((choice, balance), terms, values).ok()
            });
            let next = trials.min_by(|a, b| a.cost(choice).total_cmp(&b.cost(choice)));
            match next.filter(|next| next.cost(choice) < best.cost(choice)) {
                Some(next) => best = next,
                None => return best,
            }
        }
    }

    /// Nats: what is left, and what all that is stated costs.
    fn cost(&self, choice: &Choice<'_>) -> f64 {
        let candidates = choice.candidates(&self.terms).into_iter();
        self.settled.left + candidates.map(|c| choice.price_of(c)).sum::<f64>()
    }

    /// Without each of the terms that are not far too good to be left out, where a fit may begin.
    fn without_one<'a>(
        &'a self,
        choice: &'a Choice<'_>,
    ) -> impl Iterator<Item = (Vec<Chosen>, Vec<f64>)> + 'a {
        let weak = (0..self.terms.len()).filter(|&i| self.worth(choice, i) < FAR_BEHIND);
        weak.map(|i| {
            let mut others = self.terms.clone();
            others.remove(i);
            (others, self.reset(choice, i))
        })
    }

    /// With each law that is a special case of a term's, or of which both are, and has fewer numbers.
    fn with_one_plainer<'a>(
        &'a self,
        choice: &'a Choice<'_>,
    ) -> impl Iterator<Item = (Vec<Chosen>, Vec<f64>)> + 'a {
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
                let mut start = self.reset(choice, i);
                for &(parameter, value) in &choice.dictionary.candidates[plain].shapes[shaped.shape]
                {
                    start[parameter] = value;
                }
                Some((terms, start))
            })
        })
    }

    /// Values without a term's.
    fn reset(&self, choice: &Choice<'_>, term: usize) -> Vec<f64> {
        let dictionary = choice.dictionary;
        let candidate = choice.candidates(&self.terms)[term];
        let mut values = self.settled.values.clone();
        for &parameter in &dictionary.candidates[candidate].parameters {
            values[parameter] = dictionary.defaults[parameter];
        }
        values
    }

    /// Nats that a term is worth to second order: `½ xᵀ C⁻¹ x` of its strengths and their covariance.
    fn worth(&self, choice: &Choice<'_>, term: usize) -> f64 {
        let dictionary = choice.dictionary;
        let candidates = choice.candidates(&self.terms);
        let all = dictionary.parameters_of(&candidates);
        let strengths = &dictionary.candidates[candidates[term]].strengths;
        let own: Vec<usize> = (0..all.len())
            .filter(|&i| strengths.contains(&all[i]))
            .collect();
        let x = DVector::from_iterator(
            own.len(),
            own.iter()
                .map(|&i| self.settled.values[all[i]] - dictionary.defaults[all[i]]),
        );
        let covariance = DMatrix::from_fn(own.len(), own.len(), |a, b| {
            self.settled.covariance[(own[a], own[b])]
        });
        // What has no covariance is not known, and may well be nothing.
        covariance
            .cholesky()
            .map_or(0.0, |c| 0.5 * x.dot(&c.solve(&x)))
    }
}
