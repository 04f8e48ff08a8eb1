//! Training by evidence: bounds, restarts, priors, joint estimation of `θ`.

use crate::error::{GpError, Result, shape};
use crate::evidence::Workspace;
use crate::fitted::{Fitted, Run};
use crate::optimise::{Algorithm, Minimum, Progress, Reason, minimise};
use crate::penalty::Penalty;
use crate::posterior::Posterior;
use crate::problem::Problem;
use crate::sparse::SparsePosterior;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;

/// How one parameter is treated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Rule {
    lower: f64,
    upper: f64,
    start: Option<(f64, f64)>,
    fixed: bool,
    /// A positive parameter, held as its logarithm.
    logarithm: bool,
    penalty: Option<Penalty>,
}

/// Settings of a training, by parameter name.
///
/// Names are those of [`Problem::names`]; `*` in a pattern stands for any
/// text, so `term[*].log_length[*]` means every length-scale. All values are in
/// the optimiser's scale: natural logarithms of positive parameters.
///
/// ```
/// use gp::{Functionals, Inputs, Kernel, LatentPrior, Model, Problem, Training};
/// let x = Inputs::from_rows(&(0..20).map(|i| [0.3 * i as f64]).collect::<Vec<_>>())?;
/// let y: Vec<f64> = x.dim(0).iter().map(|x| x.sin()).collect();
/// let f = Functionals::identity(&x, 1);
/// let prior = LatentPrior::independent(vec![Kernel::squared_exponential(&[1.0], 1.0)]);
/// let problem = Problem::new(Model::new(prior, &[1e-4])?, &f, &y);
/// let fitted = Training::new(&problem)
///     .bounds("*log_length*", 0.1f64.ln(), 10f64.ln())?
///     .fix("log_noise*")?
///     .restarts(3)
///     .run(&problem)?;
/// assert!(fitted.nll < 0.0);
/// # Ok::<(), gp::GpError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Training {
    names: Vec<String>,
    rules: Vec<Rule>,
    algorithm: Algorithm,
    restarts: usize,
    seed: u64,
    from_given: bool,
}

impl Rule {
    /// Where restarts begin: what was said, or around the given value when nothing was said
    /// of any parameter.
    fn interval(&self, value: f64, nothing_said: bool) -> Option<(f64, f64)> {
        if self.fixed {
            return None;
        }
        let around = (nothing_said && self.logarithm).then_some((value - AROUND, value + AROUND));
        self.start.or(around)
    }
}

/// Half width of the interval restarts begin in when none was given, in logarithms.
const AROUND: f64 = 2.0;

fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else {
        return false;
    };
    let parts: Vec<&str> = parts.collect();
    for (i, part) in parts.iter().enumerate() {
        if i + 1 == parts.len() {
            return rest.ends_with(part);
        }
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.is_empty()
}

impl Training {
    /// Defaults: logarithms of kernel parameters and noise within ±20, `θ`
    /// free, L-BFGS-B, one run from the given values.
    pub fn new(problem: &Problem<'_>) -> Self {
        let names = problem.names();
        let rules = names
            .iter()
            .map(|n| {
                let logarithm = !(n.starts_with("theta") || n.contains("weight"));
                let wide = if logarithm { 20.0 } else { f64::INFINITY };
                Rule {
                    lower: -wide,
                    upper: wide,
                    start: None,
                    fixed: false,
                    logarithm,
                    penalty: None,
                }
            })
            .collect();
        Self {
            names,
            rules,
            algorithm: Algorithm::default(),
            restarts: 1,
            seed: 0,
            from_given: true,
        }
    }

    fn each(mut self, pattern: &str, change: impl Fn(&mut Rule)) -> Result<Self> {
        let mut hit = false;
        for (name, rule) in self.names.iter().zip(&mut self.rules) {
            if matches(pattern, name) {
                change(rule);
                hit = true;
            }
        }
        if hit {
            Ok(self)
        } else {
            Err(GpError::UnknownParameter {
                name: pattern.into(),
                known: self.names.join(", "),
            })
        }
    }

    /// Keep parameters within bounds.
    pub fn bounds(self, pattern: &str, lower: f64, upper: f64) -> Result<Self> {
        if lower.is_nan() || upper.is_nan() || lower > upper {
            return Err(GpError::Parameter {
                name: pattern.into(),
                value: lower,
                expected: format!("a lower bound not above {upper}"),
            });
        }
        self.each(pattern, |r| (r.lower, r.upper) = (lower, upper))
    }

