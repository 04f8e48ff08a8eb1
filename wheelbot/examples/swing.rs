//! The search behind the pirouette's swing: random swings on the model without noise, the best printed.
//!
//!     cargo run --release -p wheelbot --example swing

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use wheelbot::excitation::Excitation;
use wheelbot::robot::{PITCH, ROLL, YAW};
use wheelbot::sensing::Sensing;
use wheelbot::trial::Trial;
use wheelbot_firmware::Gains;

const TRIALS: usize = 4000;
const SHOWN: usize = 15;

/// A swing, the turns in its four seconds, the yaw rate that is left after it, rad/s, and the largest tilt, degrees.
type Found = (Excitation, f64, f64, f64);

fn tried(swing: Excitation, sensing: &Sensing) -> Option<Found> {
    let mut trial = Trial::new(8.0, Gains::PUBLISHED);
    trial.excitations = vec![swing];
    let outcome = trial.run(&mut sensing.clone()).ok()?;
    if outcome.fell {
        return None;
    }
    let rows = &outcome.rows;
    let yaw = |tick: usize| rows[tick].state.q[YAW];
    let tilts = rows
        .iter()
        .map(|row| row.state.q[ROLL].abs().max(row.state.q[PITCH].abs()));
    Some((
        swing,
        (yaw(600) - yaw(200)).abs() / std::f64::consts::TAU,
        rows.last()?.state.v[YAW],
        tilts.fold(0.0, f64::max).to_degrees(),
    ))
}

fn main() -> anyhow::Result<()> {
    let sensing = Sensing::new(0)?.without_noise();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let swings: Vec<Excitation> = (0..TRIALS)
        .map(|_| Excitation {
            at: 2.0,
            seconds: 4.0,
            frequency: random.random_range(0.5..4.0),
            phase: random.random_range(0.0..std::f64::consts::TAU),
            torque: [
                random.random_range(0.05..0.8),
                random.random_range(0.05..0.6),
            ],
            turning_point: random.random_range(0.45..0.7),
        })
        .collect();
    let tried = swings
        .par_iter()
        .filter_map(|swing| tried(*swing, &sensing));
    let mut found: Vec<Found> = tried.collect();
    println!(
        "{} of {TRIALS} swings leave the robot standing",
        found.len()
    );
    // Turns that are wanted, less what is left of the turn, which the rest of the time has to wait out.
    let worth = |(_, turns, left, _): &Found| turns.min(3.2) - 0.2 * left.abs();
    found.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    for (swing, turns, left, tilt) in found.iter().take(SHOWN) {
        println!("{turns:.2} turns, {left:+.2} rad/s left, tilt {tilt:.0}°: {swing:?}");
    }
    Ok(())
}
