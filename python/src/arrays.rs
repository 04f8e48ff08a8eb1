//! NumPy arrays as rows of numbers: a row per state.

use crate::error::Error;
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

/// An argument: finite float64 numbers in C order. What already is that is not copied.
pub struct Rows<'py> {
    array: PyReadonlyArrayDyn<'py, f64>,
    /// Axes in front of the rows.
    axes: usize,
}

impl<'py> Rows<'py> {
    /// An argument whose last axis has an entry for each of `names`.
    ///
    /// # Errors
    /// If it is no array of real numbers, has another shape, or a number is not finite.
    pub fn read(value: &Bound<'py, PyAny>, what: &str, names: &[String]) -> PyResult<Self> {
        let array = numbers(value, what)?;
        let shape = array.shape();
        let Some((_, axes)) = shape
            .split_last()
            .filter(|(width, _)| **width == names.len())
        else {
            let order = match names {
                [] => format!("the model has none: leave `{what}` out"),
                _ => format!(
                    "its last axis has an entry for each of {}",
                    names.join(", ")
                ),
            };
            let found = shown(shape);
            let message = format!(
                "`{what}` must have the shape (…, {}), not {found}: {order}",
                names.len()
            );
            return Err(Error::new_err(message));
        };
        let axes = axes.len();
        let rows = Self { array, axes };
        rows.check(what)?;
        Ok(rows)
    }

    /// An argument with one number per state.
    ///
    /// # Errors
    /// If it is no array of real numbers, or one is not finite.
    pub fn scalars(value: &Bound<'py, PyAny>, what: &str) -> PyResult<Self> {
        let array = numbers(value, what)?;
        let axes = array.shape().len();
        let rows = Self { array, axes };
        rows.check(what)?;
        Ok(rows)
    }

    /// The numbers, row by row.
    pub fn values(&self) -> &[f64] {
        // `numbers` has seen to it that they lie in order.
        self.array.as_slice().unwrap_or_default()
    }

    /// The interpreter that holds them.
    pub fn py(&self) -> Python<'py> {
        self.array.py()
    }

    /// Shape of the batch: the axes in front of the rows.
    pub fn batch(&self) -> &[usize] {
        &self.array.shape()[..self.axes]
    }

    fn check(&self, what: &str) -> PyResult<()> {
        let Some(place) = self.values().iter().position(|x| !x.is_finite()) else {
            return Ok(());
        };
        let mut index = Vec::new();
        let mut rest = place;
        for &length in self.array.shape().iter().rev() {
            index.push((rest % length).to_string());
            rest /= length;
        }
        index.reverse();
        let place = match index.is_empty() {
            true => format!("`{what}`"),
            false => format!("`{what}[{}]`", index.join(", ")),
        };
        let value = self.values().iter().find(|x| !x.is_finite());
        let value = value.copied().unwrap_or(f64::NAN);
        let message = format!("{place} is {value}; states and times are finite numbers");
        Err(Error::new_err(message))
    }
}

/// A shape as Python shows it.
pub fn shown(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    match &lengths[..] {
        [one] => format!("({one},)"),
        several => format!("({})", several.join(", ")),
    }
}

/// Real numbers as float64 in C order.
fn numbers<'py>(value: &Bound<'py, PyAny>, what: &str) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    if let Ok(array) = value.cast::<PyArrayDyn<f64>>()
        && array.is_c_contiguous()
        && let Ok(array) = array.try_readonly()
        && array.as_slice().is_ok()
    {
        return Ok(array);
    }
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (value,))?;
    let kind = array.getattr("dtype")?.getattr("kind")?;
    let kind = kind.cast::<PyString>()?.to_cow()?.into_owned();
    if !matches!(kind.as_str(), "f" | "i" | "u") {
        let dtype = array.getattr("dtype")?.str()?;
        let message = format!("`{what}` must hold real numbers, not {dtype}");
        return Err(PyTypeError::new_err(message));
    }
    let options = PyDict::new(value.py());
    options.set_item("dtype", "float64")?;
    options.set_item("order", "C")?;
    let array = numpy.call_method("array", (array,), Some(&options))?;
    Ok(array.cast::<PyArrayDyn<f64>>()?.try_readonly()?)
}
