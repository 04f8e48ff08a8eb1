//! `Model.simulate`: open-loop motion.

use crate::arrays::Rows;
use crate::error::{Error, mistaken, raised};
use crate::model::Model;
use crate::place::Array;
use crate::terms::Equations;
use crate::wait::wait;
use cli::commands::simulate::rows;
use cli::inputs::Inputs;
use cli::noise::Channel;
use cli::simulation::{Run, Signal};
use cli::start::settle;
use cli::state::State;
use identify::machine::Machine;
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Of the noise that `sensor` statements state.
const SEED: u64 = 1;

/// What is simulated.
pub struct Wish<'a, 'py> {
    pub q: &'a Bound<'py, PyAny>,
    pub v: Option<&'a Bound<'py, PyAny>>,
    pub u: Option<&'a Bound<'py, PyAny>>,
    pub z: Option<&'a Bound<'py, PyAny>>,
    /// Times that the rows of `u` belong to, s.
    pub input_times: Option<&'a Bound<'py, PyAny>>,
    pub start: f64,
    pub duration: f64,
    pub rate: f64,
    pub max_step: f64,
}

impl Wish<'_, '_> {
    /// Simulates; Ctrl-C ends it.
    ///
    /// # Errors
    /// If an argument does not fit, or the motion cannot go on.
    pub fn run(&self, py: Python<'_>, model: &Model) -> PyResult<Simulation> {
        for (name, value) in [
            ("duration", self.duration),
            ("rate", self.rate),
            ("max_step", self.max_step),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                let message = format!("`{name}={value}` must be a positive finite number");
                return Err(Error::new_err(message));
            }
        }
        if !self.start.is_finite() {
            return Err(Error::new_err("`t` must be finite"));
        }
        let equations = &model.equations;
        let one = |value: Option<&Bound<'_, PyAny>>, what: &str, names: &[String]| {
            let Some(value) = value.filter(|value| !value.is_none()) else {
                return Ok(None);
            };
            let rows = Rows::read(value, what, names)?;
            match rows.batch() {
                [] => Ok(Some(rows.values().to_vec())),
                _ => {
                    let message = format!("`{what}` must be that of one state, ({},)", names.len());
                    Err(Error::new_err(message))
                }
            }
        };
        let n = equations.coordinates.len();
        let mut state = State {
            q: one(Some(self.q), "q", &equations.positions)?.unwrap_or_default(),
            v: one(self.v, "v", &equations.coordinates)?.unwrap_or_else(|| vec![0.0; n]),
            u: None,
            z: one(self.z, "z", &equations.states)?,
            t: self.start,
            parameters: model.values.clone(),
        };
        let inputs = self.inputs(&equations.inputs)?;
        let (rate, max_step) = (self.rate, self.max_step);
        let count = rows(self.duration, rate, max_step).map_err(|mistake| mistaken(&mistake))?;
        let machine: Machine = equations.machine().clone();
        let interrupted = Arc::new(AtomicBool::new(false));
        let is_interrupted = Arc::clone(&interrupted);
        let names = Arc::clone(equations);
        let work = move || {
            let u = inputs.at(state.t);
            settle(&machine, &mut state, &u)?;
            let mut motion = Simulation {
                t: Vec::with_capacity(count),
                rows: Vec::new(),
                equations: names,
            };
            let run = Run {
                machine: &machine,
                parameters: &state.parameters,
                signal: Signal::open(inputs, machine.delays(&state.parameters)),
                controller: None,
                noise: Channel::of_log(&machine.compiled.model, &[], SEED)?,
                seed: SEED,
                rate,
                max_step,
                impulses: false,
                exact_impacts: false,
            };
            run.rows(&state, count, |t, row, _| {
                anyhow::ensure!(!is_interrupted.load(Ordering::SeqCst), "interrupted");
                motion.t.push(t);
                motion.rows.extend_from_slice(row);
                Ok(())
            })?;
            Ok(motion)
        };
        wait(py, &interrupted, work)?.map_err(|error| raised(&error))
    }

    fn inputs(&self, names: &[String]) -> PyResult<Inputs> {
        let Some(u) = self.u.filter(|u| !u.is_none()) else {
            return Ok(Inputs::constant(vec![0.0; names.len()]));
        };
        let u = Rows::read(u, "u", names)?;
        let times = self.input_times.filter(|times| !times.is_none());
        match (u.batch(), times) {
            ([], None) => Ok(Inputs::constant(u.values().to_vec())),
            ([count], Some(times)) => {
                let times = Rows::scalars(times, "input_times")?;
                if times.batch() != [*count] {
                    let message = format!(
                        "`input_times` must have the shape ({count},), one time per row of `u`"
                    );
                    return Err(Error::new_err(message));
                }
                let row = |k: usize| u.values()[k * names.len()..][..names.len()].to_vec();
                let values = (0..*count).map(row).collect();
                Inputs::new(times.values().to_vec(), values).map_err(|mistake| mistaken(&mistake))
            }
            _ => Err(Error::new_err(
                "`u` must be one row of inputs, or rows with a time for each in `input_times`",
            )),
        }
    }
}

