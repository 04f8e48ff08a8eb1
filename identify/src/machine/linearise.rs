//! The equations of motion linearised at a state, in coordinates of the constraint manifold.
//!
//! The state `x = (q, v, z)` of a machine with constraints cannot move freely: holonomic
//! constraints hold positions and velocities, nonholonomic ones velocities. With `N_q` an
//! orthonormal basis of the null space of `∂c/∂q` (holonomic rows) and `N_v` one of that of `A`
//! (all rows), a small motion on the manifold is `δx = T ξ`,
//!
//! ```text
//!     ⎡N_q  0    0⎤            ⎡N_qᵀ  0     0⎤
//! T = ⎢K    N_v  0⎥ ,      L = ⎢0     N_vᵀ  0⎥ ,      K = −A⁺ (∂ċ/∂q) N_q ,
//!     ⎣0    0    I⎦            ⎣0     0     I⎦
//! ```
//!
//! and `ξ = L δx` are coordinates of the manifold: `L T = I`, and what the manifold's curvature
//! adds is in the kernel of `L` to first order. With `ẋ = f(x, u)`, `F = ∂f/∂x`, `G = ∂f/∂u`:
//! `ξ̇ = L f + L F T ξ + L G δu`, exact to first order at every state that fulfils the
//! constraints, at rest or moving.
//!
//! A body that floats by its twist has six displacements along that twist in `q`'s place.

use super::{Instruments, Machine, Motion, SensitivityTape, SolveError, States};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::model::ConstraintKind;
use dynamics_codegen::{Compiled, System, Tape};
use nalgebra::{DMatrix, DVector};

/// Singular values of the constraints below this share of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-10;

/// Entries of the exponential's argument up to which it has correct digits.
const LARGEST: f64 = 1e12;

/// A model ready to be linearised at many states.
#[derive(Debug, Clone)]
pub struct Lineariser {
    machine: Machine,
    accelerations: SensitivityTape,
    instruments: Instruments,
    /// Of `ċ`, `ż` and the outputs: the values, then per variable their derivatives.
    others: Tape,
    outputs: usize,
}

/// `ξ̇ = f₀ + A ξ + B δu`, `δy = C ξ + D δu` at one state. With `n` coordinates, `s` internal
/// states, `N = 2n + s`; of these `r` free; `k` inputs and `d` delayed ones; `p` outputs and sensors,
/// in this order:
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Linearisation {
    /// `T`, `N×r`: what `ξ` does to positions, velocities and internal states.
    pub basis: DMatrix<f64>,
    /// `L`, `r×N`, with `L T = I`: which `ξ` a deviation of the state is.
    pub chart: DMatrix<f64>,
    /// How many of the `r` are positions; velocities and internal states come behind them.
    pub positions: usize,
    /// `A`, `r×r`.
    pub a: DMatrix<f64>,
    /// `B`, `r×(k+d)`: the inputs, then the delayed ones.
    pub b: DMatrix<f64>,
    /// `C`, `p×r`.
    pub c: DMatrix<f64>,
    /// `D`, `p×(k+d)`.
    pub d: DMatrix<f64>,
    /// `f₀`, `r`: how `ξ` moves by itself; zero at a state of rest. Sampled, by how much in one
    /// interval.
    pub drift: DVector<f64>,
    /// The outputs and what the sensors show at the state, `p`.
    pub outputs: Vec<f64>,
}

/// Derivatives by `(q, v, z, u, delayed u)`, on all of the state's space.
struct Free {
    /// `f`, `N`.
    rate: DVector<f64>,
    /// `[F G]`, `N×(N+k+d)`.
    slope: DMatrix<f64>,
    /// `∂ċ/∂q`, `m×n`.
    closing: DMatrix<f64>,
    /// `[∂y/∂x ∂y/∂u]`, `p×(N+k+d)`.
    output: DMatrix<f64>,
    outputs: Vec<f64>,
}

impl Lineariser {
    /// Differentiates the equations of a model.
    pub fn new(compiled: Compiled) -> Self {
        let mut machine = Machine::new(compiled);
        let accelerations = machine.sensitivity(&variables(&machine));
        let by = variables(&machine);
        let instruments = machine.instruments(&by);
        let Compiled { model, system, .. } = &mut machine.compiled;
        let mut values = system.constraint_rate.clone();
        values.extend(&system.state_rates);
        values.extend(&system.outputs);
        let mut entries = values.clone();
        for variable in by {
            let displacement = variable.displacement(model);
            entries.extend(model.graph.directional(&values, &displacement));
        }
        Self {
            others: Tape::new(&model.graph, &entries, &System::arguments(model)),
            outputs: system.outputs.len(),
            accelerations,
            instruments,
            machine,
        }
    }

