//! Readings of frames in expressions: `position(tip).z`, `velocity(tip).x`, ….
//!
//! Each reading is a symbol of its own until the equations are derived. So the
//! text of a constraint stays readable on the review sheet, and its Jacobian is
//! put together from those of the frames it names, by structure, in place of
//! differentiating through the kinematics.

use super::Model;
use crate::graph::{ExprId, SymbolId};

/// What can be read off a frame; components are along the world's axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reading {
    /// A component of the origin's position, m.
    Position(usize),
    /// Component `1` of the unit vector along the frame's axis `0`.
    Axis(usize, usize),
    /// A component of the origin's velocity, m/s.
    Velocity(usize),
    /// A component of the angular velocity, rad/s.
    AngularVelocity(usize),
    /// A component of the origin's acceleration at `a = 0`: of `J̇ v`.
    AccelerationBias(usize),
    /// A component of the angular acceleration at `a = 0`.
    AngularAccelerationBias(usize),
    /// A component of the origin's acceleration, m/s².
    Acceleration(usize),
    /// A component of the angular acceleration, rad/s².
    AngularAcceleration(usize),
}

impl Reading {
    /// Whether it is known from positions and time alone.
    pub fn is_positional(self) -> bool {
        matches!(self, Self::Position(_) | Self::Axis(..))
    }

    /// Whether it contains accelerations: only sensors read these.
    pub fn is_acceleration(self) -> bool {
        matches!(self, Self::Acceleration(_) | Self::AngularAcceleration(_))
    }

    /// As it is written in a model.
    fn text(self, frame: &str) -> String {
        const NAMES: [char; 3] = ['x', 'y', 'z'];
        match self {
            Self::Position(i) => format!("position({frame}).{}", NAMES[i]),
            Self::Axis(axis, i) => format!("axis_{}({frame}).{}", NAMES[axis], NAMES[i]),
            Self::Velocity(i) => format!("velocity({frame}).{}", NAMES[i]),
            Self::AngularVelocity(i) => format!("angular_velocity({frame}).{}", NAMES[i]),
            Self::AccelerationBias(i) => format!("acceleration_bias({frame}).{}", NAMES[i]),
            Self::AngularAccelerationBias(i) => {
                format!("angular_acceleration_bias({frame}).{}", NAMES[i])
            }
            Self::Acceleration(i) => format!("acceleration({frame}).{}", NAMES[i]),
            Self::AngularAcceleration(i) => format!("angular_acceleration({frame}).{}", NAMES[i]),
        }
    }
}

/// A symbol that stands for a reading.
#[derive(Debug, Clone, Copy)]
pub struct Kinematic {
    /// The symbol.
    pub symbol: SymbolId,
    /// Index of the frame among the tree's bodies.
    pub frame: usize,
    /// What is read.
    pub reading: Reading,
}

impl Model {
    /// The symbol of a reading.
    pub(super) fn reading(&mut self, frame: usize, reading: Reading) -> ExprId {
        let same = |k: &&Kinematic| k.frame == frame && k.reading == reading;
        let symbol = match self.kinematics.iter().find(same) {
            Some(known) => known.symbol,
            None => {
                let text = reading.text(&self.tree.bodies[frame].name);
                let symbol = self.graph.symbol(text);
                self.kinematics.push(Kinematic {
                    symbol,
                    frame,
                    reading,
                });
                symbol
            }
        };
        self.graph.var(symbol)
    }

    /// Symbols for what is known from positions.
    pub(crate) fn positional_symbols(&self) -> impl Iterator<Item = SymbolId> {
        let coordinates = self.position_symbols().into_iter();
        let readings = self.kinematics.iter();
        let readings = readings.filter(|k| k.reading.is_positional());
        coordinates.chain(readings.map(|k| k.symbol))
    }

    /// Symbols for what is known from velocities.
    pub(crate) fn velocity_symbols(&self) -> impl Iterator<Item = SymbolId> {
        let coordinates = self.coordinates.iter().map(|c| c.velocity);
        let readings = self.kinematics.iter();
        let readings = readings.filter(|k| !k.reading.is_positional());
        coordinates.chain(readings.map(|k| k.symbol))
    }

    /// Whether an expression contains a velocity.
    pub(crate) fn contains_velocity(&self, expr: ExprId) -> bool {
        self.velocity_symbols()
            .any(|symbol| self.graph.depends_on(&[expr], symbol))
    }

    /// Whether an expression contains a coordinate or a reading of a frame.
    pub(crate) fn contains_position(&self, expr: ExprId) -> bool {
        self.positional_symbols()
            .any(|symbol| self.graph.depends_on(&[expr], symbol))
    }

    /// The time derivative's seeds: `q → v`, `t → 1`, readings likewise; velocities
    /// to what they change by at `a = 0`, states to their rates.
    pub(crate) fn time_seeds(&mut self) -> Vec<(SymbolId, ExprId)> {
        let one = self.graph.one();
        let mut seeds = vec![(self.time, one)];
        let rates = self.position_rates();
        seeds.extend(self.position_symbols().into_iter().zip(rates));
        // A reading's rate may be a reading that nobody has asked for yet.
        let mut next = 0;
        while let Some(&Kinematic {
            symbol,
            frame,
            reading,
        }) = self.kinematics.get(next)
        {
            if let Some(rate) = self.reading_rate(frame, reading) {
                seeds.push((symbol, rate));
            }
            next += 1;
        }
        seeds.extend(self.states.iter().map(|z| (z.symbol, z.rate)));
        seeds
    }

    fn reading_rate(&mut self, frame: usize, reading: Reading) -> Option<ExprId> {
        Some(match reading {
            Reading::Position(i) => self.reading(frame, Reading::Velocity(i)),
            Reading::Velocity(i) => self.reading(frame, Reading::AccelerationBias(i)),
            Reading::AngularVelocity(i) => self.reading(frame, Reading::AngularAccelerationBias(i)),
            // ω × axis
            Reading::Axis(axis, i) => {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let omega = [j, k].map(|c| self.reading(frame, Reading::AngularVelocity(c)));
                let along = [j, k].map(|c| self.reading(frame, Reading::Axis(axis, c)));
                let plus = self.graph.mul(omega[0], along[1]);
                let minus = self.graph.mul(omega[1], along[0]);
                self.graph.sub(plus, minus)
            }
            Reading::AccelerationBias(_)
            | Reading::AngularAccelerationBias(_)
            | Reading::Acceleration(_)
            | Reading::AngularAcceleration(_) => return None,
        })
    }
}
