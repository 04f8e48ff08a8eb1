//! From a model file to a predicted constraint force: the code of `docs/gp.md`.
//!
//! `cargo run -p eqmotion-gp --example guide`. The model is in `particle.rs`.

mod particle;
#[cfg(test)]
mod tests;

use gp::{Quantity, Result};
use particle::{learn, log, rows, state, truth};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

fn main() -> Result<()> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (states, y) = log(&mut rng)?;
    let x = state(&mut rng);
    // use
    let model = learn(&states, &y)?;
    let a = model.predict(&rows(&[x], Quantity::Acceleration)?)?; // m/s²
    let lambda = model.predict(&rows(&[x], Quantity::Multiplier)?)?; // Q_I = A^T λ, N
    let (low, high) = lambda.band95();
    // end
    let (a_true, lambda_true) = truth(&x)?;
    println!("acceleration {:7.3?} m/s², true {a_true:7.3?}", a.mean);
    println!(
        "λ {:.2} N, 95 % in [{:.2}, {:.2}], true {lambda_true:.2}",
        lambda.mean[0], low[0], high[0]
    );
    Ok(())
}