    /// The model that it was made from, as a machine.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The linearisation at one state, which fulfils the constraints
    /// ([`Machine::project`] sees to that). What is not said of the past is at rest:
    /// [`Machine::at_rest`].
    ///
    /// # Errors
    /// If the equation of motion has no unique solution there.
    ///
    /// # Panics
    /// If `state` does not hold exactly one sample.
    pub fn at(&self, state: &States, parameters: &[f64]) -> Result<Linearisation, SolveError> {
        assert_eq!(state.len(), 1, "one state at a time");
        let state = self.machine.at_rest(state, parameters);
        let motion = self.machine.motion(&state, parameters)?.remove(0);
        let free = self.free(&state, parameters, &motion);
        let finite = free
            .slope
            .iter()
            .chain(free.output.iter())
            .chain(free.closing.iter());
        if finite.chain(&free.outputs).any(|x| !x.is_finite()) {
            return Err(SolveError::NotFinite { sample: 0 });
        }
        Ok(self.projected(&motion, &free))
    }

    fn free(&self, state: &States, parameters: &[f64], motion: &Motion) -> Free {
        let (n, m) = (
            self.machine.coordinate_count(),
            self.machine.constraint_count(),
        );
        let (z, p) = (self.machine.state_count(), self.outputs);
        let values = self
            .others
            .evaluate_all(&state.columns(parameters), state.len());
        let values: Vec<f64> = values.iter().map(|column| column[0]).collect();
        let rows = m + z + p;
        let derivatives =
            DMatrix::from_column_slice(rows, self.accelerations.variable_count(), &values[rows..]);
        let motions = std::slice::from_ref(motion);
        let solved = self.accelerations.evaluate(state, parameters, motions);
        let sensed = self.instruments.slopes(state, motions, &solved, parameters);
        let read = self.instruments.read(state, motions, parameters);
        let (accelerations, _) = &solved[0];
        let velocities = state.v.iter().map(|column| column[0]);
        let rates = velocities
            .chain(motion.acceleration.iter().copied())
            .chain(values[m..m + z].iter().copied());
        let mut slope = DMatrix::zeros(2 * n + z, derivatives.ncols());
        slope.view_mut((0, n), (n, n)).fill_with_identity();
        self.carry_displacements(state, &mut slope);
        slope.rows_mut(n, n).copy_from(accelerations);
        slope.rows_mut(2 * n, z).copy_from(&derivatives.rows(m, z));
        Free {
            rate: DVector::from_iterator(2 * n + z, rates),
            slope,
            closing: derivatives.view((0, 0), (m, n)).into_owned(),
            output: stacked(&derivatives.rows(m + z, p).into_owned(), &sensed[0]),
            outputs: [
                &values[m + z..rows],
                &read.iter().map(|column| column[0]).collect::<Vec<f64>>(),
            ]
            .concat(),
        }
    }

    /// A displacement of a floating body, seen from the body, turns against the body's own twist
    /// `v, ω`: `δ̇ = δv − ω × δ − v × φ` and `φ̇ = δω − ω × φ`.
    fn carry_displacements(&self, state: &States, slope: &mut DMatrix<f64>) {
        for [_, first] in self.machine.compiled.model.pose_places() {
            let twist: Vec<f64> = (first..first + 6).map(|i| state.v[i][0]).collect();
            let mut cross = |row: usize, column: usize, of: &[f64]| {
                for i in 0..3 {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    slope[(first + row + i, first + column + k)] -= of[j];
                    slope[(first + row + i, first + column + j)] += of[k];
                }
            };
            cross(0, 0, &twist[3..]);
            cross(0, 3, &twist[..3]);
            cross(3, 3, &twist[3..]);
        }
    }

    fn projected(&self, motion: &Motion, free: &Free) -> Linearisation {
        let (n, z) = (self.machine.coordinate_count(), self.machine.state_count());
        let constraint = &motion.terms.constraint_matrix;
        let kinds = self.machine.constraint_kinds();
        let holonomic: Vec<usize> = (0..kinds.len())
            .filter(|&row| kinds[row] == ConstraintKind::Holonomic)
            .collect();
        let positions = null_space(&constraint.select_rows(&holonomic));
        let velocities = null_space(constraint);
        let following = -pseudo_inverse(constraint) * &free.closing * &positions;
        let (rq, rv) = (positions.ncols(), velocities.ncols());
        let (all, r) = (2 * n + z, rq + rv + z);
        let mut basis = DMatrix::zeros(all, r);
        basis.view_mut((0, 0), (n, rq)).copy_from(&positions);
        basis.view_mut((n, rq), (n, rv)).copy_from(&velocities);
        basis
            .view_mut((2 * n, rq + rv), (z, z))
            .fill_with_identity();
        let chart = basis.transpose();
        basis.view_mut((n, 0), (n, rq)).copy_from(&following);
        let (by_state, by_input) = (free.slope.columns(0, all), free.slope.columns_range(all..));
        Linearisation {
            a: &chart * by_state * &basis,
            b: &chart * by_input,
            c: free.output.columns(0, all) * &basis,
            d: free.output.columns_range(all..).into_owned(),
            drift: &chart * &free.rate,
            outputs: free.outputs.clone(),
            positions: rq,
            basis,
            chart,
        }
    }
}

