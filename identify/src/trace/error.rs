//! Why a log could not be traced.

use crate::log::{LogError, Record, health};
use crate::machine::SolveError;
use crate::smooth::SmoothError;
use dynamics_codegen::Report;

/// Why a log could not be traced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TraceError {
    /// The log cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log cannot be smoothed.
    #[error(transparent)]
    Smooth(#[from] SmoothError),
    /// The model's text is wrong.
    #[error(transparent)]
    Model(#[from] Box<Report>),
    /// The equation of motion has no solution somewhere along the log.
    #[error("the model cannot be evaluated along the log at t = {time} s: {source}{hint}")]
    Solve {
        /// When.
        time: f64,
        /// What may be wrong with the log, if something is odd about it.
        hint: String,
        /// Why.
        source: SolveError,
    },
    /// A parameter to override does not exist.
    #[error("the model has no parameter `{name}`; it has: {known}")]
    UnknownParameter {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// A value in a parameter's stead lies outside its bounds, which no search leaves.
    #[error(
        "`{name}` cannot be {value}: the model says {bounds}, and a search keeps to that; give \
         another value, or change the bounds in the model"
    )]
    OutOfBounds {
        /// The parameter.
        name: String,
        /// What was asked for.
        value: f64,
        /// What it may be, in words.
        bounds: String,
    },
    /// The model says what cannot be said of a body that floats by the rates of its pose.
    #[error("{}", unrated(.body, .report))]
    Floats {
        /// Which.
        body: String,
        /// What the compiler says.
        report: Box<Report>,
    },
    /// The log does not obey a constraint of the model.
    #[error(
        "the log does not fulfil constraint `{constraint}`: it is off by {violation:.3e} (root mean \
         square), at t = {time:.6} s by {worst:.3e}, but the sensors' noise explains {expected:.3e} only; \
         check that the columns, signs and geometry belong to this machine"
    )]
    Constraint {
        /// Which.
        constraint: String,
        /// Root mean square of `c`.
        violation: f64,
        /// What noise makes of it.
        expected: f64,
        /// When it is worst.
        time: f64,
        /// By how much.
        worst: f64,
    },
    /// Nothing shows a coordinate.
    #[error(
        "no column shows coordinate `{coordinate}`, and the sensors that the log has ({sensors}) do not \
         determine it: with the model they leave it open by ±{sd:.2} {unit} or more. Log its position \
         `q_{coordinate}`, or state and log a sensor that depends on it, such as an encoder, the \
         position of a point, or an accelerometer where gravity shows which way it is turned"
    )]
    Undetermined {
        /// Which.
        coordinate: String,
        /// Those that the log has.
        sensors: String,
        /// How uncertain it is at least, in its unit.
        sd: f64,
        /// Its unit.
        unit: String,
    },
    /// No motion of what nothing shows agrees with the sensors.
    #[error(
        "no column shows {coordinates}, and no motion was found on which the model agrees with the sensors \
         that the log has ({sensors}): the best one fails at t = {time} s. Log the positions as well, or \
         sensors that show where each is, such as an encoder or the position of a point; a search begins \
         near zero"
    )]
    NoMotion {
        /// The coordinates.
        coordinates: String,
        /// Those that the log has.
        sensors: String,
        /// Where the best motion fails.
        time: f64,
        /// Why.
        source: SolveError,
    },
    /// A log of a machine at rest.
    #[error(
        "nothing moves in {log}: every position is constant. A model is judged by its motion: give a \
         log in which the machine moves"
    )]
    Motionless {
        /// Which log.
        log: String,
    },
    /// Too little to split.
    #[error(
        "the log has {samples} samples; at least {needed} are needed to keep a third apart, or {alone} \
         in each of two logs: give a longer log or a second one with `--test`"
    )]
    TooShort {
        /// What there is.
        samples: usize,
        /// What is needed.
        needed: usize,
        /// What each of two logs needs.
        alone: usize,
    },
}

impl TraceError {
    /// Of a log with coordinates that nothing measures, where the search for their motion ended.
    pub(super) fn no_motion(source: SolveError, record: &Record) -> Self {
        let coordinates = record.coordinates.iter().enumerate();
        let unmeasured = coordinates.filter(|&(i, _)| !record.is_measured(i));
        let coordinates: Vec<String> = unmeasured.map(|(_, name)| format!("`{name}`")).collect();
        Self::NoMotion {
            coordinates: coordinates.join(", "),
            sensors: sensors_of(record),
            time: record.t.get(source.sample()).copied().unwrap_or(f64::NAN),
            source,
        }
    }

    /// With the time of the sample.
    pub(super) fn at(source: SolveError, times: &[f64]) -> Self {
        let hint =
            health::strange_rate(times).map_or_else(String::new, |warning| format!("; {warning}"));
        Self::Solve {
            hint,
            time: times.get(source.sample()).copied().unwrap_or(f64::NAN),
            source,
        }
    }
}

/// The model's sensors that a log has, as messages list them.
pub(super) fn sensors_of(record: &Record) -> String {
    let each = record.readings().iter();
    let each: Vec<String> = each.map(|r| format!("`{}`", r.name)).collect();
    each.join(", ")
}

/// Why a log is not held against a model whose bodies float by their twists.
pub(crate) fn unrated(body: &str, report: &Report) -> String {
    format!(
        "`{body}` floats by its twist, and logs are held against the rates of its pose (`velocities: rates`), of \
         which the model cannot say the same:\n{report}"
    )
}