    /// Restarts begin uniformly in this interval instead of at the given value.
    pub fn start_in(self, pattern: &str, lower: f64, upper: f64) -> Result<Self> {
        if !(lower.is_finite() && upper.is_finite() && lower <= upper) {
            return Err(GpError::Parameter {
                name: pattern.into(),
                value: lower,
                expected: "a finite interval".into(),
            });
        }
        self.each(pattern, |r| r.start = Some((lower, upper)))
    }

    /// Hold parameters at their given values.
    pub fn fix(self, pattern: &str) -> Result<Self> {
        self.each(pattern, |r| r.fixed = true)
    }

    /// Put a prior on parameters: training becomes maximum a posteriori.
    pub fn penalty(self, pattern: &str, penalty: Penalty) -> Result<Self> {
        if !penalty.is_valid() {
            return Err(GpError::Parameter {
                name: pattern.into(),
                value: f64::NAN,
                expected: format!("positive scales, not {penalty:?}"),
            });
        }
        self.each(pattern, |r| r.penalty = Some(penalty))
    }

    /// Choose the algorithm.
    pub fn algorithm(mut self, algorithm: Algorithm) -> Self {
        self.algorithm = algorithm;
        self
    }

    /// Number of runs, at least 1. All but the first start from a scrambled
    /// Sobol sequence over the intervals of [`Training::start_in`]; without any of
    /// these, over a factor of `e²` to both sides of every given positive parameter.
    pub fn restarts(mut self, runs: usize) -> Self {
        self.restarts = runs.max(1);
        self
    }

    /// Start the first run from the sequence as well.
    pub fn forget_given(mut self) -> Self {
        self.from_given = false;
        self
    }

    /// Seed of the starting points.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Train. Runs go in parallel; the result depends on the seed alone.
    pub fn run(&self, problem: &Problem<'_>) -> Result<Fitted> {
        self.run_watched(problem, &|_| true)
    }

    /// Train, telling `watch` after every iteration; `false` ends that run.
    pub fn run_watched(
        &self,
        problem: &Problem<'_>,
        watch: &(dyn Fn(Progress) -> bool + Sync),
    ) -> Result<Fitted> {
        self.algorithm.check()?;
        let given = problem.point()?;
        if given.len() != self.names.len() {
            return Err(shape(
                "parameters of the problem",
                format!("{} (those the training was made for)", self.names.len()),
                given.len(),
            ));
        }
        crate::error::finite("starting values", &given)?;
        let starts: Vec<Vec<f64>> = (0..self.restarts)
            .map(|run| self.start(run, &given))
            .collect();
        let minima: Vec<Result<Minimum>> = starts
            .par_iter()
            .enumerate()
            .map(|(run, start)| self.one(problem, start, run, watch))
            .collect();
        self.choose(problem, starts, minima)
    }

    fn start(&self, run: usize, given: &[f64]) -> Vec<f64> {
        let inside = |(rule, value): (&Rule, f64)| match rule.fixed {
            true => value,
            false => value.clamp(rule.lower, rule.upper),
        };
        if run == 0 && self.from_given {
            let given = given.iter().copied();
            return self.rules.iter().zip(given).map(inside).collect();
        }
        let nothing_said = self.rules.iter().all(|r| r.start.is_none());
        let index = u32::try_from(run).unwrap_or(u32::MAX) & 0xffff;
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(self.seed.wrapping_add(run as u64));
        let mut dimension = 0;
        self.rules
            .iter()
            .zip(given)
            .map(|(rule, &value)| match rule.interval(value, nothing_said) {
                Some((lower, upper)) => {
                    let unit = if dimension < sobol_burley::NUM_DIMENSIONS {
                        f64::from(sobol_burley::sample(index, dimension, self.seed as u32))
                    } else {
                        random.random_range(0.0..1.0)
                    };
                    dimension += 1;
                    inside((rule, lower + (upper - lower) * unit))
                }
                None => inside((rule, value)),
            })
            .collect()
    }

