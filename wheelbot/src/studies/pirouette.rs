//! Three turns about yaw in four seconds by torques ahead of the feedback (Fig. 6.9).

use super::study::{Chart, Finding, Motion, Study, StudyError, charts, largest_torque};
use crate::excitation::Excitation;
use crate::robot::YAW;
use crate::sensing::Sensing;
use crate::trial::{Outcome, Trial};
use wheelbot_firmware::Gains;

/// Turns wanted.
const TURNS: f64 = 3.0;
/// The time for them, s.
const TIME: f64 = 4.0;
/// Balancing before and after, s.
const ASIDE: f64 = 2.0;

/// The swing: the best of those that `examples/swing.rs` tries on the model without noise.
const SWING: Excitation = Excitation {
    at: ASIDE,
    seconds: TIME,
    frequency: 3.022,
    phase: 1.711,
    torque: [0.255, 0.0797],
    turning_point: 0.6375,
};

/// Balancing with the swing.
///
/// # Errors
/// [`StudyError`].
pub fn run(gains: Gains<f64>, sensing: &mut Sensing) -> Result<Outcome, StudyError> {
    let mut trial = Trial::new(TIME + 2.0 * ASIDE, gains);
    trial.excitations = vec![SWING];
    Ok(trial.calibrated(sensing)?.run(sensing)?)
}

/// Turns about yaw from the beginning of the swing until a time after it, s.
fn turned(outcome: &Outcome, seconds: f64) -> f64 {
    let yaw = |t: f64| {
        let row = outcome.rows.iter().find(|row| row.t >= t - 1e-9);
        row.map_or(f64::NAN, |row| row.state.q[YAW])
    };
    (yaw(ASIDE + seconds) - yaw(ASIDE)) / std::f64::consts::TAU
}

/// Runs it.
///
/// # Errors
/// [`StudyError`].
pub fn study(gains: Gains<f64>, seed: u64) -> Result<Study, StudyError> {
    let outcome = run(gains, &mut Sensing::new(seed)?)?;
    let rows = &outcome.rows;
    let turns = turned(&outcome, TIME);
    let mut curves = vec![Chart::of(
        rows,
        "yaw [turns]",
        &[("true", &|row| row.state.q[YAW] / std::f64::consts::TAU)],
    )];
    curves.extend(charts(&outcome));
    Ok(Study {
        title: "Three turns about yaw in four seconds".into(),
        about: vec![
            "Both wheels swing in step, ahead of the balancing feedback: leaning and torque together \
             leave a moment about the vertical axis, which the linear model does not have."
                .into(),
        ],
        findings: vec![
            Finding::new(
                "Turns in 4 s (Fig. 6.9)",
                "3",
                format!("{:.2}", turns.abs()),
                turns.abs() >= TURNS && !outcome.fell,
            ),
            Finding::new(
                "Largest torque",
                "1.3 N·m at most",
                format!("{:.2} N·m", largest_torque(rows)),
                largest_torque(rows) <= crate::motors::STALL_TORQUE,
            ),
        ],
        tables: Vec::new(),
        charts: curves,
        maps: Vec::new(),
        clouds: Vec::new(),
        motion: Motion::of(rows),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_turns_three_times_and_keeps_standing() {
        for seed in [1, 2, 3] {
            let outcome = run(Gains::PUBLISHED, &mut Sensing::new(seed).unwrap()).unwrap();
            assert!(!outcome.fell, "seed {seed}");
            assert!(turned(&outcome, TIME).abs() >= TURNS, "seed {seed}");
        }
    }
}
