//! Forward selection with re-judgement: which candidates earn their place?

use super::dictionary::{Candidate, Dictionary, Subject};
use super::estimate::Observed;
use super::refine::{Estimate, refine};
use crate::machine::{SensitivityTape, SolveError};
use crate::regression::{
    Columns, ErrorDynamics, Gram, Hold, INVISIBLE, ProcessNoise, Readings, Whitener,
};
use dynamics_codegen::derive::Variable;
use nalgebra::DVector;

/// A term that was accepted.
#[derive(Debug, Clone)]
pub struct Term {
    /// Which candidate.
    pub candidate: usize,
    /// Evidence in nats: how much worse the log would be explained without it,
    /// less what its parameters cost.
    pub evidence: f64,
    /// Subjects that explain what it explains about as well, with the evidence
    /// each would have had in its stead.
    pub rivals: Vec<(Subject, f64)>,
}

/// Values of parameters, as (parameter, value).
type Assignment = Vec<(usize, f64)>;

/// A candidate as it was seen at one step.
#[derive(Debug, Clone)]
pub struct Considered {
    /// Which candidate.
    pub candidate: usize,
    /// Nats by which it would improve the fit.
    pub gain: f64,
    /// Its gain less the price of its parameters and of the search.
    pub score: f64,
    /// Nats gained on blocks that the fit did not see.
    pub held_out_gain: f64,
    /// Shape and strengths.
    values: Assignment,
}

/// The outcome.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Accepted terms, strongest first.
    pub terms: Vec<Term>,
    /// Values of all parameters of the extended model.
    pub values: Vec<f64>,
    /// What is known of the accepted terms' parameters.
    pub estimate: Estimate,
    /// Mean squared whitened innovation with the accepted terms; one if sensors
    /// and process noise explain what remains.
    pub reduced_misfit: f64,
    /// The same with no term at all.
    pub nominal_misfit: f64,
    /// The forces that nothing explains.
    pub noise: ProcessNoise,
    /// The same as a share of each coordinate's forces; [`SMALLEST_SHARE`] if
    /// nothing is left to explain.
    pub unexplained_share: f64,
    /// The share that the model as given leaves unexplained.
    pub nominal_unexplained_share: f64,
    /// The first round's candidates, best first.
    pub considered: Vec<Considered>,
}

/// Nats within which two explanations count as equal.
const TIE: f64 = 6.0;
/// A term must bring this many nats beyond its price.
const MARGIN: f64 = 3.0;
/// Candidates with at least this share of the best one's gain are fitted before
/// one is chosen, the best few of them.
const LEADER_SHARE: f64 = 0.5;
const MAX_LEADERS: usize = 5;
/// Terms at most.
const MAX_TERMS: usize = 24;

/// A candidate's columns in the regression, for one shape.
struct ShapedCandidate {
    candidate: usize,
    shape: usize,
    columns: Vec<usize>,
}

/// A candidate after its fit.
struct Attempt {
    candidate: usize,
    cost: f64,
    values: Vec<f64>,
    observed: Observed,
}

struct Search<'a> {
    dictionary: &'a Dictionary,
    observed: &'a mut Observed,
    values: Vec<f64>,
    terms: Vec<Term>,
    /// Which share of the forces is noise, as last found.
    noise_index: usize,
}

/// Selects terms for `observed`, whose curve is improved on the way.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn select(dictionary: &Dictionary, observed: &mut Observed) -> Result<Selection, SolveError> {
    let values = dictionary.defaults.clone();
    let mut search = Search {
        dictionary,
        observed,
        values,
        terms: Vec::new(),
        noise_index: 0,
    };
    search.smooth_with_everything()?;
    let nominal_unexplained_share = search.share_without_columns()?;
    let mut first_round = Vec::new();
    let mut nominal_misfit = None;
    loop {
        let (gram, options, noise) = search.regress()?;
        let considered = search.score(&gram, &options);
        if nominal_misfit.is_none() {
            nominal_misfit = Some(gram.data_misfit() / gram.rows() as f64);
            first_round.clone_from(&considered);
        }
        if search.terms.len() < MAX_TERMS && search.accept(&considered, &noise)? {
            continue;
        }
        search.drop_idle_terms(&gram);
        let estimate = search.refine(&noise)?;
        let rows = (estimate.rows - estimate.parameters.len()).max(1) as f64;
        let mut terms = search.terms;
        terms.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        return Ok(Selection {
            terms,
            values: search.values,
            reduced_misfit: estimate.misfit / rows,
            estimate,
            nominal_misfit: nominal_misfit.unwrap_or(f64::NAN),
            noise,
            unexplained_share: NOISE_SHARES[search.noise_index],
            nominal_unexplained_share,
            considered: first_round,
        });
    }
}

