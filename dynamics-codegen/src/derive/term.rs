//! What a function can compute: the terms of the equations, what follows from them,
//! and the first derivatives of either.

use std::fmt;

/// A vector or matrix that a function can compute, with `n` coordinates, `m`
/// constraint rows and `k` inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Term {
    /// `M(q)`, `n×n`.
    MassMatrix,
    /// `Q_C`, `n`.
    BiasForce,
    /// `Q_D` at zero input, `n`.
    AppliedForce,
    /// `B = ∂Q/∂u`, `n×k`.
    InputMatrix,
    /// `Q = Q_C + Q_D + Q_u`, `n`.
    Force,
    /// `A`, `m×n`.
    ConstraintJacobian,
    /// `b`, `m`.
    ConstraintBias,
    /// `c`, `m`.
    ConstraintResidual,
    /// `ċ`, `m`.
    ConstraintRate,
    /// Gaps of the contacts, `c`.
    ContactGap,
    /// Velocities `w` of the contacts along their planes' axes and normals, `3c`.
    ContactVelocity,
    /// `J = ∂w/∂v`, `3c×n`.
    ContactJacobian,
    /// `b` of `ẇ = J a − b`, `3c`.
    ContactBias,
    /// Coefficients of friction and restitution, `c×2`.
    ContactCoefficients,
    /// Rates `dq/dt` of the positions, where bodies float by their twists: there is one more
    /// of these for each.
    PositionRate,
    /// Rates `dz/dt` of the internal states.
    StateRate,
    /// Values of the internal states at the beginning.
    InitialState,
    /// The model's outputs.
    Outputs,
    /// Their rates along the motion, without the acceleration's part.
    OutputRates,
    /// `J = ∂y/∂q` of the outputs that depend on positions and time alone.
    OutputJacobian,
    /// `J̇ v` of these: `ÿ = J a + J̇ v`.
    OutputBias,
    /// `τ(q, v, a, t) = M a − Q_C − Q_D`, `n`: what inputs and constraints must supply.
    InverseDynamics,
    /// `a = M⁻¹ Q`, `n`, as if there were no constraint; `M` positive definite.
    ForwardDynamics,
    /// `a` of `M a = Q + Aᵀλ`, `A a = b`, `n`; `M` positive definite, `A` of full rank.
    ConstrainedAcceleration,
    /// `λ` of the same, `m`.
    ConstrainedMultipliers,
    /// `R(q, v, u, a, λ, t) = M a − Q − Aᵀλ`, `n`: zero on the motion.
    ForceResidual,
    /// `S(q, v, a, t) = A a − b`, `m`: zero on the motion.
    AccelerationResidual,
    /// What sensors show at stated `a` and `λ`, without noise.
    Sensors,
    /// What sensors show along the motion of `M a = Q + Aᵀλ`, `A a = b`; its derivatives go
    /// through `a` and `λ`.
    PredictedSensors,
}

impl Term {
    /// All of them.
    pub const ALL: [Self; 29] = [
        Self::MassMatrix,
        Self::BiasForce,
        Self::AppliedForce,
        Self::InputMatrix,
        Self::Force,
        Self::ConstraintJacobian,
        Self::ConstraintBias,
        Self::ConstraintResidual,
        Self::ConstraintRate,
        Self::ContactGap,
        Self::ContactVelocity,
        Self::ContactJacobian,
        Self::ContactBias,
        Self::ContactCoefficients,
        Self::PositionRate,
        Self::StateRate,
        Self::InitialState,
        Self::Outputs,
        Self::OutputRates,
        Self::OutputJacobian,
        Self::OutputBias,
        Self::InverseDynamics,
        Self::ForwardDynamics,
        Self::ConstrainedAcceleration,
        Self::ConstrainedMultipliers,
        Self::ForceResidual,
        Self::AccelerationResidual,
        Self::Sensors,
        Self::PredictedSensors,
    ];

