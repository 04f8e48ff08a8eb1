//! The arguments of a call that say where, and the array that it answers with.

use crate::arrays::{Rows, shown};
use crate::error::Error;
use crate::terms::{Entries, Equations, Given};
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

/// What a call answers with.
pub type Array<'py> = Bound<'py, PyArrayDyn<f64>>;
/// Whatever Python gives for an argument.
pub type Any<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

/// The arguments of a call that say where.
pub struct Place<'py> {
    pub q: Rows<'py>,
    v: Option<Rows<'py>>,
    u: Option<Rows<'py>>,
    a: Option<Rows<'py>>,
    z: Option<Rows<'py>>,
    t: Option<Rows<'py>>,
    /// The axes that states are arranged along; none for one state.
    pub batch: Vec<usize>,
}

impl<'py> Place<'py> {
    /// Reads the arguments of a call; of `v, u, a, z` and `t` what was given.
    ///
    /// # Errors
    /// If one of them does not fit the model, or two do not fit each other.
    pub fn read(
        equations: &Equations,
        q: &Bound<'py, PyAny>,
        [v, u, a, z]: [Any<'_, 'py>; 4],
        t: Any<'_, 'py>,
    ) -> PyResult<Self> {
        let names = &equations.coordinates;
        let rows = |value: Any<'_, 'py>, what: &str, names: &[String]| {
            let given = value.filter(|value| !value.is_none());
            given
                .map(|value| Rows::read(value, what, names))
                .transpose()
        };
        let t = t.filter(|t| !t.is_none());
        let mut place = Place {
            q: Rows::read(q, "q", &equations.positions)?,
            v: rows(v, "v", names)?,
            u: rows(u, "u", &equations.inputs)?,
            a: rows(a, "a", names)?,
            z: rows(z, "z", &equations.states)?,
            t: t.map(|t| Rows::scalars(t, "t")).transpose()?,
            batch: Vec::new(),
        };
        place.batch = place.common_batch()?;
        Ok(place)
    }

    /// The batch that all arguments share: those with axes in front have the same ones.
    fn common_batch(&self) -> PyResult<Vec<usize>> {
        let named = [
            ("q", Some(&self.q)),
            ("v", self.v.as_ref()),
            ("u", self.u.as_ref()),
            ("a", self.a.as_ref()),
            ("z", self.z.as_ref()),
            ("t", self.t.as_ref()),
        ];
        let mut common: Option<(&str, &[usize])> = None;
        for (name, rows) in named {
            let Some(batch) = rows.map(Rows::batch).filter(|batch| !batch.is_empty()) else {
                continue;
            };
            match common {
                None => common = Some((name, batch)),
                Some((first, shape)) if shape != batch => {
                    let message = format!(
                        "`{first}` holds a batch of the shape {} and `{name}` one of {}: give each \
                         argument for the same states, or once for all of them",
                        shown(shape),
                        shown(batch)
                    );
                    return Err(Error::new_err(message));
                }
                Some(_) => {}
            }
        }
        Ok(common.map_or_else(Vec::new, |(_, batch)| batch.to_vec()))
    }

    /// The same for the equations.
    pub fn given<'a>(&'a self, parameters: &'a [f64]) -> Given<'a> {
        let entries = |rows: Option<&'a Rows<'_>>| match rows {
            None => Entries::None,
            Some(rows) if rows.batch().is_empty() => Entries::Same(rows.values()),
            Some(rows) => Entries::Each(rows.values()),
        };
        Given {
            t: entries(self.t.as_ref()),
            q: entries(Some(&self.q)),
            v: entries(self.v.as_ref()),
            u: entries(self.u.as_ref()),
            a: entries(self.a.as_ref()),
            z: entries(self.z.as_ref()),
            parameters,
        }
    }
}

/// A new array of the shape `(*batch, *shape)`, filled by `work`, which is told the numbers per state.
pub fn fill<'py>(
    py: Python<'py>,
    batch: &[usize],
    shape: &[usize],
    work: impl FnOnce(&mut [f64], usize) -> PyResult<()>,
) -> PyResult<Array<'py>> {
    let dimensions: Vec<usize> = batch.iter().chain(shape).copied().collect();
    let array = PyArrayDyn::<f64>::zeros(py, dimensions, false);
    let mut filled = array.try_readwrite()?;
    work(filled.as_slice_mut()?, shape.iter().product())?;
    drop(filled);
    Ok(array)
}
