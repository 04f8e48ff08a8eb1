//! Recorded sensor values as tables of C and Rust: what the controller is tried on where it will run.

use crate::robot;
use crate::sensing::Sensing;
use crate::trial::{Row, Trial};
use dynamics::constrained::SolveError;
use dynamics_codegen::emit::File;
use minijinja::Environment;
use minijinja::value::Serde;
use serde::Serialize;
use wheelbot_firmware::{Gains, INTERVAL};

/// Ticks of the record.
const TICKS: usize = 20;
/// Roll and pitch where it starts, rad.
pub const START: [f64; 2] = [0.12, -0.06];

/// A fifth of a second of balancing from a lean, as the noisy sensors show it.
///
/// # Errors
/// If the equation of motion has no solution on the way.
pub fn rows(sensing: &mut Sensing) -> Result<Vec<Row>, SolveError> {
    let mut trial = Trial::new(TICKS as f64 * INTERVAL, Gains::PUBLISHED);
    trial.start = robot::leaning(START[0], START[1]);
    Ok(trial.run(sensing)?.rows)
}

/// A row in digits that both languages read back to the same bits.
#[derive(Serialize)]
struct Literals {
    gyroscopes: Vec<String>,
    accelerometers: Vec<String>,
    reaction: i32,
    rolling: i32,
    q: Vec<String>,
    v: Vec<String>,
    u: Vec<String>,
}

#[derive(Serialize)]
struct Record {
    start: Vec<String>,
    rows: Vec<Literals>,
}

/// The files `recorded.h` and `recorded.rs` of `examples/firmware`.
///
/// # Errors
/// If a template is none.
pub fn files(rows: &[Row]) -> Result<[File; 2], minijinja::Error> {
    let rows = rows.iter().map(|row| Literals {
        gyroscopes: literals(row.readings.gyroscopes.as_flattened()),
        accelerometers: literals(row.readings.accelerometers.as_flattened()),
        reaction: row.readings.reaction,
        rolling: row.readings.rolling,
        q: literals(&single(&row.state.q)),
        v: literals(&single(&row.state.v)),
        u: literals(&single(&row.inputs[..2])),
    });
    let record = Record {
        start: literals(&single(&START)),
        rows: rows.collect(),
    };
    let environment = Environment::new();
    let file = |name: &str, template| -> Result<File, minijinja::Error> {
        let text = environment.render_str(template, Serde(&record))?;
        Ok(File {
            name: name.to_string(),
            text: text + "\n",
        })
    };
    Ok([
        file("recorded.h", include_str!("recorded.h.txt"))?,
        file("recorded.rs", include_str!("recorded.rs.txt"))?,
    ])
}

/// As the controller's numbers hold it.
pub fn single(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&x| x as f32).collect()
}

fn literals(values: &[f32]) -> Vec<String> {
    values.iter().map(|x| format!("{x:?}")).collect()
}