/// A motion: times and what sensors read, those of `sensor` statements with their noise.
///
/// `columns()` is a log as `trace` and `fit` take it.
#[pyclass(frozen, module = "dynamics")]
pub struct Simulation {
    t: Vec<f64>,
    /// Per time `q`, then `v` and `a` (`n` each), then `u`, then what `sensor` statements show.
    rows: Vec<f64>,
    equations: Arc<Equations>,
}

impl Simulation {
    /// Names of what `sensor` statements show.
    fn sensors(&self) -> impl Iterator<Item = &String> {
        let sensors = &self.equations.loaded.compiled.model.sensors;
        sensors.iter().map(|sensor| &sensor.name)
    }

    /// How many positions, coordinates and inputs there are.
    fn sizes(&self) -> [usize; 3] {
        let equations = &self.equations;
        [
            &equations.positions,
            &equations.coordinates,
            &equations.inputs,
        ]
        .map(Vec::len)
    }

    /// Some of the columns, shape (samples, number of columns).
    fn part<'py>(&self, py: Python<'py>, columns: Range<usize>) -> PyResult<Array<'py>> {
        let [p, n, k] = self.sizes();
        let width = p + 2 * n + k + self.sensors().count();
        let rows = self.rows.chunks(width);
        let values: Vec<f64> = rows
            .flat_map(|row| &row[columns.clone()])
            .copied()
            .collect();
        let shape = vec![self.t.len(), columns.len()];
        PyArray1::from_vec(py, values).reshape(shape)
    }
}

#[pymethods]
impl Simulation {
    /// Times, shape (samples,), s.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.t)
    }

    /// Positions, shape (samples, n), in the coordinates' units; one more for each body that floats by
    /// its twist.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let [p, _, _] = self.sizes();
        self.part(py, 0..p)
    }

    /// Velocities, shape (samples, n).
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let [p, n, _] = self.sizes();
        self.part(py, p..p + n)
    }

    /// Accelerations, shape (samples, n).
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let [p, n, _] = self.sizes();
        self.part(py, p + n..p + 2 * n)
    }

    /// Inputs, shape (samples, k), in the inputs' units.
    #[getter]
    fn u<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let [p, n, k] = self.sizes();
        self.part(py, p + 2 * n..p + 2 * n + k)
    }

    /// The motion as a log.
    ///
    /// Returns:
    ///     Arrays of the shape (samples,) by the names of a log's columns: `t`, `q_<position>`,
    ///     `dq_<coordinate>`, `ddq_<coordinate>`, `u_<input>`, and those of `sensor` statements.
    ///     `pandas.DataFrame` takes it.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        columns.set_item("t", self.t(py))?;
        let axes = &self.equations.coordinates;
        let groups = [
            ("q", &self.equations.positions),
            ("dq", axes),
            ("ddq", axes),
            ("u", &self.equations.inputs),
        ];
        let names = groups
            .iter()
            .flat_map(|(group, axes)| axes.iter().map(move |axis| format!("{group}_{axis}")));
        let names = names.chain(self.sensors().cloned());
        for (index, name) in names.enumerate() {
            let column = self.part(py, index..index + 1)?;
            columns.set_item(name, column.reshape(column.shape()[0])?)?;
        }
        Ok(columns)
    }

    fn __len__(&self) -> usize {
        self.t.len()
    }

    fn __repr__(&self) -> String {
        let name = &self.equations.loaded.compiled.model.name;
        format!("<Simulation of {name}: {} samples>", self.t.len())
    }
}