impl Search<'_> {
    /// Columns: every parameter at the current values, then the further shapes.
    fn dynamics(&self) -> Result<(ErrorDynamics, Vec<ShapedCandidate>), SolveError> {
        let dictionary = self.dictionary;
        let shaped: Vec<Vec<f64>> = (1..=dictionary.by_shape.len())
            .map(|shape| self.with_shape(shape))
            .collect();
        let mut columns = vec![Columns {
            tape: &dictionary.by_parameter,
            parameters: &self.values,
        }];
        for ((_, tape), parameters) in dictionary.by_shape.iter().zip(&shaped) {
            columns.push(Columns { tape, parameters });
        }
        let dynamics = ErrorDynamics::new(
            &dictionary.machine,
            &dictionary.slopes,
            &columns,
            &self.observed.curve,
            self.observed.hold,
            &self.values,
        )?;
        Ok((dynamics, self.options()))
    }

    /// The current values, with every candidate that is not accepted in one shape.
    fn with_shape(&self, shape: usize) -> Vec<f64> {
        let mut values = self.values.clone();
        for (index, candidate) in self.dictionary.candidates.iter().enumerate() {
            if let (Some(shape), false) = (candidate.shapes.get(shape), self.is_accepted(index)) {
                for &(parameter, value) in shape {
                    values[parameter] = value;
                }
            }
        }
        values
    }

    fn is_accepted(&self, candidate: usize) -> bool {
        self.terms.iter().any(|term| term.candidate == candidate)
    }

    fn options(&self) -> Vec<ShapedCandidate> {
        let mut options = Vec::new();
        let mut first_column = self.values.len();
        for (index, candidate) in self.dictionary.candidates.iter().enumerate() {
            options.push(ShapedCandidate {
                candidate: index,
                shape: 0,
                columns: candidate.strengths.clone(),
            });
        }
        for (shape, (strengths, _)) in self.dictionary.by_shape.iter().enumerate() {
            for (index, candidate) in self.dictionary.candidates.iter().enumerate() {
                if candidate.shapes.len() <= shape + 1 {
                    continue;
                }
                let column_of = |s: &usize| strengths.iter().position(|x| x == s);
                let columns = candidate.strengths.iter().filter_map(column_of);
                let columns = columns.map(|c| first_column + c).collect();
                options.push(ShapedCandidate {
                    candidate: index,
                    shape: shape + 1,
                    columns,
                });
            }
            first_column += strengths.len();
        }
        options.retain(|option| !option.columns.is_empty() && !self.is_accepted(option.candidate));
        options
    }

    /// Parameters of the accepted terms.
    fn accepted_parameters(&self) -> Vec<usize> {
        let terms = self.terms.iter();
        terms
            .flat_map(|t| self.dictionary.candidates[t.candidate].parameters.clone())
            .collect()
    }

    /// Every column that may matter.
    fn all_columns(&self, options: &[ShapedCandidate]) -> Vec<usize> {
        let mut all = self.accepted_parameters();
        all.extend(options.iter().flat_map(|o| o.columns.iter().copied()));
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The curve where sensors and model agree if every candidate may help: no
    /// acceleration is believed that the model contradicts, no effect is denied.
    fn smooth_with_everything(&mut self) -> Result<(), SolveError> {
        let (departure, index) = {
            let (dynamics, options) = self.dynamics()?;
            let readings = self.observed.readings();
            let columns = self.all_columns(&options);
            let Chosen {
                parts: (whitener, gram),
                index,
                ..
            } = choose_noise(&dynamics, &readings, &columns, self.noise_index);
            let fit = gram.fit(&columns);
            let mut coefficients = DVector::zeros(dynamics.columns);
            for (&column, &value) in columns.iter().zip(fit.coefficients.iter()) {
                coefficients[column] = value;
            }
            (whitener.smooth(&coefficients), index)
        };
        self.noise_index = index;
        self.observed.move_by(&departure);
        Ok(())
    }

    /// What the terms accepted so far leave unexplained, as a share of the forces.
    fn share_without_columns(&self) -> Result<f64, SolveError> {
        let (dynamics, _) = self.dynamics()?;
        let readings = self.observed.readings();
        let columns = self.accepted_parameters();
        Ok(NOISE_SHARES[choose_noise(&dynamics, &readings, &columns, self.noise_index).index])
    }

    fn regress(&mut self) -> Result<(Gram, Vec<ShapedCandidate>, ProcessNoise), SolveError> {
        let (dynamics, options) = self.dynamics()?;
        let readings = self.observed.readings();
        let columns = self.all_columns(&options);
        let chosen = choose_noise(&dynamics, &readings, &columns, self.noise_index);
        self.noise_index = chosen.index;
        Ok((chosen.parts.1, options, chosen.noise))
    }

    /// Every candidate's worth beside the accepted terms, best first.
    fn score(&self, gram: &Gram, options: &[ShapedCandidate]) -> Vec<Considered> {
        let base = self.accepted_parameters();
        let base_misfit = gram.fit(&base).misfit;
        let all = self.all_columns(options);
        let floor = gram.fit(&all).misfit / (gram.rows() - all.len()).max(1) as f64;
        let scale = floor.max(1.0);
        let base_held_out: f64 = gram.held_out(&base).iter().sum();
        let search_price = (self.dictionary.candidates.len() as f64).ln();
        let mut best: Vec<Option<Considered>> = vec![None; self.dictionary.candidates.len()];
        for option in options {
            let candidate = &self.dictionary.candidates[option.candidate];
            let Some((columns, values)) = self.possible(gram, &base, option) else {
                continue;
            };
            let mut with = base.clone();
            with.extend(&columns);
            let gain = 0.5 * (base_misfit - gram.fit(&with).misfit) / scale;
            let free = columns.len() + candidate.shapes[0].len();
            let score = gain - 0.5 * free as f64 * (gram.rows() as f64).ln() - search_price;
            let slot = &mut best[option.candidate];
            if slot.as_ref().is_none_or(|c| score > c.score) {
                let held_out: f64 = gram.held_out(&with).iter().sum();
                let held_out_gain = 0.5 * (base_held_out - held_out) / scale;
                *slot = Some(Considered {
                    candidate: option.candidate,
                    gain,
                    score,
                    held_out_gain,
                    values,
                });
            }
        }
        let mut considered: Vec<Considered> = best.into_iter().flatten().collect();
        considered.sort_by(|a, b| b.score.total_cmp(&a.score));
        considered
    }

    /// The option's columns whose fitted strengths are physically possible, with
    /// shape and strengths; `None` if nothing is left.
    fn possible(
        &self,
        gram: &Gram,
        base: &[usize],
        option: &ShapedCandidate,
    ) -> Option<(Vec<usize>, Assignment)> {
        let candidate = &self.dictionary.candidates[option.candidate];
        let model = &self.dictionary.machine.compiled.model;
        let mut kept: Vec<usize> = (0..option.columns.len()).collect();
        kept.retain(|&i| gram.size(option.columns[i]) > INVISIBLE);
        while !kept.is_empty() {
            let mut with = base.to_vec();
            with.extend(kept.iter().map(|&i| option.columns[i]));
            let fit = gram.fit(&with);
            let new = |position: usize, i: usize| {
                let parameter = candidate.strengths[i];
                (
                    parameter,
                    self.values[parameter] + fit.coefficients[base.len() + position],
                )
            };
            let impossible = kept.iter().enumerate().position(|(position, &i)| {
                let (parameter, value) = new(position, i);
                let parameter = &model.parameters[parameter];
                !(parameter.lower..=parameter.upper).contains(&value)
            });
            match impossible {
                Some(position) => {
                    kept.remove(position);
                }
                None => {
                    let mut values = candidate.shapes[option.shape].clone();
                    values.extend(
                        kept.iter()
                            .enumerate()
                            .map(|(position, &i)| new(position, i)),
                    );
                    return Some((kept.iter().map(|&i| option.columns[i]).collect(), values));
                }
            }
        }
        None
    }

    /// Accepts the best of the leading candidates, each judged after its shape has
    /// been fitted: a coarse grid of shapes must not decide between relatives.
    fn accept(
        &mut self,
        considered: &[Considered],
        noise: &ProcessNoise,
    ) -> Result<bool, SolveError> {
        let earns = |c: &&Considered| c.score > MARGIN && c.held_out_gain > MARGIN;
        let Some(best) = considered.iter().find(earns) else {
            return Ok(false);
        };
        let mut tried = Vec::new();
        for leader in considered
            .iter()
            .filter(earns)
            .filter(|c| c.gain > LEADER_SHARE * best.gain)
        {
            if tried.len() < MAX_LEADERS {
                // A candidate under which the machine cannot move is no explanation.
                tried.extend(self.attempt(&[leader], noise).ok());
            }
        }
        // The price of parameters decides among those that fit equally well.
        let Some(lowest) = tried.iter().map(|a| a.cost).min_by(f64::total_cmp) else {
            return Ok(false);
        };
        let chosen = tried
            .iter()
            .filter(|a| a.cost < lowest + TIE)
            .min_by_key(|a| self.size(a.candidate))
            .map(|a| (a.candidate, a.cost));
        let Some((chosen, cost)) = chosen else {
            return Ok(false);
        };
        let mut rivals: Vec<(Subject, f64)> = tried
            .iter()
            .filter(|a| a.candidate != chosen && (a.cost - cost).abs() < TIE)
            .map(|a| {
                (
                    self.dictionary.candidates[a.candidate].subject.clone(),
                    cost - a.cost,
                )
            })
            .collect();
        rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
        let whole = tried.into_iter().find(|a| a.candidate == chosen);
        let Some(attempt) = whole else {
            return Ok(false);
        };
        let (attempt, chosen) = match self.in_two_parts(chosen, &attempt, considered, noise) {
            Some((parts, pair)) => {
                rivals.insert(
                    0,
                    (
                        self.dictionary.candidates[chosen].subject.clone(),
                        parts.cost - cost,
                    ),
                );
                (parts, pair.to_vec())
            }
            None => (attempt, vec![chosen]),
        };
        self.values = attempt.values;
        *self.observed = attempt.observed;
        for candidate in chosen {
            let rivals = rivals.clone();
            self.terms.push(Term {
                candidate,
                evidence: best.score,
                rivals,
            });
        }
        Ok(true)
    }

    /// Two simple effects at the place of a rich one that explain the log as well with
    /// fewer parameters: Coulomb and viscous friction, not Stribeck's.
    fn in_two_parts(
        &self,
        rich: usize,
        whole: &Attempt,
        considered: &[Considered],
        noise: &ProcessNoise,
    ) -> Option<(Attempt, [usize; 2])> {
        let on = self.dictionary.candidates[rich].subject.on();
        let simple: Vec<&Considered> = considered
            .iter()
            .filter(|c| c.candidate != rich && c.gain > 0.0)
            .filter(|c| self.dictionary.candidates[c.candidate].subject.on() == on)
            .collect();
        let mut best: Option<(Attempt, [usize; 2])> = None;
        for (index, first) in simple.iter().enumerate() {
            for second in &simple[index + 1..] {
                if self.size(first.candidate) + self.size(second.candidate) >= self.size(rich) {
                    continue;
                }
                let Ok(parts) = self.attempt(&[first, second], noise) else {
                    continue;
                };
                let limit = best
                    .as_ref()
                    .map_or(whole.cost + TIE, |(best, _)| best.cost);
                if parts.cost < limit {
                    best = Some((parts, [first.candidate, second.candidate]));
                }
            }
        }
        best
    }

    fn size(&self, candidate: usize) -> usize {
        self.dictionary.candidates[candidate].parameters.len()
    }

    /// The accepted terms and some more, fitted together.
    fn attempt(&self, more: &[&Considered], noise: &ProcessNoise) -> Result<Attempt, SolveError> {
        let mut values = self.values.clone();
        let mut parameters = self.accepted_parameters();
        let mut free = 0;
        for leader in more {
            for &(parameter, value) in &leader.values {
                values[parameter] = value;
            }
            parameters.extend(&self.dictionary.candidates[leader.candidate].parameters);
            free += self.size(leader.candidate);
        }
        let mut observed = self.observed.clone();
        let tape = self.tape_for(&parameters);
        let estimate = refine(
            self.dictionary,
            &tape,
            &parameters,
            &mut observed,
            &mut values,
            noise,
        )?;
        let rows = estimate.rows as f64;
        let scale = (estimate.misfit / rows).max(1.0);
        // Nats under noise as large as this fit leaves, and the price.
        let cost =
            0.5 * estimate.misfit / scale + 0.5 * rows * scale.ln() + 0.5 * free as f64 * rows.ln();
        Ok(Attempt {
            candidate: more[0].candidate,
            cost,
            values,
            observed,
        })
    }

    fn refine(&mut self, noise: &ProcessNoise) -> Result<Estimate, SolveError> {
        let parameters = self.accepted_parameters();
        let tape = self.tape_for(&parameters);
        refine(
            self.dictionary,
            &tape,
            &parameters,
            self.observed,
            &mut self.values,
            noise,
        )
    }

    fn tape_for(&self, parameters: &[usize]) -> SensitivityTape {
        let variables: Vec<Variable> = parameters
            .iter()
            .copied()
            .map(Variable::Parameter)
            .collect();
        self.dictionary.machine.clone().sensitivity(&variables)
    }

    /// Evidence of each accepted term given the others; those that no longer earn
    /// their place go.
    fn drop_idle_terms(&mut self, gram: &Gram) {
        let all = self.accepted_parameters();
        let fit = gram.fit(&all);
        let scale = (fit.misfit / (gram.rows() - all.len()).max(1) as f64).max(1.0);
        let mut dropped = Vec::new();
        for index in 0..self.terms.len() {
            let candidate = &self.dictionary.candidates[self.terms[index].candidate];
            let own = &candidate.parameters;
            let shift: Vec<(usize, f64)> = candidate
                .strengths
                .iter()
                .map(|&p| (p, self.values[p] - self.dictionary.defaults[p]))
                .collect();
            let rest: Vec<usize> = all.iter().copied().filter(|p| !own.contains(p)).collect();
            let without = gram.with_data_shifted(&shift).fit(&rest).misfit;
            let gain = 0.5 * (without - fit.misfit) / scale;
            let price = 0.5 * own.len() as f64 * (gram.rows() as f64).ln();
            self.terms[index].evidence = gain - price;
            if gain < price {
                dropped.push((index, candidate.clone()));
            }
        }
        for (index, candidate) in dropped.into_iter().rev() {
            self.reset(&candidate);
            self.terms.remove(index);
        }
    }

    fn reset(&mut self, candidate: &Candidate) {
        for &parameter in &candidate.parameters {
            self.values[parameter] = self.dictionary.defaults[parameter];
        }
    }
}

