//! Bounded minimisation: L-BFGS-B (through `basin`, used nowhere else) and Adam.

use crate::error::{GpError, Result};
use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints,
    CostFunction, Executor, FirstOrderState, Gradient, Lbfgsb, State, TerminationCode,
};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// How to minimise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

/// Why a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

impl Constraints for &Bounded<'_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;
    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

impl CostFunction for &Bounded<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = GpError;
    fn cost(&self, z: &Vec<f64>) -> Result<f64> {
        Ok(self.evaluate(z)?.0)
    }
}

impl Gradient for &Bounded<'_> {
    type Gradient = Vec<f64>;
    fn gradient(&self, z: &Vec<f64>) -> Result<Vec<f64>> {
        Ok(self.evaluate(z)?.1)
    }
    fn cost_and_gradient(&self, z: &Vec<f64>) -> Result<(f64, Vec<f64>)> {
        self.evaluate(z)
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
        Algorithm::Lbfgs { .. } => retreating(&problem, start, algorithm, watch)?,
        Algorithm::Adam {
            rate,
            iterations,
            reset_every,
        } => adam(&problem, start, rate, iterations, reset_every, watch)?,
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

/// How often a run is taken up again after an evaluation failed.
const RETREATS: usize = 12;

/// L-BFGS-B that survives failing evaluations: from the best point on, steps
/// are kept within a quarter of the distance to the point that failed.
fn retreating(
    problem: &Bounded<'_>,
    start: Vec<f64>,
    algorithm: Algorithm,
    watch: &Watch<'_>,
) -> Result<(u64, Reason)> {
    let (mut iterations, mut reason) = lbfgs(problem, start, algorithm, watch)?;
    let mut radius = f64::INFINITY;
    let mut failure = reason.clone();
    for _ in 0..RETREATS {
        let failed = matches!(reason, Reason::Evaluation(_));
        if failed {
            failure = reason.clone();
        }
        let (z, point) = {
            let best = problem.best.borrow();
            (best.z.clone(), best.failed.clone())
        };
        if failed && let Some(point) = point {
            let far = z
                .iter()
                .zip(&point)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            radius = 0.25 * far.min(radius);
        }
        let lower: Vec<f64> = z
            .iter()
            .zip(&problem.lower)
            .map(|(z, l)| l.max(z - radius))
            .collect();
        let upper: Vec<f64> = z
            .iter()
            .zip(&problem.upper)
            .map(|(z, u)| u.min(z + radius))
            .collect();
        let near = Bounded {
            f: problem.f,
            lower,
            upper,
            best: problem.best,
        };
        if !failed && !problem.cut_short(radius) {
            break;
        }
        let (more, why) = lbfgs(&near, z, algorithm, watch)?;
        iterations += more;
        reason = why;
        if reason == Reason::Stopped {
            return Ok((iterations, reason));
        }
    }
    // Ending on a box of our own is no convergence: say what is behind it.
    Ok((
        iterations,
        if problem.cut_short(radius) {
            failure
        } else {
            reason
        },
    ))
}

fn plain(e: ConstraintSolveError<GpError>) -> GpError {
    match e {
        ConstraintSolveError::Evaluation(e) => e,
        ConstraintSolveError::InvalidConstraints(e) => GpError::Parameter {
            name: "bounds".into(),
            value: f64::NAN,
            expected: format!("lower <= upper ({e})"),
        },
        other => GpError::Parameter {
            name: "bounds".into(),
            value: f64::NAN,
            expected: other.to_string(),
        },
    }
}

fn lbfgs(
    problem: &Bounded<'_>,
    start: Vec<f64>,
    algorithm: Algorithm,
    watch: &Watch<'_>,
) -> Result<(u64, Reason)> {
    let Algorithm::Lbfgs {
        max_iterations,
        gradient_tolerance,
        reduction_tolerance,
    } = algorithm
    else {
        return Ok((0, Reason::Iterations));
    };
    problem.best.borrow_mut().edge = problem
        .lower
        .iter()
        .copied()
        .zip(problem.upper.iter().copied())
        .collect();
    let solver = Lbfgsb::new()
        .with_absolute_projected_gradient_tolerance(Some(gradient_tolerance))
        .with_relative_cost_reduction_tolerance(Some(reduction_tolerance));
    let mut stepper = Executor::new(problem, solver, FirstOrderState::new(start))
        .max_iter(max_iterations)
        .into_stepper()
        .map_err(plain)?;
    let mut iteration = 0;
    loop {
        match stepper.step() {
            Err(e) => return Ok((iteration, Reason::Evaluation(plain(e).to_string()))),
            Ok(outcome) => {
                iteration = stepper.state().iter();
                if let Some(report) = outcome.report() {
                    return Ok((
                        iteration,
                        reason(report.code(), &format!("{:?}", report.termination)),
                    ));
                }
                let best = problem.best.borrow().objective;
                if !watch(iteration, best) {
                    return Ok((iteration, Reason::Stopped));
                }
            }
        }
    }
}

fn reason(code: TerminationCode, detail: &str) -> Reason {
    match code {
        TerminationCode::ProjectedGradientTolerance | TerminationCode::GradientTolerance => {
            Reason::GradientTolerance
        }
        TerminationCode::RelativeCostTolerance
        | TerminationCode::CostTolerance
        | TerminationCode::SolverConverged => Reason::ReductionTolerance,
        TerminationCode::MaxIter => Reason::Iterations,
        _ if detail.contains("RelativeCostReduction") => Reason::ReductionTolerance,
        _ => Reason::LineSearch(detail.to_string()),
    }
}

fn adam(
    problem: &Bounded<'_>,
    start: Vec<f64>,
    rate: f64,
    iterations: u64,
    reset_every: u64,
    watch: &Watch<'_>,
) -> Result<(u64, Reason)> {
    let (beta1, beta2, epsilon) = (0.9f64, 0.999f64, 1e-8);
    let mut z = start;
    let (mut first, mut second) = (vec![0.0; z.len()], vec![0.0; z.len()]);
    let mut since = 0;
    for iteration in 0..iterations {
        let gradient = match problem.evaluate(&z) {
            Ok((_, gradient)) => gradient,
            Err(e) if iteration == 0 => return Err(e),
            Err(e) => return Ok((iteration, Reason::Evaluation(e.to_string()))),
        };
        if reset_every > 0 && iteration > 0 && iteration % reset_every == 0 {
            first.fill(0.0);
            second.fill(0.0);
            since = 0;
        }
        since += 1;
        for i in 0..z.len() {
            first[i] = beta1 * first[i] + (1.0 - beta1) * gradient[i];
            second[i] = beta2 * second[i] + (1.0 - beta2) * gradient[i] * gradient[i];
            let m = first[i] / (1.0 - beta1.powi(since));
            let v = second[i] / (1.0 - beta2.powi(since));
            z[i] =
                (z[i] - rate * m / (v.sqrt() + epsilon)).clamp(problem.lower[i], problem.upper[i]);
        }
        let best = problem.best.borrow().objective;
        if !watch(iteration + 1, best) {
            return Ok((iteration + 1, Reason::Stopped));
        }
    }
    if let Err(e) = problem.evaluate(&z) {
        return Ok((iterations, Reason::Evaluation(e.to_string())));
    }
    Ok((iterations, Reason::Iterations))
}
