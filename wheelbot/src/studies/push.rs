//! Pushes from all sides (Fig. 6.12), and the largest that is survived.

use super::study::{Chart, Finding, Motion, Study, StudyError, Table, charts, largest_torque};
use crate::design;
use crate::sensing::Sensing;
use crate::trial::{Outcome, Push, Row, Trial};
use rayon::prelude::*;
use wheelbot_firmware::Gains;

/// Directions of pushes against the heading, degrees to the left of forward.
pub(super) const DIRECTIONS: [f64; 8] = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0];
/// How long one lasts, s.
const SECONDS: f64 = 0.1;
/// From one to the next, s.
const PAUSE: f64 = 5.0;
/// Impulse of those that are shown, N·s.
const IMPULSE: f64 = 0.3;
/// What is tried at most, N·s, and how finely.
const MOST_IMPULSE: f64 = 2.0;
const HALVINGS: usize = 8;

/// Runs it.
///
/// # Errors
/// [`StudyError`].
pub fn study(gains: Gains<f64>, seed: u64) -> Result<Study, StudyError> {
    let sensing = Sensing::new(seed)?;
    let outcome = shown(gains, &mut sensing.clone())?;
    let rows = &outcome.rows;
    let torque = largest_torque(rows);
    let bring_back = back_upright(&outcome);
    let mut shown = charts(&outcome);
    shown.push(Chart::of(
        rows,
        "push [N]",
        &[
            ("forward", &|row| row.inputs[2]),
            ("to the left", &|row| row.inputs[3]),
        ],
    ));
    Ok(Study {
        title: "Pushes from eight directions".into(),
        about: vec![format!(
            "Each push acts for {SECONDS} s at the axle of the reaction wheel, {IMPULSE} N·s."
        )],
        findings: vec![
            Finding::new(
                "Pushes recovered (Fig. 6.12)",
                "all",
                format!("{bring_back} of {}", DIRECTIONS.len()),
                bring_back == DIRECTIONS.len(),
            ),
            Finding::new(
                "Largest torque (Fig. 6.12)",
                "about 1 N·m, 1.3 N·m at most",
                format!("{torque:.2} N·m"),
                torque <= crate::motors::STALL_TORQUE,
            ),
        ],
        tables: vec![largest(&sensing)?],
        charts: shown,
        maps: Vec::new(),
        clouds: Vec::new(),
        motion: Motion::of(rows),
    })
}

/// One push after the other.
fn shown(gains: Gains<f64>, sensing: &mut Sensing) -> Result<Outcome, StudyError> {
    let mut trial = Trial::new(PAUSE * (DIRECTIONS.len() + 1) as f64, gains);
    trial.pushes = (1..)
        .zip(DIRECTIONS)
        .map(|(k, direction)| push(PAUSE * f64::from(k), direction, IMPULSE))
        .collect();
    Ok(trial.calibrated(sensing)?.run(sensing)?)
}

fn push(at: f64, direction: f64, impulse: f64) -> Push {
    let (sin, cos) = direction.to_radians().sin_cos();
    let force = impulse / SECONDS;
    Push {
        at,
        seconds: SECONDS,
        force: [force * cos, force * sin],
    }
}

/// Tilt within which the robot stands upright again, rad: 2°.
const UPRIGHT: f64 = 0.035;

/// After how many pushes the robot stood upright for the last second before the next one.
fn back_upright(outcome: &Outcome) -> usize {
    let upright = |row: &Row| row.state.q[2].abs().max(row.state.q[3].abs()) < UPRIGHT;
    let stood = |k: &usize| {
        let end = PAUSE * (*k + 2) as f64;
        let last = outcome
            .rows
            .iter()
            .filter(|row| row.t > end - 1.0 && row.t < end);
        last.clone().count() > 0 && last.clone().all(upright)
    };
    (0..DIRECTIONS.len()).filter(stood).count()
}

/// The largest impulses that published and designed gains survive, by halving.
fn largest(sensing: &Sensing) -> Result<Table, StudyError> {
    let designed = design::designed()?;
    let row = |direction: &f64| -> Result<Vec<String>, StudyError> {
        let impulses = [Gains::PUBLISHED, designed]
            .map(|gains| survived(&Trial::new(0.0, gains), *direction, sensing));
        let [published, designed] = impulses;
        Ok(vec![
            format!("{direction:.0}°"),
            format!("{:.2}", published?),
            format!("{:.2}", designed?),
        ])
    };
    Ok(Table {
        title: "Largest push survived, N·s, by direction (0°: from behind, 90°: from the right)"
            .into(),
        header: ["", "published gains", "designed gains"]
            .map(String::from)
            .to_vec(),
        rows: DIRECTIONS.par_iter().map(row).collect::<Result<_, _>>()?,
    })
}

/// The largest impulse from a direction that a robot survives half a second after it starts, N·s, by
/// halving.
pub(super) fn survived(
    robot: &Trial,
    direction: f64,
    sensing: &Sensing,
) -> Result<f64, StudyError> {
    let (mut least, mut most) = (0.0, MOST_IMPULSE);
    for _ in 0..HALVINGS {
        let middle = (least + most) / 2.0;
        let trial = Trial {
            seconds: 4.0,
            pushes: vec![push(0.5, direction, middle)],
            ..robot.clone()
        };
        match trial.run(&mut sensing.clone())?.fell {
            true => most = middle,
            false => least = middle,
        }
    }
    Ok(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pushes_from_all_sides_are_recovered_and_a_blow_is_not() {
        let mut sensing = Sensing::new(1).unwrap();
        let outcome = shown(Gains::PUBLISHED, &mut sensing.clone()).unwrap();
        assert_eq!(back_upright(&outcome), DIRECTIONS.len());
        assert!(largest_torque(&outcome.rows) <= 1.3);
        let mut trial = Trial::new(4.0, Gains::PUBLISHED);
        trial.pushes = vec![push(0.5, 90.0, MOST_IMPULSE)];
        assert!(trial.run(&mut sensing).unwrap().fell);
    }
}