    fn one(
        &self,
        problem: &Problem<'_>,
        start: &[f64],
        run: usize,
        watch: &(dyn Fn(Progress) -> bool + Sync),
    ) -> Result<Minimum> {
        let free: Vec<usize> = (0..start.len()).filter(|&i| !self.rules[i].fixed).collect();
        let pick = |v: &dyn Fn(usize) -> f64| -> Vec<f64> { free.iter().map(|&i| v(i)).collect() };
        let constant = problem.constant()?;
        let work = Mutex::new(Workspace::default());
        let full = |z: &[f64]| {
            let mut out = start.to_vec();
            free.iter().zip(z).for_each(|(&i, &v)| out[i] = v);
            out
        };
        let objective = |z: &[f64]| -> Result<(f64, Vec<f64>)> {
            let z = full(z);
            let mut work = work
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            let (mut value, mut gradient) =
                problem.objective_at(&z, constant.as_ref(), &mut work)?;
            for (i, rule) in self.rules.iter().enumerate() {
                if let Some(p) = &rule.penalty {
                    let (v, g) = p.value(z[i]);
                    value += v;
                    gradient[i] += g;
                }
            }
            Ok((value, free.iter().map(|&i| gradient[i]).collect()))
        };
        let mut minimum = minimise(
            self.algorithm,
            &objective,
            &pick(&|i| start[i]),
            &pick(&|i| self.rules[i].lower),
            &pick(&|i| self.rules[i].upper),
            &|iteration, objective| {
                watch(Progress {
                    run,
                    iteration,
                    objective,
                })
            },
        )?;
        minimum.z = full(&minimum.z);
        Ok(minimum)
    }

    fn choose(
        &self,
        problem: &Problem<'_>,
        starts: Vec<Vec<f64>>,
        minima: Vec<Result<Minimum>>,
    ) -> Result<Fitted> {
        let mut first_error = None;
        let mut best: Option<(usize, f64, Vec<f64>)> = None;
        let mut runs = Vec::with_capacity(minima.len());
        for (n, (start, minimum)) in starts.into_iter().zip(minima).enumerate() {
            match minimum {
                Ok(m) => {
                    if best.as_ref().is_none_or(|(_, o, _)| m.objective < *o) {
                        best = Some((n, m.objective, m.z));
                    }
                    runs.push(Run {
                        start,
                        objective: Some(m.objective),
                        iterations: m.iterations,
                        evaluations: m.evaluations,
                        reason: m.reason,
                    });
                }
                Err(e) => {
                    runs.push(Run {
                        start,
                        objective: None,
                        iterations: 0,
                        evaluations: 0,
                        reason: Reason::Evaluation(e.to_string()),
                    });
                    first_error.get_or_insert(e);
                }
            }
        }
        let Some((best_run, objective, z)) = best.filter(|b| b.1.is_finite()) else {
            return Err(match first_error {
                Some(e) if runs.len() == 1 => e,
                Some(e) => GpError::Training {
                    starts: runs.len(),
                    first: e.to_string(),
                },
                None => GpError::Training {
                    starts: runs.len(),
                    first: "the evidence is not finite".into(),
                },
            });
        };
        let (model, theta) = problem.split(&z)?;
        let f = problem.structure.functionals(&theta)?;
        let (nll, jitter, coincident) = match &problem.inducing {
            None => {
                let p = Posterior::new(&model, &f, problem.y)?;
                (p.nll(), p.jitter(), p.coincident().to_vec())
            }
            Some(z) => {
                let p = SparsePosterior::new(&model, &f, problem.y, z)?;
                (-p.bound(), p.jitter(), Vec::new())
            }
        };
        let at_bounds = (0..z.len())
            .filter(|&i| {
                !self.rules[i].fixed && (z[i] <= self.rules[i].lower || z[i] >= self.rules[i].upper)
            })
            .map(|i| self.names[i].clone())
            .collect();
        Ok(Fitted {
            model,
            theta,
            nll,
            objective,
            jitter,
            coincident,
            at_bounds,
            best_run,
            runs,
            seed: self.seed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn patterns_match_names() {
        assert!(matches("theta[0]", "theta[0]"));
        assert!(!matches("theta[0]", "theta[01]"));
        assert!(matches(
            "term[*].log_length[*]",
            "term[3].sum[0].log_length[12]"
        ));
        assert!(matches("*log_variance", "term[0].log_variance"));
        assert!(!matches("*log_variance", "term[0].log_variance[2]"));
        assert!(matches("*", "anything"));
        assert!(!matches("noise*", "log_noise[0]"));
    }
}
