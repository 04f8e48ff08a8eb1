//! Adam (Kingma and Ba 2014), projected onto the bounds.

use super::{Bounded, Reason, Watch};
use crate::error::Result;

pub(super) fn adam(
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