struct Chosen<'a> {
    parts: (Whitener<'a>, Gram),
    noise: ProcessNoise,
    /// Which of the shares.
    index: usize,
    /// Negative log likelihood, up to a constant.
    cost: f64,
}

/// Shares of each coordinate's forces that nothing explains, to choose from. The
/// smallest is what no rigid-body model of a machine is claimed to reach: a force
/// error below a thousandth is not worth a name.
const NOISE_SHARES: [f64; 6] = [1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 0.3];

/// What counts as nothing.
pub const SMALLEST_SHARE: f64 = NOISE_SHARES[0];

/// What inputs most likely do between samples: the assumption under which the log
/// is more likely once every candidate may help. The curve is left as it is.
///
/// # Errors
/// If the equation of motion cannot be solved along the curve.
pub fn likelier_hold(dictionary: &Dictionary, observed: &Observed) -> Result<Hold, SolveError> {
    if observed.record.u.is_empty() {
        return Ok(Hold::Linear);
    }
    let cost = |hold: Hold| -> Result<f64, SolveError> {
        let mut observed = Observed {
            hold,
            ..observed.clone()
        };
        let values = dictionary.defaults.clone();
        let search = Search {
            dictionary,
            observed: &mut observed,
            values,
            terms: Vec::new(),
            noise_index: 0,
        };
        let (dynamics, options) = search.dynamics()?;
        let readings = search.observed.readings();
        Ok(choose_noise(&dynamics, &readings, &search.all_columns(&options), 0).cost)
    };
    let (linear, previous) = (cost(Hold::Linear)?, cost(Hold::Previous)?);
    Ok(if previous < linear - TIE {
        Hold::Previous
    } else {
        Hold::Linear
    })
}

/// The process noise under which the log is most likely once all columns have
/// had their say.
fn choose_noise<'a>(
    dynamics: &'a ErrorDynamics,
    readings: &'a Readings,
    columns: &[usize],
    start: usize,
) -> Chosen<'a> {
    let attempt = |index: usize| {
        let noise = ProcessNoise {
            force_sd: &dynamics.force_scale * NOISE_SHARES[index],
        };
        let whitener = Whitener::new(dynamics, readings, &noise);
        let gram = whitener.gram();
        let cost = whitener.log_sd() + 0.5 * gram.fit(columns).misfit;
        Chosen {
            parts: (whitener, gram),
            noise,
            index,
            cost,
        }
    };
    // Downhill from where the last round ended.
    let mut best = attempt(start);
    for downwards in [true, false] {
        loop {
            let next = if downwards {
                best.index.checked_sub(1)
            } else {
                Some(best.index + 1)
            };
            let Some(next) = next.filter(|&next| next < NOISE_SHARES.len()) else {
                break;
            };
            let other = attempt(next);
            if other.cost >= best.cost {
                break;
            }
            best = other;
        }
    }
    best
}
