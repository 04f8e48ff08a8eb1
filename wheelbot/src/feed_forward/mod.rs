//! Feed-forward found by optimisation over the simulation: `plan-stand-up`, `plan-roll-up` and `plan-pirouette` of
//! the program.
//!
//! ```text
//! plans, pirouette ◀── numbers ── search (CMA-ES) ──▶ costs of runs: up, swing
//! ```

pub mod search;
pub mod swing;
pub mod up;

/// What several runs cost: their mean and the worst of them, so that none is given up for the others.
fn together(costs: &[f64]) -> f64 {
    let mean = costs.iter().sum::<f64>() / costs.len().max(1) as f64;
    mean + costs.iter().copied().fold(0.0, f64::max)
}
