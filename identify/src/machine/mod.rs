//! A model that is known only now: its equations on tapes, solved for
//! accelerations and multipliers at many states at once.

mod closure;
mod contact;
mod exponential;
mod hold;
mod instruments;
mod linearise;
mod measured;
mod memory;
mod positions;
mod rollout;
mod sensitivity;
mod shifted;
mod solve;
mod states;
mod trail;
mod unilateral;

pub use hold::{Hold, Signal};
pub use instruments::Instruments;
pub use linearise::{Linearisation, Lineariser};
pub use measured::{Measured, Sensors};
pub use rollout::{Rollout, RolloutOptions, Simulated};
pub use sensitivity::SensitivityTape;
pub(crate) use shifted::shifted;
pub use solve::{Factorisation, SolveError};
pub use states::{Begun, History, States};
pub use trail::{Memory, Trail};
pub use unilateral::{ContactTerms, Impact, Pressed, Stepping, SteppingOptions};

use dynamics_codegen::model::ConstraintKind;
use dynamics_codegen::{Column, Compiled, System, Tape};
use nalgebra::{DMatrix, DVector};

/// A model ready to be evaluated.
#[derive(Debug, Clone)]
pub struct Machine {
    /// The model it was made from.
    pub compiled: Compiled,
    terms: Tape,
    memory: Option<memory::Tapes>,
    contacts: Option<Tape>,
    poses: Option<positions::Poses>,
    coordinates: usize,
    constraints: usize,
    inputs: usize,
}

/// The terms of `M a = Q + Aᵀλ`, `A a = b` at one state. With `n` coordinates,
/// `m` constraints, `k` inputs:
#[derive(Debug, Clone)]
pub struct Terms {
    /// `M`, `n×n`.
    pub mass_matrix: DMatrix<f64>,
    /// `Q_C`, `n`.
    pub bias_force: DVector<f64>,
    /// `Q_D`, `n`.
    pub applied_force: DVector<f64>,
    /// `B`, `n×(k+d)`: the inputs, then the delayed ones.
    pub input_matrix: DMatrix<f64>,
    /// `Q`, `n`; of a [`Motion`], at its multipliers; of [`Machine::terms`], at none.
    pub force: DVector<f64>,
    /// `∂Q/∂λ`, `n×m`; `n×0` where no force depends on a multiplier.
    pub multiplier_slope: DMatrix<f64>,
    /// `A`, `m×n`.
    pub constraint_matrix: DMatrix<f64>,
    /// `b`, `m`.
    pub constraint_bias: DVector<f64>,
    /// `c`, `m`.
    pub constraint_residual: DVector<f64>,
    /// `ċ`, `m` (`c` for nonholonomic rows).
    pub constraint_rate: DVector<f64>,
}

/// The motion that the model demands at one state.
#[derive(Debug, Clone)]
pub struct Motion {
    /// The terms it follows from.
    pub terms: Terms,
    /// The factorisation that gave it, for further right-hand sides.
    pub factorisation: Factorisation,
    /// Accelerations `a`, `n`.
    pub acceleration: DVector<f64>,
    /// Multipliers `λ`, `m`.
    pub multiplier: DVector<f64>,
}

impl Machine {
    /// Puts a compiled model's equations on a tape.
    pub fn new(mut compiled: Compiled) -> Self {
        let memory = memory::Tapes::new(&mut compiled);
        let contacts = unilateral::tape(&compiled);
        let poses = positions::Poses::of(&mut compiled.model);
        let System {
            mass_matrix,
            bias_force,
            applied_force,
            input_matrix,
            force,
            constraint_matrix,
            constraint_bias,
            constraint_residual,
            constraint_rate,
            multiplier_slope,
            ..
        } = &compiled.system;
        let mut outputs = Vec::new();
        outputs.extend(mass_matrix.iter().flatten());
        outputs.extend(bias_force);
        outputs.extend(applied_force);
        outputs.extend(input_matrix.iter().flatten());
        outputs.extend(force);
        outputs.extend(constraint_matrix.iter().flatten());
        outputs.extend(constraint_bias);
        outputs.extend(constraint_residual);
        outputs.extend(constraint_rate);
        outputs.extend(multiplier_slope.iter().flatten());
        let arguments = compiled.system.arguments_of_forces(&compiled.model);
        let terms = Tape::new(&compiled.model.graph, &outputs, &arguments);
        let coordinates = compiled.model.coordinates.len();
        let constraints = compiled.model.constraints.len();
        let inputs = compiled.model.inputs.len();
        Self {
            compiled,
            terms,
            memory,
            contacts,
            poses,
            coordinates,
            constraints,
            inputs,
        }
    }

    /// Number of coordinates `n`.
    pub fn coordinate_count(&self) -> usize {
        self.coordinates
    }

    /// Number of constraints `m`.
    pub fn constraint_count(&self) -> usize {
        self.constraints
    }

