//! Every candidate's worth beside the accepted terms, by one linear pass.

use super::dictionary::{Dictionary, Shape};
use super::refine::Explanation;
use super::settle::{Adapt, settle};
use crate::machine::SolveError;
use crate::regression::{Columns, ErrorDynamics, Gram, INVISIBLE, Readings, Whitener};

/// Values of parameters, as (parameter, value).
pub(super) type Assignment = Vec<(usize, f64)>;

/// A candidate as it was seen at one step.
#[derive(Debug, Clone)]
pub struct Considered {
    /// Which candidate.
    pub candidate: usize,
    /// Nats by which it would improve the fit.
    pub gain: f64,
    /// Its gain less the price of its parameters and of the search.
    pub score: f64,
    /// Nats gained on blocks that the fit did not see; nothing where one place of the log
    /// alone shows the candidate.
    pub held_out_gain: Option<f64>,
    /// Shape and strengths.
    pub(super) values: Assignment,
    /// Its columns in the regression.
    pub(super) columns: Vec<usize>,
    /// The same candidate in other shapes that are nearly as good.
    pub(super) other_shapes: Vec<Considered>,
}

/// Two candidates together.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    /// Nats by which both would improve the fit, less the price of their parameters.
    pub score: f64,
    /// With the strengths that they have beside each other.
    pub members: [Considered; 2],
}

/// Several candidates at once.
#[derive(Debug, Clone)]
pub(super) struct Together {
    /// Nats by which they would improve the fit, less the price of their parameters and of the search.
    pub score: f64,
    /// Which they are.
    pub candidates: Vec<usize>,
    /// Shapes, and strengths that they have beside each other.
    pub values: Assignment,
}

/// A candidate's columns in the regression, for one shape.
#[derive(Debug, Clone)]
pub(super) struct ShapedCandidate {
    pub candidate: usize,
    pub shape: usize,
    pub columns: Vec<usize>,
}

/// The regression with all candidates, at one explanation.
pub(super) struct Screen<'a> {
    dictionary: &'a Dictionary,
    explanation: &'a Explanation,
    /// Parameters of the accepted terms.
    pub base: Vec<usize>,
    pub dynamics: ErrorDynamics,
    pub readings: Readings,
    pub options: Vec<ShapedCandidate>,
}

impl<'a> Screen<'a> {
    /// Columns: every parameter at the current values, then the further shapes of the
    /// candidates that are not `accepted`.
    pub fn new(
        dictionary: &'a Dictionary,
        explanation: &'a Explanation,
        accepted: &[usize],
    ) -> Result<Self, SolveError> {
        let shaped: Vec<Vec<f64>> = (1..=dictionary.by_shape.len())
            .map(|shape| with_shape(dictionary, explanation, accepted, shape))
            .collect();
        let focus = dictionary.focus(accepted);
        let observed = &explanation.observed;
        let sensed = observed.record.sensed.as_ref();
        let machine = &dictionary.machine;
        let mut columns = vec![Columns {
            machine,
            tape: &dictionary.by_parameter,
            sensors: Some(&dictionary.sensors),
            instruments: sensed.map(|_| &dictionary.instruments),
            parameters: &explanation.values,
        }];
        for (shape, parameters) in dictionary.by_shape.iter().zip(&shaped) {
            columns.push(Columns {
                machine,
                tape: &shape.slopes,
                sensors: None,
                instruments: sensed.map(|_| &shape.instruments),
                parameters,
            });
        }
        let values = focus.values(&explanation.values);
        let dynamics = ErrorDynamics::new(
            focus.mover(observed, &values),
            &columns,
            &observed.curve,
            observed.hold,
            &observed.correlation,
        )?;
        let accelerations = dynamics.accelerations();
        let values = &explanation.values;
        let readings = explanation
            .observed
            .readings(&focus, values, &accelerations);
        Ok(Self {
            dictionary,
            explanation,
            base: dictionary.parameters_of(accepted),
            dynamics,
            readings,
            options: options(dictionary, accepted),
        })
    }

