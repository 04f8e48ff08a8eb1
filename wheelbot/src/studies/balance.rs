//! Balancing for a minute with noisy sensors; the published gains beside those designed from the model.

use super::basin::{basin, share};
use super::study::{Finding, Motion, Study, StudyError, Table, charts, largest_torque};
use crate::design::{self, planes, poles::poles};
use crate::robot::{PITCH, ROLL};
use crate::sensing::Sensing;
use crate::trial::{Row, Trial, rms};
use wheelbot_firmware::{Gains, INTERVAL};

/// How long it balances, s.
pub const SECONDS: f64 = 60.0;
/// Root mean square of the tilt at most, degrees.
const MOST_TILT: f64 = 1.0;

/// Runs it.
///
/// # Errors
/// [`StudyError`].
pub fn study(gains: Gains<f64>, seed: u64) -> Result<Study, StudyError> {
    let designed = design::designed()?;
    let mut sensing = Sensing::new(seed)?;
    let trial = Trial::new(SECONDS, gains).calibrated(&mut sensing)?;
    let outcome = trial.run(&mut sensing)?;
    let rows = &outcome.rows;
    let degrees = |value: &dyn Fn(&Row) -> f64| rms(rows.iter().map(value)).to_degrees();
    let tilt = [ROLL, PITCH].map(|place| degrees(&|row| row.state.q[place]));
    let missed = [(ROLL, 0), (PITCH, 1)]
        .map(|(place, of)| degrees(&|row| f64::from(row.tilt.fused[of]) - row.state.q[place]));
    let maps = vec![
        basin(
            "Tilts from which it stands: published gains",
            Gains::PUBLISHED,
        )?,
        basin("Tilts from which it stands: designed gains", designed)?,
    ];
    let both = |[roll, pitch]: [f64; 2]| format!("roll {roll:.2}°, pitch {pitch:.2}°");
    let stands = !outcome.fell && tilt.iter().all(|degrees| *degrees <= MOST_TILT);
    let mut findings = vec![
        Finding::new("Tilt over 60 s, rms", "at most 1°", both(tilt), stands),
        Finding::only_here(
            "Error of the estimated tilt, rms, with its bias",
            both(missed),
        ),
        Finding::new(
            "Largest torque",
            "1.3 N·m at stall",
            format!("{:.2} N·m", largest_torque(rows)),
            largest_torque(rows) <= crate::motors::STALL_TORQUE,
        ),
    ];
    findings.extend(
        maps.iter().map(|map| {
            Finding::only_here(&map.title, format!("{:.0} % of ±36°", 100.0 * share(map)))
        }),
    );
    Ok(Study {
        title: "Balancing for a minute".into(),
        about: vec![
            "Sensors with noise, bias and steps as in Fig. 6.6; the controller at 100 Hz, one tick late.".into(),
        ],
        findings,
        tables: vec![gain_table(designed), pole_table(designed)?],
        charts: charts(&outcome),
        maps,
        clouds: Vec::new(),
        motion: Motion::of(rows),
    })
}

fn gain_table(designed: Gains<f64>) -> Table {
    let row = |name: &str, gain: [f64; 4]| {
        let numbers = gain.iter().map(|k| format!("{k:.4}"));
        std::iter::once(name.to_string()).chain(numbers).collect()
    };
    let published = Gains::PUBLISHED;
    Table {
        title: "Gains, N·m per rad and rad/s".into(),
        header: ["", "tilt", "tilt rate", "wheel angle", "wheel rate"]
            .map(String::from)
            .to_vec(),
        rows: vec![
            row("roll, published (6.22)", published.roll),
            row("roll, designed", designed.roll),
            row("pitch, published (6.22)", published.pitch),
            row("pitch, designed", designed.pitch),
        ],
    }
}

fn pole_table(designed: Gains<f64>) -> Result<Table, StudyError> {
    let [roll, pitch] = planes(Some(INTERVAL))?;
    let mut rows = Vec::new();
    for (name, gains) in [("published", Gains::PUBLISHED), ("designed", designed)] {
        for (plane, system, gain) in [("roll", roll, gains.roll), ("pitch", pitch, gains.pitch)] {
            let of = |delay| {
                let poles = poles(&system, &gain, delay);
                let sizes: Vec<String> = poles.iter().map(|p| format!("{:.3}", p.norm())).collect();
                sizes.join(", ")
            };
            rows.push(vec![format!("{plane}, {name}"), of(0), of(1), of(2)]);
        }
    }
    Ok(Table {
        title: "Absolute values of the closed loop's poles, by ticks of delay".into(),
        header: ["", "0", "1", "2"].map(String::from).to_vec(),
        rows,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every seed gives another robot: other biases, other noise.
    #[test]
    fn it_balances_with_noise_within_a_degree() {
        for seed in [1, 2] {
            let trial = Trial::new(20.0, Gains::PUBLISHED);
            let outcome = trial.run(&mut Sensing::new(seed).unwrap()).unwrap();
            assert!(!outcome.fell);
            for place in [ROLL, PITCH] {
                let tilt = rms(outcome.rows.iter().map(|row| row.state.q[place])).to_degrees();
                assert!(tilt < MOST_TILT, "seed {seed}: {tilt}");
                assert!(tilt > 1e-3, "nothing moved");
            }
        }
    }

    #[test]
    fn without_feedback_it_falls() {
        let none = Gains {
            roll: [0.0; 4],
            pitch: [0.0; 4],
        };
        let mut trial = Trial::new(5.0, none);
        trial.start = crate::robot::leaning(0.01, 0.0);
        assert!(trial.run(&mut Sensing::new(1).unwrap()).unwrap().fell);
    }
}
