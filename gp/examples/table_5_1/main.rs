//! Table 5.1 of the thesis from the published observations.
//!
//! `cargo run --release -p eqmotion-gp --example table_5_1 [runs] [row]` fits the seven models
//! to ten sets of 100 observations of three systems and prints RMSE (mean over
//! outputs, in normalised units, against noise-free truth on a grid; mean, min,
//! max over the sets) and the largest constraint error `|A a - b|` in raw
//! units at the true parameters, beside the published figures.
//!
//! Protocol as published (inputs z-scored by the training set, outputs by the
//! noisy training outputs, noise known, one shared SE-ARD kernel in normalised
//! acceleration units, ℓ ∈ [0.5, 20], signal sd ∈ [0.5, 10], uniform starts in
//! the bounds, 5 restarts, Duffing 10, baselines 30), with one difference for
//! every row alike: L-BFGS-B stops at a relative reduction of 1e-9 or after 200
//! iterations, where the published fits stopped at 1e-6 or after 10. Exact
//! gradients make that cheap.

mod benchmark;
mod fit;
#[path = "../../tests/benchmarks/systems.rs"]
mod systems;
#[cfg(test)]
mod tests;

use benchmark::Data;
use fit::{Score, fit};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: usize = std::env::args().nth(1).map_or(Ok(10), |a| a.parse())?;
    let file = benchmark::observations()?;
    println!(
        "RMSE mean [min, max], largest constraint error, seconds; published figures below each row"
    );
    let only = std::env::args().nth(2).unwrap_or_default();
    for (kind, name, published) in benchmark::ROWS.into_iter().filter(|r| r.1.contains(&only)) {
        let mut line = format!("{name:<26}");
        for system in &benchmark::SYSTEMS {
            let start = Instant::now();
            let scores = (0..count)
                .map(|run| {
                    fit(
                        kind,
                        system,
                        &Data::read(&file, system, run)?,
                        run as u64,
                        None,
                    )
                })
                .collect::<gp::Result<Vec<Score>>>()?;
            let rmse = || scores.iter().map(|s| s.rmse);
            let mean = rmse().sum::<f64>() / count as f64;
            let (low, high) = (
                rmse().fold(f64::INFINITY, f64::min),
                rmse().fold(0.0, f64::max),
            );
            let jitter = scores.iter().map(|s| s.fitted.jitter).fold(0.0, f64::max);
            if jitter > 0.0 {
                eprintln!(
                    "{name}, {}: jitter up to {jitter:e} was needed",
                    system.name
                );
            }
            let worst = scores.iter().map(|s| s.constraint).fold(0.0, f64::max);
            line += &format!(
                " | {mean:.4} [{low:.4}, {high:.4}] {worst:.2e} {:>5.1}s",
                start.elapsed().as_secs_f64()
            );
        }
        println!("{line}\n{:<26} {published}", "  published");
    }
    Ok(())
}