    /// The name of the function that computes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::MassMatrix => "mass_matrix",
            Self::BiasForce => "bias_force",
            Self::AppliedForce => "applied_force",
            Self::InputMatrix => "input_matrix",
            Self::Force => "force",
            Self::ConstraintJacobian => "constraint_jacobian",
            Self::ConstraintBias => "constraint_bias",
            Self::ConstraintResidual => "constraint_residual",
            Self::ConstraintRate => "constraint_rate",
            Self::ContactGap => "contact_gap",
            Self::ContactVelocity => "contact_velocity",
            Self::ContactJacobian => "contact_jacobian",
            Self::ContactBias => "contact_bias",
            Self::ContactCoefficients => "contact_coefficients",
            Self::PositionRate => "position_rate",
            Self::StateRate => "state_rate",
            Self::InitialState => "initial_state",
            Self::Outputs => "outputs",
            Self::OutputRates => "output_rates",
            Self::OutputJacobian => "output_jacobian",
            Self::OutputBias => "output_bias",
            Self::InverseDynamics => "inverse_dynamics",
            Self::ForwardDynamics => "forward_dynamics",
            Self::ConstrainedAcceleration => "constrained_acceleration",
            Self::ConstrainedMultipliers => "constrained_multipliers",
            Self::ForceResidual => "force_residual",
            Self::AccelerationResidual => "acceleration_residual",
            Self::Sensors => "sensors",
            Self::PredictedSensors => "predicted_sensors",
        }
    }

    /// Whether it is a function of an acceleration that the caller states.
    pub fn takes_acceleration(self) -> bool {
        matches!(
            self,
            Self::InverseDynamics
                | Self::ForceResidual
                | Self::AccelerationResidual
                | Self::Sensors
        )
    }

    /// Whether it is a function of multipliers that the caller states.
    pub fn takes_multipliers(self) -> bool {
        matches!(self, Self::ForceResidual | Self::Sensors)
    }
}

/// What to differentiate by: all arguments of one kind, one column each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// `q`
    Position,
    /// `v`
    Velocity,
    /// `u`
    Input,
    /// The parameters.
    Parameters,
    /// `t`, a single column that adds no axis.
    Time,
}

impl Group {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Position,
        Self::Velocity,
        Self::Input,
        Self::Parameters,
        Self::Time,
    ];

    /// The word in a function's name, as in `force_by_velocity`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Input => "input",
            Self::Parameters => "parameters",
            Self::Time => "time",
        }
    }
}

/// A term, or its derivative by a group of arguments, all others held fixed: `a` and
/// `λ` too where the term is a function of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Item {
    /// What is computed or differentiated.
    pub term: Term,
    /// By what.
    pub by: Option<Group>,
}

impl Item {
    /// The term itself.
    pub fn of(term: Term) -> Self {
        Self { term, by: None }
    }

    /// Its derivative by `group`.
    pub fn slope(term: Term, group: Group) -> Self {
        Self {
            term,
            by: Some(group),
        }
    }

    /// Whether it takes the equation of motion to be linear in `a` and `λ`.
    pub(crate) fn solves(self) -> bool {
        match self.term {
            Term::ForwardDynamics
            | Term::ConstrainedAcceleration
            | Term::ConstrainedMultipliers
            | Term::PredictedSensors => true,
            Term::ForceResidual | Term::AccelerationResidual => self.by.is_some(),
            _ => false,
        }
    }

    /// The item whose function has this name: `mass_matrix`, `force_by_velocity`.
    pub fn parse(name: &str) -> Option<Self> {
        let term = |name: &str| Term::ALL.into_iter().find(|t| t.name() == name);
        if let Some(term) = term(name) {
            return Some(Self::of(term));
        }
        let (of, by) = name.rsplit_once("_by_")?;
        let group = Group::ALL.into_iter().find(|g| g.name() == by)?;
        Some(Self::slope(term(of)?, group))
    }
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.term.name())?;
        match self.by {
            Some(group) => write!(f, "_by_{}", group.name()),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for term in Term::ALL {
            let slopes = Group::ALL.map(|group| Item::slope(term, group));
            for item in slopes.into_iter().chain([Item::of(term)]) {
                assert_eq!(Item::parse(&item.to_string()), Some(item));
            }
        }
        for name in [
            "",
            "mass",
            "mass_matrix_by_",
            "by_time",
            "force_by_time_by_time",
        ] {
            assert_eq!(Item::parse(name), None, "{name}");
        }
    }
}
