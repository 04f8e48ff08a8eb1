//! What first order says about the hypotheses around a fitted one.

use super::fit::Fitted;
use super::proposal::Proposal;
use crate::machine::SolveError;
use crate::regression::{Gram, Whitener};
use crate::trace::candidate::Candidate;
use crate::trace::dictionary::Dictionary;
use crate::trace::screen::{Assignment, Considered, Screen, ShapedCandidate};
use crate::trace::settings::{NEARLY, TIE};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// A fitted hypothesis with every candidate's columns beside it.
pub struct Neighbourhood<'a> {
    /// What may be there.
    pub dictionary: &'a Dictionary,
    /// The hypothesis in the middle.
    pub fitted: &'a Fitted,
    /// The columns.
    pub screen: Screen<'a>,
    /// Per option of the screen the products of its columns.
    pub grams: Vec<Gram>,
    /// What each further candidate is worth, best first.
    pub considered: Vec<Considered>,
    /// What each was worth beside the model as given.
    pub fresh: &'a [Considered],
    /// Whether the log says what inputs do between samples.
    pub free_hold: bool,
}

/// Candidates that could stand in the place of some terms.
#[derive(Debug, Clone)]
pub struct Exchange {
    /// Which terms.
    pub out: Vec<usize>,
    /// What in their place.
    pub instead: Vec<usize>,
    /// Nats by which it is better to first order (if negative, worse).
    pub better: f64,
    /// Nats by which the log is less likely, to first order, whatever parameters cost.
    pub loss: f64,
    /// Nats that the terms are worth, to first order.
    pub worth: f64,
    /// All the dictionary's parameters with it in that place.
    pub values: Vec<f64>,
}

impl Exchange {
    /// Whether it is better to first order, or nearly as good as what the terms are worth.
    fn is_near(&self) -> bool {
        self.better >= -TIE.max(NEARLY * self.worth)
    }
}

