//! What quantities are, in words.

use crate::derive::{Group, Term};

/// What is differentiated by.
pub(super) fn variables(group: Group) -> &'static str {
    match group {
        Group::Position => "the positions `q`",
        Group::Velocity => "the velocities `v`",
        Group::Input => "the inputs `u`",
        Group::Parameters => "the parameters",
        Group::Time => "time `t`",
    }
}

/// What a term is, and how temporaries that hold an entry are called.
pub(super) fn describe(term: Term) -> (&'static str, &'static str) {
    match term {
        Term::MassMatrix => ("Generalised inertia `M(q)`, symmetric", "m"),
        Term::BiasForce => (
            "Bias force `Q_C`: fictitious and conservative forces, on the right-hand side",
            "bias",
        ),
        Term::AppliedForce => (
            "Stated and dissipative forces `Q_D` at zero input",
            "applied",
        ),
        Term::InputMatrix => ("Input matrix `B = ∂Q/∂u`", "b"),
        Term::Force => ("Total generalised force `Q = Q_C + Q_D + Q_u`", "force"),
        Term::ConstraintJacobian => ("Constraint matrix `A` of `A a = b`", "a"),
        Term::ConstraintBias => (
            "Right-hand side `b` of `A a = b`, without stabilisation",
            "b",
        ),
        Term::ConstraintResidual => (
            "Constraint violation `c`, zero where the constraint holds",
            "c",
        ),
        Term::ConstraintRate => (
            "Rate `ċ` of a holonomic constraint; `c` itself of a nonholonomic one",
            "c_dot",
        ),
        Term::ContactGap => ("Distances of the contacts from their planes", "gap"),
        Term::ContactVelocity => (
            "Contact velocities `w`: along the plane's axes, then its normal",
            "slip",
        ),
        Term::ContactJacobian => ("Contact Jacobian `J = ∂w/∂v`", "j"),
        Term::ContactBias => (
            "`b` of the contact accelerations `ẇ = J a − b`",
            "contact_b",
        ),
        Term::ContactCoefficients => (
            "Coefficients of friction and restitution of the contacts",
            "coefficient",
        ),
        Term::PositionRate => ("Rates `dq/dt` of the positions", "q_rate"),
        Term::StateRate => ("Rates `dz/dt` of the internal states", "z_rate"),
        Term::InitialState => ("Values of the internal states at the beginning", "z_start"),
        Term::Outputs => ("Values of the model's outputs", "out"),
        Term::OutputRates => (
            "Rates of the outputs along the motion, without the acceleration's part",
            "out_rate",
        ),
        Term::OutputJacobian => (
            "Jacobian `J = ∂y/∂q` of the outputs that depend on positions alone",
            "jacobian",
        ),
        Term::OutputBias => (
            "`J̇ v` of the outputs that depend on positions alone: `ÿ = J a + J̇ v`",
            "out_bias",
        ),
        Term::InverseDynamics => (
            "Inverse dynamics `τ = M a − Q_C − Q_D`: what inputs and constraints must supply for the stated acceleration `a`",
            "tau",
        ),
        Term::ForwardDynamics => (
            "Forward dynamics `a = M⁻¹ Q`, as if there were no constraint; `M` must be positive definite",
            "acceleration",
        ),
        Term::ConstrainedAcceleration => (
            "Acceleration `a` of `M a = Q + Aᵀλ`, `A a = b`; `M` must be positive definite and `A` of full row rank",
            "acceleration",
        ),
        Term::ConstrainedMultipliers => (
            "Multipliers `λ` of `M a = Q + Aᵀλ`, `A a = b`; `M` must be positive definite and `A` of full row rank",
            "multiplier",
        ),
        Term::ForceResidual => (
            "Residual `R = M a − Q − Aᵀλ` at the stated `a` and `λ`",
            "residual",
        ),
        Term::AccelerationResidual => ("Residual `S = A a − b` at the stated `a`", "residual"),
        Term::Sensors => (
            "What the sensors show at the stated `a` and `λ`, without noise",
            "sensor",
        ),
        Term::PredictedSensors => (
            "What the sensors show, without noise, along the motion of `M a = Q + Aᵀλ`, `A a = b`; `M` must be positive definite and `A` of full row rank",
            "sensor",
        ),
    }
}