/// One above the other.
fn stacked(above: &DMatrix<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
    let (upper, lower) = (above.nrows(), below.nrows());
    let mut both = DMatrix::zeros(upper + lower, above.ncols());
    both.rows_mut(0, upper).copy_from(above);
    both.rows_mut(upper, lower).copy_from(below);
    both
}

/// `q, v, z, u, delayed u`.
fn variables(machine: &Machine) -> Vec<Variable> {
    let model = &machine.compiled.model;
    let n = model.coordinates.len();
    let mut variables: Vec<Variable> = (0..n).map(Variable::Position).collect();
    variables.extend((0..n).map(Variable::Velocity));
    variables.extend((0..model.states.len()).map(Variable::State));
    variables.extend((0..model.inputs.len()).map(Variable::Input));
    variables.extend((0..model.delays.len()).map(Variable::Delayed));
    variables
}

/// An orthonormal basis of the null space of a matrix, one column each; the largest entry of a
/// column is positive.
fn null_space(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.ncols();
    if matrix.nrows() == 0 {
        return DMatrix::identity(n, n);
    }
    // Square or tall, so that all right singular vectors are there.
    let padded = scaled(matrix).resize_vertically(matrix.nrows().max(n), 0.0);
    let svd = padded.svd(false, true);
    let Some(right) = svd.v_t else {
        return DMatrix::zeros(n, 0);
    };
    let least = RANK_TOLERANCE * svd.singular_values.amax();
    let free: Vec<usize> = (0..n)
        .filter(|&row| svd.singular_values[row] <= least)
        .collect();
    let mut basis = right.select_rows(&free).transpose();
    for mut column in basis.column_iter_mut() {
        if column[column.icamax()] < 0.0 {
            column.neg_mut();
        }
    }
    basis
}

fn pseudo_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let (rows, columns) = matrix.shape();
    if rows == 0 {
        return DMatrix::zeros(columns, 0);
    }
    let svd = scaled(matrix).svd(true, true);
    let least = RANK_TOLERANCE * svd.singular_values.amax();
    svd.pseudo_inverse(least)
        .unwrap_or_else(|_| DMatrix::zeros(columns, rows))
        / size(matrix)
}

/// With entries up to one: those of products do not overflow then, and iterations end.
fn scaled(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    matrix / size(matrix)
}

/// The largest entry; one if all are zero.
fn size(matrix: &DMatrix<f64>) -> f64 {
    match matrix.amax() {
        0.0 => 1.0,
        largest => largest,
    }
}

impl Linearisation {
    /// From one sample to the next, `hold` seconds later, with inputs held in between:
    /// `ξ₊ = f₀ + A ξ + B δu` from the exponential of `[[A, B, f₀], [0, 0, 0]]·hold`. Outputs are
    /// those at the sample. `None` where the exponential is not finite, or where its argument is
    /// so large that nothing of it would be right.
    #[must_use]
    pub fn sampled(&self, hold: f64) -> Option<Self> {
        let (r, k) = self.b.shape();
        let mut augmented = DMatrix::zeros(r + k + 1, r + k + 1);
        augmented.view_mut((0, 0), (r, r)).copy_from(&self.a);
        augmented.view_mut((0, r), (r, k)).copy_from(&self.b);
        augmented
            .view_mut((0, r + k), (r, 1))
            .copy_from(&self.drift);
        let argument = augmented * hold;
        if argument.iter().any(|x| x.abs() > LARGEST || x.is_nan()) {
            return None;
        }
        let moved = argument.exp();
        moved.iter().all(|x| x.is_finite()).then(|| Self {
            a: moved.view((0, 0), (r, r)).into_owned(),
            b: moved.view((0, r), (r, k)).into_owned(),
            drift: moved.view((0, r + k), (r, 1)).column(0).into_owned(),
            ..self.clone()
        })
    }
}