impl<'a> Neighbourhood<'a> {
    /// Around a hypothesis.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn new(
        dictionary: &'a Dictionary,
        fitted: &'a Fitted,
        fresh: &'a [Considered],
        free_hold: bool,
    ) -> Result<Self, SolveError> {
        let terms = fitted.hypothesis.candidates();
        let screen = Screen::new(dictionary, &fitted.explanation, terms)?;
        let grams = screen.grams();
        let mut considered = screen.considered(&grams);
        let is_one_law = |c: usize| terms.iter().any(|&t| dictionary.nested.are_one(t, c));
        considered.retain(|considered| !is_one_law(considered.candidate));
        Ok(Self {
            dictionary,
            fitted,
            screen,
            grams,
            considered,
            fresh,
            free_hold,
        })
    }

    /// The terms of the hypothesis.
    pub fn terms(&self) -> &[usize] {
        self.fitted.hypothesis.candidates()
    }

    /// The values of the hypothesis, with others for some parameters.
    pub fn with(&self, own: &Assignment) -> Vec<f64> {
        let mut values = self.fitted.explanation.values.clone();
        for &(parameter, value) in own {
            values[parameter] = value;
        }
        values
    }

    /// A hypothesis with some candidates more, in the shapes and strengths given.
    pub fn addition(&self, more: &[&Considered], promise: f64) -> Proposal {
        let own: Assignment = more.iter().flat_map(|c| c.values.clone()).collect();
        let candidates: Vec<usize> = more.iter().map(|c| c.candidate).collect();
        Proposal {
            hypothesis: self.fitted.hypothesis.exchange(&[], &candidates),
            values: self.with(&own),
            promise,
            within_reach: self.fitted.estimate.cost,
            ahead: 0.0,
        }
    }

    /// The hypothesis with some terms gone and others in their place, begun as given.
    pub fn exchanged(&self, out: &[usize], more: &[usize], values: Vec<f64>) -> Proposal {
        Proposal {
            hypothesis: self.fitted.hypothesis.exchange(out, more),
            values: self.dictionary.without(out, &values),
            promise: 0.0,
            within_reach: f64::INFINITY,
            ahead: 0.0,
        }
    }

    /// The hypothesis of an exchange, begun where first order says.
    pub fn proposal(&self, exchange: Exchange) -> Proposal {
        let Exchange {
            out,
            instead,
            better,
            loss,
            values,
            ..
        } = exchange;
        Proposal {
            hypothesis: self.fitted.hypothesis.exchange(&out, &instead),
            promise: -better,
            values,
            within_reach: self.fitted.estimate.cost + loss,
            ahead: 0.0,
        }
    }

    /// Whether a candidate acts where another does.
    pub fn is_beside(&self, a: usize, b: usize) -> bool {
        let [a, b] = [a, b].map(|c| self.dictionary.candidates[c].subject.on());
        a == b
    }

    /// What of the `wanted` candidates could stand in the place of some terms, in its best shape
    /// each, best first: what is better to first order, or nearly as good as what they are worth.
    pub fn exchanges(&self, out: &[usize], wanted: impl Fn(usize) -> bool) -> Vec<Exchange> {
        let found = self.exchanges_in_shape(out, wanted);
        let found = found.into_iter().map(|(_, exchange)| exchange);
        found.filter(Exchange::is_near).collect()
    }

    /// What each of the `wanted` candidates would be in the place of some terms, in which option of
    /// the screen, best first.
    pub fn exchanges_in_shape(
        &self,
        out: &[usize],
        wanted: impl Fn(usize) -> bool,
    ) -> Vec<(usize, Exchange)> {
        let mut found: BTreeMap<usize, (usize, Exchange)> = BTreeMap::new();
        let options = self.screen.options.iter().zip(&self.grams).enumerate();
        for (place, (option, gram)) in options.filter(|(_, (o, _))| wanted(o.candidate)) {
            let Some(exchange) = self.exchange(out, &[option], gram) else {
                continue;
            };
            let known = found.get(&option.candidate);
            if known.is_none_or(|(_, known)| exchange.better > known.better) {
                found.insert(option.candidate, (place, exchange));
            }
        }
        let mut found: Vec<(usize, Exchange)> = found.into_values().collect();
        found.sort_by(|a, b| b.1.better.total_cmp(&a.1.better));
        found
    }

    /// Two candidates of the same place with fewer parameters together in the place of a rich
    /// term, in the shapes that suit them beside each other, best first.
    pub fn splits(&self, term: usize) -> Vec<Exchange> {
        let size = |c: usize| self.dictionary.candidates[c].size();
        let is_simpler = |o: &&ShapedCandidate| {
            self.is_beside(o.candidate, term) && size(o.candidate) < size(term)
        };
        let options: Vec<&ShapedCandidate> =
            self.screen.options.iter().filter(is_simpler).collect();
        let is_pair = |(a, b): &(&ShapedCandidate, &ShapedCandidate)| {
            a.candidate != b.candidate && size(a.candidate) + size(b.candidate) < size(term)
        };
        let after = |(i, &a)| options[i + 1..].iter().map(move |&b| (a, b));
        let pairs = options.iter().enumerate().flat_map(after);
        let pairs: Vec<(&ShapedCandidate, &ShapedCandidate)> = pairs.filter(is_pair).collect();
        if pairs.is_empty() {
            return Vec::new();
        }
        let mut columns: Vec<usize> = options.iter().flat_map(|o| o.columns.clone()).collect();
        columns.sort_unstable();
        columns.dedup();
        let noise = &self.fitted.explanation.noise;
        let whitener = Whitener::new(&self.screen.dynamics, &self.screen.readings, noise);
        let base = self.screen.base.len();
        let all = whitener.gram(&[&self.screen.base[..], &columns].concat());
        let place = |column: &usize| base + columns.partition_point(|c| c < column);
        let each = pairs.into_par_iter().filter_map(|(a, b)| {
            let own = a.columns.iter().chain(&b.columns).map(place);
            let gram = all.part(&(0..base).chain(own).collect::<Vec<_>>());
            self.exchange(&[term], &[a, b], &gram)
        });
        let mut found: Vec<Exchange> = each.filter(Exchange::is_near).collect();
        found.sort_by(|a, b| b.better.total_cmp(&a.better));
        let mut seen = BTreeSet::new();
        found.retain(|exchange| seen.insert(exchange.instead.clone()));
        found
    }

    /// Some options in the place of some terms, to first order; `None` if that is not possible.
    fn exchange(
        &self,
        out: &[usize],
        options: &[&ShapedCandidate],
        gram: &Gram,
    ) -> Option<Exchange> {
        let dictionary = self.dictionary;
        let base: Vec<usize> = (0..self.screen.base.len()).collect();
        let own = || out.iter().map(|&term| &dictionary.candidates[term]);
        let is_own = |&i: &usize| own().any(|own| own.parameters.contains(&self.screen.base[i]));
        let (mine, others): (Vec<usize>, Vec<usize>) = base.iter().partition(|i| is_own(i));
        let values = &self.fitted.explanation.values;
        // Without the terms: their part goes back into the data.
        let shift: Vec<(usize, f64)> = mine
            .iter()
            .map(|&i| (i, self.screen.base[i]))
            .filter(|(_, p)| own().any(|own| own.strengths.contains(p)))
            .map(|(i, p)| (i, values[p] - dictionary.defaults[p]))
            .collect();
        let rows = gram.readings() as f64;
        let whole = gram.fit(&base).misfit;
        let shifted = gram.with_data_shifted(&shift);
        let scale = (whole / rows).max(1.0);
        let worth = 0.5 * (shifted.fit(&others).misfit - whole) / scale;
        let (kept, assignment) = match options {
            [option] => self.screen.instead(&shifted, &others, option)?,
            _ => self.both(&shifted, &others, options)?,
        };
        let with: Vec<usize> = others
            .iter()
            .copied()
            .chain(kept.iter().map(|i| base.len() + i))
            .collect();
        let fit = shifted.fit(&with);
        let candidates = options.iter().map(|o| o.candidate);
        let size: usize = candidates
            .clone()
            .map(|c| dictionary.candidates[c].size())
            .sum();
        let gone: usize = own().map(Candidate::size).sum();
        let price = 0.5 * (size as f64 - gone as f64) * rows.ln();
        let loss = 0.5 * (fit.misfit - whole) / scale;
        let better = -loss - price;
        if better.is_nan() {
            return None;
        }
        let bounds = &dictionary.machine.compiled.model.parameters;
        let mut moved = dictionary.without(out, values);
        for (&i, step) in others.iter().zip(fit.coefficients.iter()) {
            let parameter = self.screen.base[i];
            let (lower, upper) = (bounds[parameter].lower, bounds[parameter].upper);
            moved[parameter] = (moved[parameter] + step).clamp(lower, upper);
        }
        for (parameter, value) in assignment {
            moved[parameter] = value;
        }
        Some(Exchange {
            out: out.to_vec(),
            instead: candidates.collect(),
            worth,
            better,
            loss,
            values: moved,
        })
    }

    /// Two options with the strengths that they have beside each other; `None` if one is not
    /// possible. The columns of the second follow those of the first.
    fn both(
        &self,
        gram: &Gram,
        others: &[usize],
        options: &[&ShapedCandidate],
    ) -> Option<(Vec<usize>, Assignment)> {
        let count: usize = options.iter().map(|o| o.columns.len()).sum();
        let kept: Vec<usize> = (0..count).collect();
        let with: Vec<usize> = others
            .iter()
            .copied()
            .chain(kept.iter().map(|i| self.screen.base.len() + i))
            .collect();
        let fit = gram.fit(&with);
        let mut steps = fit.coefficients.iter().skip(others.len());
        let model = &self.dictionary.machine.compiled.model;
        let mut assignment = Assignment::new();
        for option in options {
            let candidate = &self.dictionary.candidates[option.candidate];
            assignment.extend(candidate.shapes[option.shape].iter().copied());
            for (&parameter, step) in candidate.strengths.iter().zip(steps.by_ref()) {
                let value = self.fitted.explanation.values[parameter] + step;
                let bounds = &model.parameters[parameter];
                if !(bounds.lower..=bounds.upper).contains(&value) {
                    return None;
                }
                assignment.push((parameter, value));
            }
        }
        Some((kept, assignment))
    }
}
