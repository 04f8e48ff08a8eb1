//! Bounded minimisation: L-BFGS-B and Adam.

mod adam;
mod lbfgs;

use crate::error::{GpError, Result};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// How to minimise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Algorithm {
    /// L-BFGS-B (Zhu, Byrd, Lu and Nocedal 1997) with Moré–Thuente line search.
    Lbfgs {
        /// Most iterations.
        max_iterations: u64,
        /// Stop when the projected gradient's largest entry falls below, nats.
        gradient_tolerance: f64,
        /// Stop when the objective falls by less than this fraction of `max(|f|, 1)`.
        reduction_tolerance: f64,
    },
    /// Adam (Kingma and Ba 2014), projected onto the bounds; keeps the best point seen.
    Adam {
        /// Step size `α`.
        rate: f64,
        /// Number of iterations.
        iterations: u64,
        /// Forget the moments every so many iterations; 0 never does.
        reset_every: u64,
    },
}

impl Default for Algorithm {
    fn default() -> Self {
        Self::Lbfgs {
            max_iterations: 200,
            gradient_tolerance: 1e-4,
            reduction_tolerance: 1e-8,
        }
    }
}

impl Algorithm {
    /// Fails with the setting that no minimisation can use.
    pub(crate) fn check(self) -> Result<()> {
        let settings = match self {
            Self::Lbfgs {
                gradient_tolerance,
                reduction_tolerance,
                ..
            } => [
                ("gradient_tolerance", gradient_tolerance, 0.0),
                ("reduction_tolerance", reduction_tolerance, 0.0),
            ],
            Self::Adam { rate, .. } => [("rate", rate, f64::MIN_POSITIVE); 2],
        };
        match settings
            .iter()
            .find(|(_, v, least)| !(v.is_finite() && v >= least))
        {
            None => Ok(()),
            Some((name, value, least)) => Err(GpError::Parameter {
                name: (*name).into(),
                value: *value,
                expected: format!(
                    "a finite number {}",
                    if *least > 0.0 {
                        "above 0"
                    } else {
                        "not below 0"
                    }
                ),
            }),
        }
    }
}

/// Why a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Reason {
    /// The projected gradient is below its tolerance.
    GradientTolerance,
    /// The objective no longer falls.
    ReductionTolerance,
    /// All iterations are used up.
    Iterations,
    /// The progress callback asked to stop.
    Stopped,
    /// The line search found no lower point; the best one seen is kept.
    LineSearch(String),
    /// An evaluation failed; the best point seen is kept.
    Evaluation(String),
}

/// Where a run stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Number of the run, counted from 0.
    pub run: usize,
    /// Finished iterations.
    pub iteration: u64,
    /// Lowest objective seen, nats.
    pub objective: f64,
}

/// Result of one run.
pub(crate) struct Minimum {
    pub(crate) z: Vec<f64>,
    pub(crate) objective: f64,
    pub(crate) iterations: u64,
    pub(crate) evaluations: u64,
    pub(crate) reason: Reason,
}

/// Objective value and gradient.
pub(crate) type Objective<'a> = dyn Fn(&[f64]) -> Result<(f64, Vec<f64>)> + 'a;

/// Receives the iteration and the best value; `false` stops.
pub(crate) type Watch<'a> = dyn Fn(u64, f64) -> bool + 'a;

struct Best {
    z: Vec<f64>,
    objective: f64,
    evaluations: u64,
    /// The last point whose evaluation failed.
    failed: Option<Vec<f64>>,
    /// Bounds of the run under way.
    edge: Vec<(f64, f64)>,
}

struct Bounded<'a> {
    f: &'a Objective<'a>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    best: &'a RefCell<Best>,
}

impl Bounded<'_> {
    fn evaluate(&self, z: &[f64]) -> Result<(f64, Vec<f64>)> {
        let (value, gradient) = match (self.f)(z) {
            Ok(done) => done,
            Err(e) => {
                self.best.borrow_mut().failed = Some(z.to_vec());
                return Err(e);
            }
        };
        let mut best = self.best.borrow_mut();
        best.evaluations += 1;
        if value < best.objective {
            best.objective = value;
            best.z = z.to_vec();
        }
        Ok((value, gradient))
    }
}

impl Bounded<'_> {
    /// The last retreat ended on its own box, not on the bounds of the problem.
    fn cut_short(&self, radius: f64) -> bool {
        let best = self.best.borrow();
        let near = 1e-6 * radius;
        let on_edge = || {
            let mut sides = best
                .edge
                .iter()
                .zip(&best.z)
                .zip(self.lower.iter().zip(&self.upper));
            sides.any(|((e, z), (l, u))| {
                (*z <= e.0 + near && e.0 > *l) || (*z >= e.1 - near && e.1 < *u)
            })
        };
        // In a tiny box every projected gradient is tiny and proves nothing.
        radius.is_finite() && (radius < 1e-3 || on_edge())
    }
}

/// Minimise `f` from `start` within the bounds. Errors only when the start
/// itself cannot be evaluated.
pub(crate) fn minimise(
    algorithm: Algorithm,
    f: &Objective<'_>,
    start: &[f64],
    lower: &[f64],
    upper: &[f64],
    watch: &Watch<'_>,
) -> Result<Minimum> {
    let start: Vec<f64> = start
        .iter()
        .zip(lower.iter().zip(upper))
        .map(|(z, (l, u))| z.clamp(*l, *u))
        .collect();
    let best = RefCell::new(Best {
        z: start.clone(),
        objective: f64::INFINITY,
        evaluations: 0,
        failed: None,
        edge: Vec::new(),
    });
    let problem = Bounded {
        f,
        lower: lower.to_vec(),
        upper: upper.to_vec(),
        best: &best,
    };
    let (iterations, reason) = match algorithm {
        Algorithm::Lbfgs { .. } => lbfgs::retreating(&problem, start, algorithm, watch)?,
        Algorithm::Adam {
            rate,
            iterations,
            reset_every,
        } => adam::adam(&problem, start, rate, iterations, reset_every, watch)?,
    };
    let best = best.into_inner();
    Ok(Minimum {
        z: best.z,
        objective: best.objective,
        iterations,
        evaluations: best.evaluations,
        reason,
    })
}