    /// For every option the products of the data, the accepted parameters and the
    /// option's columns, in this order, whitened under the explanation's noise.
    pub fn grams(&self) -> Vec<Gram> {
        let whitener = Whitener::new(&self.dynamics, &self.readings, &self.explanation.noise);
        let groups: Vec<&[usize]> = self.options.iter().map(|o| o.columns.as_slice()).collect();
        whitener.grams(&self.base, &groups)
    }

    /// Every candidate in its best shapes, the best candidate first, with its other
    /// good shapes beside it.
    pub fn considered(&self, grams: &[Gram]) -> Vec<Considered> {
        let candidates = &self.dictionary.candidates;
        let base: Vec<usize> = (0..self.base.len()).collect();
        let search_price = (candidates.len() as f64).ln();
        let mut best: Vec<Vec<Considered>> = vec![Vec::new(); candidates.len()];
        for (option, gram) in self.options.iter().zip(grams) {
            let Some((kept, values)) = self.possible(gram, option) else {
                continue;
            };
            let with = self.with(&kept);
            let Some((gain, scale)) = self.gain(gram, &with) else {
                continue;
            };
            let free = kept.len() + candidates[option.candidate].shapes[0].len();
            let score = gain - 0.5 * free as f64 * (gram.readings() as f64).ln() - search_price;
            let more = &with[base.len()..];
            let held_out_gain = gram
                .held_out_gain(&base, more)
                .map(|gain| 0.5 * gain / scale);
            best[option.candidate].push(Considered {
                candidate: option.candidate,
                gain,
                score,
                held_out_gain,
                values,
                columns: kept.iter().map(|&i| option.columns[i]).collect(),
                other_shapes: Vec::new(),
            });
        }
        let mut considered: Vec<Considered> = best.into_iter().filter_map(in_best_shape).collect();
        considered.sort_by(|a, b| b.score.total_cmp(&a.score));
        considered
    }

    /// The pairs of `singles` that together explain more than either, by a linear fit, the best
    /// first.
    pub fn pairs(&self, singles: &[&Considered]) -> Vec<Pair> {
        let mut group: Vec<usize> = singles.iter().flat_map(|c| c.columns.clone()).collect();
        group.sort_unstable();
        group.dedup();
        let whitener = Whitener::new(&self.dynamics, &self.readings, &self.explanation.noise);
        let Some(gram) = whitener.grams(&self.base, &[&group]).pop() else {
            return Vec::new();
        };
        let base: Vec<usize> = (0..self.base.len()).collect();
        let base_misfit = gram.fit(&base).misfit;
        let scale = (base_misfit / gram.readings() as f64).max(1.0);
        let places = |c: &Considered| -> Vec<usize> {
            let place = |column: &usize| group.binary_search(column).ok();
            let places = c.columns.iter().filter_map(place);
            places.map(|place| base.len() + place).collect()
        };
        let mut pairs = Vec::new();
        for (index, a) in singles.iter().enumerate() {
            for b in &singles[index + 1..] {
                if a.candidate == b.candidate {
                    continue;
                }
                let with = [base.clone(), places(a), places(b)].concat();
                let fit = gram.fit(&with);
                let gain = 0.5 * (base_misfit - fit.misfit) / scale;
                // Not a number is no gain.
                if gain.is_nan() || gain <= a.gain.max(b.gain) {
                    continue;
                }
                let own = &fit.coefficients.as_slice()[base.len()..];
                let (of_a, of_b) = own.split_at(a.columns.len());
                if let (Some(a), Some(b)) = (self.with_steps(a, of_a), self.with_steps(b, of_b)) {
                    let size = |c: &Considered| self.dictionary.candidates[c.candidate].size();
                    let price = 0.5 * (size(&a) + size(&b)) as f64 * (gram.readings() as f64).ln();
                    pairs.push(Pair {
                        score: gain - price,
                        members: [a, b],
                    });
                }
            }
        }
        pairs.sort_by(|a, b| b.score.total_cmp(&a.score));
        pairs
    }

    /// A candidate with other strengths: its columns' coefficients beside others. `None` if
    /// one is physically impossible.
    fn with_steps(&self, single: &Considered, coefficients: &[f64]) -> Option<Considered> {
        let model = &self.dictionary.machine.compiled.model;
        let mut changed = single.clone();
        let first = changed.values.len() - coefficients.len();
        for ((parameter, value), step) in changed.values[first..].iter_mut().zip(coefficients) {
            *value = self.explanation.values[*parameter] + step;
            let bounds = &model.parameters[*parameter];
            if !(bounds.lower..=bounds.upper).contains(value) {
                return None;
            }
        }
        Some(changed)
    }

