//! Derivatives of the motion at many states.

use crate::batch;
use crate::error::unsolved;
use crate::model::Model;
use crate::place::{Place, fill};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyEllipsis, PySlice};
use std::ops::Range;

/// Derivatives of accelerations and multipliers, `∂a/∂s` and `∂λ/∂s`, at one state or many.
///
/// With n coordinates, m constraints, k inputs and p parameters, a row per coordinate or constraint
/// and a column per variable; SI units.
#[pyclass(frozen, module = "dynamics")]
pub struct Derivatives {
    /// All of them, (…, n + m, 2 n + k + p + 1): rows `a`, `λ`; columns `q, v, u`, parameters, `t`.
    all: Py<PyArrayDyn<f64>>,
    coordinates: usize,
    inputs: usize,
    parameters: usize,
}

/// Groups of rows.
#[derive(Clone, Copy)]
enum Of {
    Acceleration,
    Multiplier,
}

/// Groups of columns.
#[derive(Clone, Copy)]
enum By {
    Position,
    Velocity,
    Input,
    Parameter,
    Time,
}

impl Derivatives {
    /// At the states of a call.
    ///
    /// # Errors
    /// If a state has no unique motion, or an interrupt.
    pub fn at(model: &Model, place: &Place<'_>, parallel: bool) -> PyResult<Self> {
        let equations = &model.equations;
        let (machine, tape) = (equations.machine(), equations.derivatives());
        let (n, m) = (machine.coordinate_count(), machine.constraint_count());
        let width = tape.variable_count();
        let given = place.given(&model.values);
        let py = place.q.py();
        let all = fill(py, &place.batch, &[n + m, width], |out, size| {
            let work = |range: Range<usize>, rows: &mut [f64]| {
                let states = equations.states(&given, &range);
                let motions = machine
                    .motion(&states, &model.values)
                    .map_err(|error| error.offset(range.start))?;
                let slopes = tape.evaluate(&states, &model.values, &motions);
                for ((a, lambda), out) in slopes.iter().zip(rows.chunks_mut(size)) {
                    let entries = a.row_iter().chain(lambda.row_iter());
                    for (row, out) in entries.zip(out.chunks_mut(width)) {
                        out.iter_mut().zip(row.iter()).for_each(|(o, &x)| *o = x);
                    }
                }
                Ok(())
            };
            batch::run(py, out, size, parallel, work, unsolved)
        })?;
        Ok(Self {
            all: all.unbind(),
            coordinates: n,
            inputs: equations.inputs.len(),
            parameters: model.values.len(),
        })
    }

    /// A group of rows and columns; of time without an axis of columns.
    fn group<'py>(&self, py: Python<'py>, of: Of, by: By) -> PyResult<Bound<'py, PyAny>> {
        let (n, k, p) = (self.coordinates, self.inputs, self.parameters);
        let end = |index: usize| isize::try_from(index).unwrap_or(isize::MAX);
        let rows = match of {
            Of::Acceleration => PySlice::new(py, 0, end(n), 1),
            Of::Multiplier => PySlice::new(py, end(n), isize::MAX, 1),
        };
        let columns = match by {
            By::Position => 0..n,
            By::Velocity => n..2 * n,
            By::Input => 2 * n..2 * n + k,
            By::Parameter => 2 * n + k..2 * n + k + p,
            By::Time => return self.all.bind(py).get_item((PyEllipsis::get(py), rows, -1)),
        };
        let columns = PySlice::new(py, end(columns.start), end(columns.end), 1);
        self.all
            .bind(py)
            .get_item((PyEllipsis::get(py), rows, columns))
    }
}

#[pymethods]
impl Derivatives {
    /// ∂a/∂q, shape (…, n, n).
    #[getter]
    fn a_q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Acceleration, By::Position)
    }

    /// ∂a/∂v, shape (…, n, n).
    #[getter]
    fn a_v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Acceleration, By::Velocity)
    }

    /// ∂a/∂u, shape (…, n, k).
    #[getter]
    fn a_u<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Acceleration, By::Input)
    }

    /// ∂a/∂(parameters), shape (…, n, p), columns in the order of `Model.parameters`.
    #[getter]
    fn a_parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Acceleration, By::Parameter)
    }

    /// ∂a/∂t, shape (…, n).
    #[getter]
    fn a_t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Acceleration, By::Time)
    }

    /// ∂λ/∂q, shape (…, m, n).
    #[getter]
    fn lambda_q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Multiplier, By::Position)
    }

    /// ∂λ/∂v, shape (…, m, n).
    #[getter]
    fn lambda_v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Multiplier, By::Velocity)
    }

    /// ∂λ/∂u, shape (…, m, k).
    #[getter]
    fn lambda_u<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Multiplier, By::Input)
    }

    /// ∂λ/∂(parameters), shape (…, m, p), columns in the order of `Model.parameters`.
    #[getter]
    fn lambda_parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Multiplier, By::Parameter)
    }

    /// ∂λ/∂t, shape (…, m).
    #[getter]
    fn lambda_t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.group(py, Of::Multiplier, By::Time)
    }
}
