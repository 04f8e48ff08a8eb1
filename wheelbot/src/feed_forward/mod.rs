//! Feed-forward found by optimisation over the simulation: `plan-stand-up` and `plan-roll-up` of the program.
//!
//! ```text
//! jump::plans ◀── numbers ── search (CMA-ES) ──▶ up: costs of runs on some robots and floors
//! ```

pub mod search;
pub mod up;

/// What several runs cost: their mean and the worst of them, so that none is given up for the others.
fn together(costs: &[f64]) -> f64 {
    let mean = costs.iter().sum::<f64>() / costs.len().max(1) as f64;
    mean + costs.iter().copied().fold(0.0, f64::max)
}