    /// Negative log likelihood with candidates' columns and the noise that suits them.
    pub fn profile(&self, considered: &[&Considered]) -> f64 {
        let mut columns = self.base.clone();
        columns.extend(considered.iter().flat_map(|c| &c.columns));
        let mut noise = self.explanation.noise.clone();
        let settled = settle(
            &self.dynamics,
            &self.readings,
            &columns,
            &mut noise,
            Adapt::ToFit,
        );
        settled.cost_of_fit()
    }

    /// Which of the option's columns have a fitted strength that is physically possible,
    /// with shape and strengths; `None` if nothing is left.
    pub fn possible(
        &self,
        gram: &Gram,
        option: &ShapedCandidate,
    ) -> Option<(Vec<usize>, Assignment)> {
        let base: Vec<usize> = (0..self.base.len()).collect();
        self.instead(gram, &base, option)
    }

    /// As [`possible`](Self::possible), in place of an accepted term, beside the `others`.
    pub fn instead(
        &self,
        gram: &Gram,
        others: &[usize],
        option: &ShapedCandidate,
    ) -> Option<(Vec<usize>, Assignment)> {
        let candidate = &self.dictionary.candidates[option.candidate];
        let own = &candidate.strengths[..option.columns.len()];
        let (kept, strengths) = self.strengths(gram, others, own)?;
        let mut values = candidate.shapes[option.shape].clone();
        values.extend(strengths);
        Some((kept, values))
    }

    /// What the candidates of each group are worth all at once, but those of which no strength is
    /// possible beside the others.
    pub fn together(&self, groups: &[Vec<&ShapedCandidate>]) -> Vec<Together> {
        let whitener = Whitener::new(&self.dynamics, &self.readings, &self.explanation.noise);
        let columns = groups.iter().map(|group| {
            let each = group.iter().flat_map(|option| &option.columns);
            each.copied().collect::<Vec<usize>>()
        });
        let columns: Vec<Vec<usize>> = columns.collect();
        let columns: Vec<&[usize]> = columns.iter().map(Vec::as_slice).collect();
        let grams = whitener.grams(&self.base, &columns);
        let each = groups.iter().zip(&grams);
        each.filter_map(|(group, gram)| self.all_of(group, gram))
            .collect()
    }

    /// The candidates of a group at once; `None` if none is possible.
    fn all_of(&self, group: &[&ShapedCandidate], gram: &Gram) -> Option<Together> {
        let candidates = &self.dictionary.candidates;
        let own = group.iter().flat_map(|option| {
            let strengths = &candidates[option.candidate].strengths[..option.columns.len()];
            strengths.iter().map(move |&parameter| (*option, parameter))
        });
        let (options, parameters): (Vec<&ShapedCandidate>, Vec<usize>) = own.unzip();
        let base: Vec<usize> = (0..self.base.len()).collect();
        let (kept, strengths) = self.strengths(gram, &base, &parameters)?;
        let mut members: Vec<&ShapedCandidate> = kept.iter().map(|&i| options[i]).collect();
        members.dedup_by_key(|option| option.candidate);
        let shapes = members
            .iter()
            .flat_map(|option| candidates[option.candidate].shapes[option.shape].clone());
        let values: Assignment = shapes.chain(strengths).collect();
        let (gain, _) = self.gain(gram, &self.with(&kept))?;
        let price = 0.5 * values.len() as f64 * (gram.readings() as f64).ln();
        let chosen = members.len() as f64 * (candidates.len() as f64).ln();
        Some(Together {
            score: gain - price - chosen,
            candidates: members.iter().map(|option| option.candidate).collect(),
            values,
        })
    }

    /// Columns of the accepted terms, and those `kept` of what stands behind them.
    fn with(&self, kept: &[usize]) -> Vec<usize> {
        let base = self.base.len();
        (0..base).chain(kept.iter().map(|i| base + i)).collect()
    }

