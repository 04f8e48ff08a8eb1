//! L-BFGS-B through `basin`, which is used nowhere else.

use super::{Algorithm, Bounded, Reason, Watch};
use crate::error::{GpError, Result};
use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, ConstraintSolveError, Constraints,
    CostFunction, Executor, FirstOrderState, Gradient, Lbfgsb, State, TerminationCode,
};

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

/// How often a run is taken up again after an evaluation failed.
const RETREATS: usize = 12;

/// L-BFGS-B that survives failing evaluations: from the best point on, steps
/// are kept within a quarter of the distance to the point that failed.
pub(super) fn retreating(
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
