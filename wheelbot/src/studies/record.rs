//! A run as the robot would write it down, and what a smoother makes of that.

use super::replay::low_passed;
use super::study::StudyError;
use crate::robot::{self, PITCH, ROLL, Wheelbot};
use crate::sensing::Sensing;
use crate::trial::{Row, rms};
use dynamics_codegen::{Library, compile};
use identify::log::Log;
use identify::machine::Hold;
use identify::trace::{Request, smoothed};
use std::fmt::Write;

/// The model that logs are held against, and its name in messages.
pub const MODEL: (&str, &str) = (
    "models/wheelbot.model",
    include_str!("../../../models/wheelbot.model"),
);

/// A log: both torques and all instruments, read when the torques of the tick act.
///
/// # Errors
/// If the robot cannot move so, or nothing was written.
pub fn written(
    name: &str,
    plant: &Wheelbot<f64>,
    rows: &[Row],
    sensing: &mut Sensing,
) -> Result<Log, StudyError> {
    let mut text = String::from("t,u_reaction,u_wheel");
    for sensor in &compile(MODEL.0, MODEL.1, &Library::builtin())?
        .model
        .sensors
    {
        text = text + "," + &sensor.name;
    }
    for row in rows {
        let read = sensing.numbers(&robot::shown(plant, &row.state, row.inputs)?);
        let numbers = [row.t, row.inputs[0], row.inputs[1]]
            .into_iter()
            .chain(read);
        let cells: Vec<String> = numbers.map(|number| number.to_string()).collect();
        let _ = write!(text, "\n{}", cells.join(","));
    }
    Ok(Log::from_bytes(name, text.as_bytes())?)
}

/// Errors of roll and pitch by a Kalman smoother through the model behind the low-pass of Fig. 6.11, rms, degrees. It
/// knows the whole run, before and after: what an estimator on the robot could reach at best.
///
/// # Errors
/// As of [`written`], and if the log cannot be smoothed.
pub fn smoother_errors(
    plant: &Wheelbot<f64>,
    rows: &[Row],
    sensing: &mut Sensing,
) -> Result<[f64; 2], StudyError> {
    let (log, library) = (
        written("run.csv", plant, rows, sensing)?,
        Library::builtin(),
    );
    let request = Request {
        hold: Some(Hold::Previous),
        ..Request::new(MODEL.0, MODEL.1, &library, &log)
    };
    let motion = smoothed(&request).map_err(Box::new)?;
    Ok([ROLL, PITCH].map(|place| {
        let missed = rows.iter().zip(&motion.q[place]);
        let missed = missed.map(|(row, found)| found - row.state.q[place]);
        rms(low_passed(missed).into_iter()).to_degrees()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::{Push, Trial};
    use wheelbot_firmware::Gains;

    /// Though it knows nothing of the push.
    #[test]
    fn a_smoother_knows_the_tilt_to_a_twentieth_of_a_degree() {
        let mut sensing = Sensing::new(1).unwrap();
        let mut trial = Trial::new(4.0, Gains::PUBLISHED);
        trial.pushes = vec![Push {
            at: 1.0,
            seconds: 0.1,
            force: [-2.0, 0.5],
        }];
        let rows = trial.run(&mut sensing).unwrap().rows;
        let mut calibrated = sensing.calibrated();
        let errors = smoother_errors(&Wheelbot::nominal(), &rows, &mut calibrated).unwrap();
        assert!(errors.into_iter().all(|error| error < 0.05), "{errors:?}");
    }
}
