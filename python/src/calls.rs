//! `Model`: what is computed at states that Python has.

use crate::answer::accelerations;
use crate::derivatives::Derivatives;
use crate::model::Model;
use crate::place::{Any, Array, Place};
use crate::simulate::{Simulation, Wish};
use crate::terms::Wanted;
use dynamics_codegen::derive::Term;
use pyo3::prelude::*;

#[pymethods]
impl Model {
    /// The generalised inertia M(q).
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     M, shape (…, n, n), symmetric; SI units.
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, *, t=None, parallel=false))]
    fn mass_matrix<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        self.term(
            Term::MassMatrix,
            &Place::read(&self.equations, q, [None; 4], t)?,
            parallel,
        )
    }

    /// Fictitious and conservative forces Q_C(q, v), on the right-hand side of M a = Q.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     Q_C, shape (…, n), N for lengths and N·m for angles.
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, *, t=None, parallel=false))]
    fn bias_force<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, None, None, None], t)?;
        self.term(Term::BiasForce, &place, parallel)
    }

    /// What the model states of forces beside the conservative ones, at zero input: Q_D(q, v).
    ///
    /// Forces that depend on a multiplier, as friction in a contact, are those at none.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     z: internal states, shape (…, s); as at the beginning if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     Q_D, shape (…, n), N or N·m.
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, *, z=None, t=None, parallel=false))]
    fn applied_force<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        z: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, None, None, z], t)?;
        self.term(Term::AppliedForce, &place, parallel)
    }

    /// How inputs act: B = ∂Q/∂u, the delayed inputs behind the others.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     z: internal states, shape (…, s); as at the beginning if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     B, shape (…, n, k + d) with d delayed inputs.
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, *, z=None, t=None, parallel=false))]
    fn input_matrix<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        z: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, None, None, z], t)?;
        self.term(Term::InputMatrix, &place, parallel)
    }

    /// The force that inputs and constraints must supply: τ = M a − Q_C − Q_D.
    ///
    /// Forces that depend on a multiplier, as friction in a contact, are those at none.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n).
    ///     a: accelerations, shape (…, n).
    ///     z: internal states, shape (…, s); as at the beginning if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     τ, shape (…, n), N or N·m.
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v, a, *, z=None, t=None, parallel=false))]
    fn inverse_dynamics<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        a: Any<'_, 'py>,
        z: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, None, a, z], t)?;
        self.term(Term::InverseDynamics, &place, parallel)
    }

    /// The constraints on acceleration level, A a = b: A(q, v).
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     A, shape (…, m, n); m is 0 if there is no constraint.
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, *, t=None, parallel=false))]
    fn constraint_jacobian<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, None, None, None], t)?;
        self.term(Term::ConstraintJacobian, &place, parallel)
    }

    /// The constraints on acceleration level, A a = b: b(q, v).
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     b, shape (…, m).
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, *, t=None, parallel=false))]
    fn constraint_bias<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, None, None, None], t)?;
        self.term(Term::ConstraintBias, &place, parallel)
    }

    /// What the constraints demand to be zero, c(q) or c(q, v).
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     c, shape (…, m).
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, *, t=None, parallel=false))]
    fn constraint_residual<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, None, None, None], t)?;
        self.term(Term::ConstraintResidual, &place, parallel)
    }

    /// The rate of what holonomic constraints demand to be zero; c itself of the others.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     ċ, shape (…, m).
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, *, t=None, parallel=false))]
    fn constraint_rate<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, None, None, None], t)?;
        self.term(Term::ConstraintRate, &place, parallel)
    }

    /// Rates of the internal states, dz/dt.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     u: inputs, shape (…, k), in the inputs' units; zero if left out.
    ///     z: internal states, shape (…, s); as at the beginning if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     dz/dt, shape (…, s).
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, u=None, *, z=None, t=None, parallel=false))]
    fn state_rates<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        u: Any<'_, 'py>,
        z: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, u, None, z], t)?;
        self.term(Term::StateRate, &place, parallel)
    }

    /// The model's named outputs.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     u: inputs, shape (…, k), in the inputs' units; zero if left out.
    ///     z: internal states, shape (…, s); as at the beginning if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     Values, shape (…, number of outputs), in the order of `output_names`.
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (q, v=None, u=None, *, z=None, t=None, parallel=false))]
    fn outputs<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        u: Any<'_, 'py>,
        z: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, u, None, z], t)?;
        self.term(Term::Outputs, &place, parallel)
    }

    /// The accelerations a of M a = Q + Aᵀλ, A a = b.
    ///
    /// Inputs have always been what they are, for what depends on them late.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     u: inputs, shape (…, k), in the inputs' units; zero if left out.
    ///     z: internal states, shape (…, s); as at the beginning if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     a, shape (…, n), m/s² or rad/s².
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    ///     dynamics.SolveError: if a state has no unique motion; says which.
    #[pyo3(signature = (q, v=None, u=None, *, z=None, t=None, parallel=false))]
    fn forward_dynamics<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        u: Any<'_, 'py>,
        z: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, u, None, z], t)?;
        if self.equations.is_free() {
            return self.free(&place, parallel);
        }
        let width = self.equations.coordinates.len();
        self.motion(q.py(), &place, parallel, width, accelerations)
    }

    /// The multipliers λ of M a = Q + Aᵀλ, A a = b: what the constraints push with.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     u: inputs, shape (…, k), in the inputs' units; zero if left out.
    ///     z: internal states, shape (…, s); as at the beginning if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     λ, shape (…, m).
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    ///     dynamics.SolveError: if a state has no unique motion; says which.
    #[pyo3(signature = (q, v=None, u=None, *, z=None, t=None, parallel=false))]
    fn multipliers<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        u: Any<'_, 'py>,
        z: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [v, u, None, z], t)?;
        let width = self.equations.loaded.compiled.model.constraints.len();
        self.motion(q.py(), &place, parallel, width, |motion, row| {
            row.copy_from_slice(motion.multiplier.as_slice());
        })
    }

    /// Where a frame or a body is, seen from the world.
    ///
    /// Args:
    ///     frame: its name, one of `frames`; of a robot description, that of a link.
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     Homogeneous transforms, shape (…, 4, 4): the rotation, and in the last column the
    ///     position of the origin, m.
    ///
    /// Raises:
    ///     dynamics.Error: if there is no such frame, a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (frame, q, *, t=None, parallel=false))]
    fn frame_pose<'py>(
        &self,
        frame: &str,
        q: &Bound<'py, PyAny>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [None; 4], t)?;
        self.tape(Wanted::Pose(self.frame(frame)?), &place, parallel)
    }

    /// How a frame or a body moves: J of `(velocity, angular velocity) = J v`, along the world's axes.
    ///
    /// Args:
    ///     frame: its name, one of `frames`; of a robot description, that of a link.
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     J, shape (…, 6, n): rows 0–2 of the velocity of the origin, rows 3–5 of the angular velocity.
    ///
    /// Raises:
    ///     dynamics.Error: if there is no such frame, a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (frame, q, *, t=None, parallel=false))]
    fn frame_jacobian<'py>(
        &self,
        frame: &str,
        q: &Bound<'py, PyAny>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Array<'py>> {
        let place = Place::read(&self.equations, q, [None; 4], t)?;
        self.tape(Wanted::Jacobian(self.frame(frame)?), &place, parallel)
    }

    /// Derivatives of accelerations and multipliers by `q`, `v`, `u`, the parameters and `t`.
    ///
    /// Args:
    ///     q: positions, shape (…, n), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (…, n); zero if left out.
    ///     u: inputs, shape (…, k), in the inputs' units; zero if left out.
    ///     z: internal states, shape (…, s); as at the beginning if left out.
    ///     t: time, shape () or (…), s; 0 if left out.
    ///     parallel: whether to use all cores.
    ///
    /// Returns:
    ///     Matrices `a_q`, `a_v`, …, `lambda_q`, …
    ///
    /// Raises:
    ///     dynamics.Error: if a shape does not fit or a number is not finite.
    ///     TypeError: if an argument does not hold real numbers.
    ///     dynamics.SolveError: if a state has no unique motion; says which.
    #[pyo3(signature = (q, v=None, u=None, *, z=None, t=None, parallel=false))]
    fn derivatives<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        u: Any<'_, 'py>,
        z: Any<'_, 'py>,
        t: Any<'_, 'py>,
        parallel: bool,
    ) -> PyResult<Derivatives> {
        let place = Place::read(&self.equations, q, [v, u, None, z], t)?;
        Derivatives::at(self, &place, parallel)
    }

    /// Open-loop motion from a state on, as `dynamics simulate` has it.
    ///
    /// A state that is off the constraints is moved onto them. Ctrl-C ends it.
    ///
    /// Args:
    ///     q: positions to begin with, shape (n,), in the coordinates' units, in the order of `positions`.
    ///     v: velocities, shape (n,); zero if left out.
    ///     u: inputs: shape (k,), the same at all times; or shape (rows, k), linear between the
    ///         `input_times` and held before and after; zero if left out.
    ///     duration: how long, s.
    ///     input_times: when the rows of `u` are, shape (rows,), s, increasing.
    ///     rate: rows per second of the answer.
    ///     max_step: the largest step of the integration, s.
    ///     z: internal states, shape (s,); as at the beginning if left out.
    ///     t: when it begins, s.
    ///
    /// Returns:
    ///     The motion, rows at `t`, `t + 1/rate`, …
    ///
    /// Raises:
    ///     dynamics.Error: if an argument does not fit, or the motion cannot go on; says when.
    ///     TypeError: if an argument does not hold real numbers.
    #[pyo3(signature = (
        q, v=None, u=None, *, duration, input_times=None, rate=100.0, max_step=0.00025, z=None, t=0.0
    ))]
    #[allow(clippy::too_many_arguments)]
    fn simulate<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: Any<'_, 'py>,
        u: Any<'_, 'py>,
        duration: f64,
        input_times: Any<'_, 'py>,
        rate: f64,
        max_step: f64,
        z: Any<'_, 'py>,
        t: f64,
    ) -> PyResult<Simulation> {
        let wish = Wish {
            q,
            v,
            u,
            z,
            input_times,
            start: t,
            duration,
            rate,
            max_step,
        };
        wish.run(q.py(), self)
    }
}
