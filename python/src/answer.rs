//! How a model answers: a tape, or the motion, at every state of a call.

use crate::batch;
use crate::error::{Error, unsolved};
use crate::free::solve;
use crate::machine_code::MachineCode;
use crate::model::Model;
use crate::place::{Array, Place, fill};
use crate::terms::{Given, Ready, Wanted};
use dynamics_codegen::derive::Term;
use identify::machine::{Motion, SolveError};
use pyo3::prelude::*;
use std::ops::Range;

/// States whose equations of motion stay in a core's nearest cache until they are solved.
const NEAR: usize = 64;

impl Model {
    /// A term at every state.
    pub fn term<'py>(
        &self,
        term: Term,
        place: &Place<'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        self.tape(Wanted::Term(term), place, parallel)
    }

    /// A frame by its name.
    pub fn frame(&self, name: &str) -> PyResult<usize> {
        let frames = self.equations.loaded.compiled.model.frames();
        frames.get(name).copied().ok_or_else(|| {
            let known: Vec<&str> = frames.into_keys().collect();
            let known = known.join(", ");
            Error::new_err(format!("the model has no frame `{name}`; it has: {known}"))
        })
    }

    /// A tape at every state.
    pub fn tape<'py>(
        &self,
        wanted: Wanted,
        place: &Place<'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let ready = self.equations.tape(wanted).map_err(Error::new_err)?;
        let given = place.given(&self.values);
        let py = place.q.py();
        fill(py, &place.batch, &ready.shape, |out, width| {
            let work = |range: Range<usize>, rows: &mut [f64]| {
                let code = self.code.as_deref();
                self.equations.evaluate(&ready, code, &given, range, rows);
                Ok::<(), PyErr>(())
            };
            batch::run(py, out, width, parallel, work, |error| error)
        })
    }

    /// Accelerations where there is neither constraint nor contact.
    pub fn free<'py>(&self, place: &Place<'py>, parallel: bool) -> PyResult<Array<'py>> {
        let tape = |term| self.equations.tape(Wanted::Term(term));
        let mass = tape(Term::MassMatrix).map_err(Error::new_err)?;
        let force = tape(Term::Force).map_err(Error::new_err)?;
        let given = place.given(&self.values);
        let n = self.equations.coordinates.len();
        fill(place.q.py(), &place.batch, &[n], |out, width| {
            let work = |range: Range<usize>, rows: &mut [f64]| {
                let is_solved = match self.code.as_deref() {
                    Some(code) => solved_by(code, &given, &range, rows, n),
                    None => self.solved([&mass, &force], &given, &range, rows, n),
                };
                match is_solved {
                    true => Ok(()),
                    false => self.move_each(&given, range, rows, n, &accelerations),
                }
            };
            batch::run(place.q.py(), out, width, parallel, work, unsolved)
        })
    }

    /// Puts `M⁻¹ Q` of the tapes of `M` and `Q` into rows; says whether it could at all states.
    fn solved(
        &self,
        [mass, force]: [&Ready; 2],
        given: &Given<'_>,
        range: &Range<usize>,
        rows: &mut [f64],
        n: usize,
    ) -> bool {
        let mut masses = vec![0.0; range.len() * n * n];
        (self.equations).evaluate(mass, None, given, range.clone(), &mut masses);
        (self.equations).evaluate(force, None, given, range.clone(), rows);
        solve(n, masses.chunks(n * n).zip(rows.chunks_mut(n)))
    }

    /// Fills rows with what motions say, `width` numbers each.
    fn move_each(
        &self,
        given: &Given<'_>,
        range: Range<usize>,
        rows: &mut [f64],
        width: usize,
        row: &impl Fn(&Motion, &mut [f64]),
    ) -> Result<(), SolveError> {
        let states = self.equations.states(given, &range);
        let motions = self.equations.machine().motion(&states, &self.values);
        let motions = motions.map_err(|error| error.offset(range.start))?;
        for (motion, out) in motions.iter().zip(rows.chunks_mut(width)) {
            row(motion, out);
        }
        Ok(())
    }

    /// What a motion says at every state, `width` numbers each.
    pub fn motion<'py>(
        &self,
        py: Python<'py>,
        place: &Place<'py>,
        parallel: bool,
        width: usize,
        row: impl Fn(&Motion, &mut [f64]) + Sync,
    ) -> PyResult<Array<'py>> {
        let given = place.given(&self.values);
        fill(py, &place.batch, &[width], |out, width| {
            let work = |range: Range<usize>, rows: &mut [f64]| {
                self.move_each(&given, range, rows, width, &row)
            };
            batch::run(py, out, width, parallel, work, unsolved)
        })
    }
}

/// Accelerations of a motion.
pub fn accelerations(motion: &Motion, row: &mut [f64]) {
    row.copy_from_slice(motion.acceleration.as_slice());
}

/// Puts `M⁻¹ Q` of machine code into rows; says whether it could at all states.
fn solved_by(
    code: &MachineCode,
    given: &Given<'_>,
    range: &Range<usize>,
    rows: &mut [f64],
    n: usize,
) -> bool {
    let both = n * n + n;
    let mut equations = vec![0.0; NEAR.min(range.len()) * both];
    rows.chunks_mut(NEAR * n).enumerate().all(|(k, rows)| {
        let (first, count) = (range.start + k * NEAR, rows.len() / n);
        let equations = &mut equations[..count * both];
        let is_there = code.equation_of_motion(given, &(first..first + count), equations);
        let states = equations.chunks(both).zip(rows.chunks_mut(n));
        is_there
            && solve(
                n,
                states.map(|(equation, row)| {
                    let (mass, force) = equation.split_at(n * n);
                    row.copy_from_slice(force);
                    (mass, row)
                }),
            )
    })
}