    /// Number of inputs `k`.
    pub fn input_count(&self) -> usize {
        self.inputs
    }

    /// The parameters' nominal values.
    pub fn nominal_parameters(&self) -> Vec<f64> {
        self.compiled.model.nominal_parameters()
    }

    /// What arrives of an input (by index) at every state.
    pub fn arriving(&self, input: usize, states: &States, parameters: &[f64]) -> Vec<f64> {
        let model = &self.compiled.model;
        let arrives = [model.inputs[input].arrives];
        let tape = Tape::new(&model.graph, &arrives, &System::arguments(model));
        let states = self.at_rest(states, parameters);
        let mut values = tape.evaluate_all(&states.columns(parameters), states.len());
        values.swap_remove(0)
    }

    /// The equation's terms at every state.
    pub fn terms(&self, states: &States, parameters: &[f64]) -> Vec<Terms> {
        let nothing = vec![vec![0.0; states.len()]; self.constraints];
        self.terms_at(states, parameters, &nothing)
    }

    /// The equation's terms where multipliers, one column each, act on the forces.
    fn terms_at(
        &self,
        states: &States,
        parameters: &[f64],
        multipliers: &[Vec<f64>],
    ) -> Vec<Terms> {
        let completed = self.completed(states, parameters);
        let states = completed.as_ref().unwrap_or(states);
        let mut columns = states.columns(parameters);
        if self.has_contact() {
            columns.extend(multipliers.iter().map(|column| Column::Each(column)));
        }
        let values = self.terms.evaluate_all(&columns, states.len());
        (0..states.len())
            .map(|sample| self.unpack(&values, sample))
            .collect()
    }

    fn unpack(&self, values: &[Vec<f64>], sample: usize) -> Terms {
        let (n, m) = (self.coordinates, self.constraints);
        let k = self.inputs + self.compiled.model.delays.len();
        let l = if self.has_contact() { m } else { 0 };
        let next = &mut values.iter().map(|column| column[sample]);
        Terms {
            mass_matrix: matrix(next, n, n),
            bias_force: vector(next, n),
            applied_force: vector(next, n),
            input_matrix: matrix(next, n, k),
            force: vector(next, n),
            constraint_matrix: matrix(next, m, n),
            constraint_bias: vector(next, m),
            constraint_residual: vector(next, m),
            constraint_rate: vector(next, m),
            multiplier_slope: matrix(next, n, l),
        }
    }

    /// Accelerations and multipliers at every state [3.38–3.43].
    ///
    /// Where forces depend on multipliers, by Newton's method on the multipliers.
    ///
    /// # Errors
    /// If the equation has no unique solution at one of the states.
    pub fn motion(&self, states: &States, parameters: &[f64]) -> Result<Vec<Motion>, SolveError> {
        self.motion_with(states, parameters, |_, _| ())
    }

    /// Which rows of the constraint are differentiated twice.
    pub fn constraint_kinds(&self) -> &[ConstraintKind] {
        &self.compiled.system.constraint_kinds
    }
}

/// The next numbers, row by row.
fn matrix(next: &mut impl Iterator<Item = f64>, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_row_iterator(rows, columns, next.take(rows * columns))
}

fn vector(next: &mut impl Iterator<Item = f64>, rows: usize) -> DVector<f64> {
    DVector::from_iterator(rows, next.take(rows))
}

impl Motion {
    /// Where forces depend on multipliers: linearised at `known`.
    pub(crate) fn of(terms: Terms, known: &[f64], sample: usize) -> Result<Self, SolveError> {
        let factorisation = Factorisation::new(&terms, sample)?;
        let mut force = DMatrix::from_column_slice(terms.force.len(), 1, terms.force.as_slice());
        if terms.multiplier_slope.ncols() > 0 {
            force -= &terms.multiplier_slope * DVector::from_column_slice(known);
        }
        let bias = DMatrix::from_column_slice(
            terms.constraint_bias.len(),
            1,
            terms.constraint_bias.as_slice(),
        );
        let (acceleration, multiplier) = factorisation.solve(force, &bias);
        let motion = Self {
            acceleration: acceleration.column(0).into_owned(),
            multiplier: multiplier.column(0).into_owned(),
            factorisation,
            terms,
        };
        motion.check(sample)
    }

    /// `b ∈ R(A)`, and everything is a number.
    fn check(self, sample: usize) -> Result<Self, SolveError> {
        if self
            .acceleration
            .iter()
            .chain(self.multiplier.iter())
            .any(|x| !x.is_finite())
        {
            return Err(SolveError::NotFinite { sample });
        }
        let demanded = &self.terms.constraint_matrix * &self.acceleration;
        let scale = 1.0 + demanded.amax().max(self.terms.constraint_bias.amax());
        let miss = (demanded - &self.terms.constraint_bias).amax();
        if miss > 1e-6 * scale {
            Err(SolveError::Inconsistent { sample, miss })
        } else {
            Ok(self)
        }
    }
}