    /// Nats by which columns improve the fit of the accepted terms, and what a nat is worth: how many times
    /// more variance than sensor noise these leave, at least one. `None` if the gain is no number.
    fn gain(&self, gram: &Gram, with: &[usize]) -> Option<(f64, f64)> {
        let before = gram.fit(&self.with(&[])).misfit;
        let scale = (before / gram.readings() as f64).max(1.0);
        let gain = 0.5 * (before - gram.fit(with).misfit) / scale;
        gain.is_finite().then_some((gain, scale))
    }

    /// Columns, behind those of the accepted terms, whose strengths are possible beside `base`, and these;
    /// `None` if there is none.
    fn strengths(
        &self,
        gram: &Gram,
        base: &[usize],
        parameters: &[usize],
    ) -> Option<(Vec<usize>, Assignment)> {
        let model = &self.dictionary.machine.compiled.model;
        let own = self.base.len();
        let mut kept: Vec<usize> = (0..parameters.len()).collect();
        kept.retain(|&i| gram.size(own + i) > INVISIBLE);
        while !kept.is_empty() {
            let mut with = base.to_vec();
            with.extend(kept.iter().map(|&i| own + i));
            let fit = gram.fit(&with);
            let new = |position: usize, i: usize| {
                let parameter = parameters[i];
                let change = fit.coefficients[base.len() + position];
                (parameter, self.explanation.values[parameter] + change)
            };
            let impossible = kept.iter().enumerate().position(|(position, &i)| {
                let (parameter, value) = new(position, i);
                let parameter = &model.parameters[parameter];
                !(parameter.lower..=parameter.upper).contains(&value)
            });
            if let Some(position) = impossible {
                kept.remove(position);
                continue;
            }
            let strengths = kept
                .iter()
                .enumerate()
                .map(|(position, &i)| new(position, i));
            return Some((kept.clone(), strengths.collect()));
        }
        None
    }
}

/// The best of a candidate's shapes, with the next few beside it.
fn in_best_shape(mut shapes: Vec<Considered>) -> Option<Considered> {
    shapes.sort_by(|a, b| b.score.total_cmp(&a.score));
    // Shapes that cannot be told apart along this log count once.
    shapes.dedup_by(|a, b| (a.gain - b.gain).abs() <= SAME_GAIN * b.gain.abs());
    shapes.truncate(1 + OTHER_SHAPES);
    let mut shapes = shapes.into_iter();
    let mut best = shapes.next()?;
    best.other_shapes = shapes.collect();
    Some(best)
}

/// Relative difference of gains below which two shapes are one.
const SAME_GAIN: f64 = 1e-9;

/// Shapes of a leader that are looked at besides its best one.
const OTHER_SHAPES: usize = 3;

/// The current values, with every candidate that is not accepted in one shape.
fn with_shape(
    dictionary: &Dictionary,
    explanation: &Explanation,
    accepted: &[usize],
    shape: usize,
) -> Vec<f64> {
    let mut values = explanation.values.clone();
    for (index, candidate) in dictionary.candidates.iter().enumerate() {
        if let (Some(shape), false) = (candidate.shapes.get(shape), accepted.contains(&index)) {
            for &(parameter, value) in shape {
                values[parameter] = value;
            }
        }
    }
    values
}

pub(super) fn options(dictionary: &Dictionary, accepted: &[usize]) -> Vec<ShapedCandidate> {
    let candidates = || dictionary.candidates.iter().enumerate();
    let mut options: Vec<ShapedCandidate> = candidates()
        .map(|(candidate, c)| ShapedCandidate {
            candidate,
            shape: 0,
            columns: c.strengths.clone(),
        })
        .collect();
    let mut first = dictionary.defaults.len();
    for (shape, Shape { strengths, .. }) in dictionary.by_shape.iter().enumerate() {
        for (candidate, c) in candidates().filter(|(_, c)| c.shapes.len() > shape + 1) {
            let column_of = |s: &usize| strengths.iter().position(|x| x == s);
            let columns = c.strengths.iter().filter_map(column_of);
            options.push(ShapedCandidate {
                candidate,
                shape: shape + 1,
                columns: columns.map(|c| first + c).collect(),
            });
        }
        first += strengths.len();
    }
    options.retain(|option| !option.columns.is_empty() && !accepted.contains(&option.candidate));
    options
}
