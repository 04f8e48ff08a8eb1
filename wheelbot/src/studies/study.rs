//! What a program shows: findings, tables, charts, a map, and the motion.

use crate::design::DesignError;
use crate::robot::INSTRUMENTS;
use crate::trial::{Outcome, Row, wheel_rates};
use dynamics::constrained::SolveError;
use dynamics_codegen::diagnostic::Report;
use serde::Serialize;

/// Why a study has no outcome.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// There are no controllers.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The robot reached a state without a motion.
    #[error("the simulation cannot go on: {0}")]
    Simulation(#[from] SolveError),
    /// The robot on the floor reached a state without a motion.
    #[error("the simulation cannot go on: {0}")]
    Contact(#[from] identify::machine::SolveError),
    /// The robot's log is none.
    #[error(transparent)]
    Log(#[from] identify::log::LogError),
    /// The robot's log cannot be traced.
    #[error(transparent)]
    Trace(#[from] Box<identify::trace::TraceError>),
    /// A search has no region.
    #[error("the search has no region: {0}")]
    Bounds(String),
    /// The model's text is no model.
    #[error("{0}")]
    Model(#[from] Report),
}

/// What the thesis, or the task, states, and what came out here.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Of what.
    pub what: String,
    /// What is stated of it.
    pub stated: String,
    /// What came out.
    pub here: String,
    /// Whether they agree; nothing where there is nothing to agree with.
    pub holds: Option<bool>,
}

impl Finding {
    /// Something that agrees or does not.
    pub fn new(what: &str, stated: &str, here: impl Into<String>, holds: bool) -> Self {
        Self {
            what: what.into(),
            stated: stated.into(),
            here: here.into(),
            holds: Some(holds),
        }
    }

    /// Something that nothing is stated of.
    pub fn only_here(what: &str, here: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            stated: "—".into(),
            here: here.into(),
            holds: None,
        }
    }
}

/// Rows of text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// One per column.
    pub header: Vec<String>,
    /// As wide as the header.
    pub rows: Vec<Vec<String>>,
}

/// A curve's name, and how it is read off a tick.
pub type Curve<'a> = (&'a str, &'a dyn Fn(&Row) -> f64);

/// Curves over time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// Quantity and unit.
    pub title: String,
    /// Names and values, one value per tick of the motion.
    pub curves: Vec<(String, Vec<f64>)>,
}

impl Chart {
    /// A chart of what can be read off each tick.
    pub fn of(rows: &[Row], title: &str, curves: &[Curve<'_>]) -> Self {
        let curve =
            |(name, value): &Curve<'_>| ((*name).to_string(), rows.iter().map(value).collect());
        Self {
            title: title.into(),
            curves: curves.iter().map(curve).collect(),
        }
    }
}

/// Where a run ends well, over two starting values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Map {
    /// What it shows.
    pub title: String,
    /// Quantity and unit along each axis.
    pub axes: [String; 2],
    /// The same values along both axes.
    pub values: Vec<f64>,
    /// Row by row from the lowest second value: whether the run ended well.
    pub stood: Vec<Vec<bool>>,
}

/// Runs that ended well or not, over two numbers that were drawn for each.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cloud {
    /// What it shows.
    pub title: String,
    /// Quantity and unit along each axis.
    pub axes: [String; 2],
    /// The two numbers of every run.
    pub points: Vec<[f64; 2]>,
    /// Whether it ended well.
    pub stood: Vec<bool>,
}

/// The robot's motion for the view: one row per tick.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Motion {
    /// Seconds from one row to the next.
    pub interval: f64,
    /// `x, y, roll, pitch, yaw, wheel, reaction`.
    pub states: Vec<[f64; 7]>,
    /// Pushes forward and to the left, N.
    pub pushes: Vec<[f64; 2]>,
    /// Of the wheel's lowest point above the floor, m.
    pub lifts: Vec<f64>,
    /// The chassis, where its edges matter.
    pub chassis: Option<Chassis>,
}

/// The chassis as a box about the vertical through the hub, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Chassis {
    /// Half of its width.
    pub half: f64,
    /// Its lower edges above the hub,
    pub bottom: f64,
    /// and its upper ones.
    pub top: f64,
}

impl Chassis {
    /// That of `on_floor.model`.
    pub const PUBLISHED: Self = Self {
        half: 0.09524,
        bottom: 0.00199,
        top: 0.11 - 0.00199,
    };
}

impl Motion {
    /// That of a run.
    pub fn of(rows: &[Row]) -> Self {
        Self {
            interval: wheelbot_firmware::INTERVAL,
            states: rows.iter().map(|row| row.state.q).collect(),
            pushes: rows
                .iter()
                .map(|row| [row.inputs[2], row.inputs[3]])
                .collect(),
            lifts: vec![0.0; rows.len()],
            chassis: None,
        }
    }
}

/// What a program shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Study {
    /// What was done.
    pub title: String,
    /// Sentences on how.
    pub about: Vec<String>,
    /// Statements and what came out.
    pub findings: Vec<Finding>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Curves beside the view.
    pub charts: Vec<Chart>,
    /// Maps.
    pub maps: Vec<Map>,
    /// Clouds.
    pub clouds: Vec<Cloud>,
    /// What the view shows.
    pub motion: Motion,
}

/// The charts that every run has: tilt with its estimate, torques, wheel rates.
pub fn charts(outcome: &Outcome) -> Vec<Chart> {
    use crate::robot::{PITCH, ROLL};
    let rows = &outcome.rows;
    let tilt = |title: &str, place: usize, of: usize| {
        Chart::of(
            rows,
            title,
            &[
                ("true", &|row| row.state.q[place].to_degrees()),
                ("estimated", &|row| {
                    f64::from(row.tilt.fused[of]).to_degrees()
                }),
            ],
        )
    };
    vec![
        tilt("roll [°]", ROLL, 0),
        tilt("pitch [°]", PITCH, 1),
        Chart::of(
            rows,
            "torque [N·m]",
            &[
                ("reaction wheel", &|row| row.inputs[0]),
                ("rolling wheel", &|row| row.inputs[1]),
            ],
        ),
        Chart::of(
            rows,
            "wheel rate against the body [rad/s]",
            &[
                ("reaction wheel", &|row| wheel_rates(&row.state)[0]),
                ("rolling wheel", &|row| wheel_rates(&row.state)[1]),
            ],
        ),
    ]
}

/// Largest torque of a run, N·m.
pub fn largest_torque(rows: &[Row]) -> f64 {
    let torques = rows.iter().flat_map(|row| [row.inputs[0], row.inputs[1]]);
    torques.fold(0.0, |most, torque| most.max(torque.abs()))
}

/// The true acceleration of the wheel's centre along the axes of `{C}`, m/s².
pub fn pivot(row: &Row) -> [f64; 3] {
    let [x, y, z] = [1, 2, 3].map(|k| row.shown[INSTRUMENTS - 4 + k]);
    let (sin, cos) = row.state.q[crate::robot::YAW].sin_cos();
    [cos * x + sin * y, cos * y - sin * x, z]
}
