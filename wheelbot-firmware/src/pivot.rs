//! Acceleration of the rolling wheel's centre from the encoder and the rates (6.3.3).

use crate::vector::{Attitude, Vector};
use dynamics::Scalar;

/// The terms of `p̈_W = p̈_CI + p̈_WC`, [6.17] to [6.19], along the axes of `{C}`: `e₁` ahead, `e₂` to
/// the left, `e₃` up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// `r_w q̈₄ᴱ e₁`: the wheel speeds up. The only one that the robot uses.
    Wheel,
    /// `r_w q̈₂ e₁`: what the encoder, on the body, does not see of it.
    Pitch,
    /// `r_w q̇₃ q̇₄ e₂`: the rolling wheel goes round a corner.
    Turning,
    /// `−r_w q̈₁ (cos q₁ e₂ + sin q₁ e₃)`: the wheel tips over.
    Roll,
    /// `2 r_w cos q₁ q̇₁ q̇₃ e₁`: it tips over while it turns.
    Coriolis,
    /// `r_w sin q₁ q̈₃ e₁`: its turn speeds up while it leans.
    Yaw,
    /// `r_w (sin q₁ (q̇₁² + q̇₃²) e₂ − cos q₁ q̇₁² e₃)`.
    Centripetal,
}

impl Term {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Wheel,
        Self::Pitch,
        Self::Turning,
        Self::Roll,
        Self::Coriolis,
        Self::Yaw,
        Self::Centripetal,
    ];

    /// As an equation.
    pub fn equation(self) -> &'static str {
        match self {
            Self::Wheel => "r_w q̈₄ᴱ e₁",
            Self::Pitch => "r_w q̈₂ e₁",
            Self::Turning => "r_w q̇₃ q̇₄ e₂",
            Self::Roll => "−r_w q̈₁ (cos q₁ e₂ + sin q₁ e₃)",
            Self::Coriolis => "2 r_w cos q₁ q̇₁ q̇₃ e₁",
            Self::Yaw => "r_w sin q₁ q̈₃ e₁",
            Self::Centripetal => "r_w sin q₁ (q̇₁² + q̇₃²) e₂ − r_w cos q₁ q̇₁² e₃",
        }
    }
}

/// Which terms are taken into account.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Terms(u8);

impl Terms {
    /// None: the pivot is taken to stand still, as for a robot on a fixed foot.
    pub const NONE: Self = Self(0);
    /// The one that the robot's firmware computes.
    pub const PUBLISHED: Self = Self::NONE.with(Term::Wheel);
    /// All.
    pub const ALL: Self = Self(0x7f);

    /// One more.
    #[must_use]
    pub const fn with(self, term: Term) -> Self {
        Self(self.0 | 1 << term as u8)
    }

    /// One less.
    #[must_use]
    pub const fn without(self, term: Term) -> Self {
        Self(self.0 & !(1 << term as u8))
    }

    /// Whether a term is among them.
    pub fn has(self, term: Term) -> bool {
        self.0 & 1 << term as u8 != 0
    }
}

/// What the terms are computed from.
#[derive(Clone, Copy, Debug)]
pub struct Moving<T> {
    /// `q̇₁, q̇₂, q̇₃`, rad/s.
    pub rates: Vector<T>,
    /// `q̈₁, q̈₂, q̈₃`, rad/s².
    pub accelerations: Vector<T>,
    /// `q̇₄ᴱ`, against the body, rad/s.
    pub wheel_rate: T,
    /// `q̈₄ᴱ`, rad/s².
    pub wheel_acceleration: T,
}

/// One term, m/s², along the axes of `{C}`.
pub fn term<T: Scalar>(term: Term, radius: T, attitude: &Attitude<T>, m: &Moving<T>) -> Vector<T> {
    let (s1, c1) = attitude.roll;
    let ([v1, v2, v3], [a1, a2, a3]) = (m.rates, m.accelerations);
    let zero = T::zero();
    match term {
        Term::Wheel => [radius * m.wheel_acceleration, zero, zero],
        Term::Pitch => [radius * a2, zero, zero],
        Term::Turning => [zero, radius * v3 * (m.wheel_rate + v2), zero],
        Term::Roll => [zero, -(radius * c1 * a1), -(radius * s1 * a1)],
        Term::Coriolis => [(radius + radius) * c1 * v1 * v3, zero, zero],
        Term::Yaw => [radius * s1 * a3, zero, zero],
        Term::Centripetal => [
            zero,
            radius * s1 * (v1 * v1 + v3 * v3),
            -(radius * c1 * v1 * v1),
        ],
    }
}

/// `ᴮp̈_W`, m/s², in body axes: the chosen terms together.
pub fn acceleration<T: Scalar>(
    terms: Terms,
    radius: T,
    attitude: &Attitude<T>,
    moving: &Moving<T>,
) -> Vector<T> {
    let mut total = [T::zero(); 3];
    for one in Term::ALL {
        if terms.has(one) {
            let [x, y, z] = term(one, radius, attitude, moving);
            total = [total[0] + x, total[1] + y, total[2] + z];
        }
    }
    attitude.to_body(total)
}
