//! The pulses of both ways up by optimisation over the simulation, printed as numbers: those of
//! [`plans`](crate::jump::plans).

use super::study::{Chassis, Finding, Motion, Study, StudyError, Table, charts};
use crate::feed_forward::search::{Effort, Least, Variable};
use crate::feed_forward::up;
use crate::jump::Way;
use crate::jump::plans::published;
use crate::trial::Outcome;
use wheelbot_firmware::Gains;

/// For a step's two or three numbers.
const STEP: Effort = Effort {
    samples: 7,
    generations: 10,
};

/// The pulses of a way up.
///
/// # Errors
/// [`StudyError`].
pub fn up(way: Way, gains: Gains<f64>, seed: u64) -> Result<Study, StudyError> {
    let scenes = up::Scenes::new(gains, seed)?;
    let mut steps = published(way);
    let (mut findings, mut rows) = (Vec::new(), Vec::new());
    for (step, name) in ["First step", "Second step"].into_iter().enumerate() {
        let (variables, found) = scenes.improve(&mut steps, step, STEP)?;
        findings.push(cheaper(name, &found));
        rows.extend(numbers(name, &variables, &found));
    }
    let shown = scenes.shown(&steps)?;
    let outcome = Outcome {
        rows: shown.rows,
        fell: shown.fell,
    };
    Ok(Study {
        title: "The pulses of a way up, by optimisation".into(),
        about: vec![
            "CMA-ES over simulated robots on either side, on little and much friction, light and heavy; from the robot's own \
             currents and times on. A step costs what it misses, on the mean and at worst, its time and its torque."
                .into(),
        ],
        findings,
        tables: vec![table(rows)],
        charts: charts(&outcome),
        maps: Vec::new(),
        clouds: Vec::new(),
        motion: Motion {
            lifts: shown.lifts,
            chassis: Some(Chassis::PUBLISHED),
            ..Motion::of(&outcome.rows)
        },
    })
}

fn cheaper(what: &str, found: &Least) -> Finding {
    Finding::new(
        &format!("{what}: cost"),
        &format!("below {:.3} of the start", found.began),
        format!("{:.3}, {} evaluations", found.cost, found.evaluations),
        found.cost < found.began,
    )
}

fn numbers(what: &str, variables: &[Variable], found: &Least) -> Vec<Vec<String>> {
    let row = |(variable, value): (&Variable, &f64)| {
        vec![
            format!("{what}: {}", variable.name),
            format!("{:.4}", variable.start),
            format!("{value:.4}"),
        ]
    };
    variables.iter().zip(&found.values).map(row).collect()
}

fn table(rows: Vec<Vec<String>>) -> Table {
    Table {
        title: "Numbers".into(),
        header: ["", "start", "found"].map(String::from).to_vec(),
        rows,
    }
}
