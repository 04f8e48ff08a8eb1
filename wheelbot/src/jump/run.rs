//! One way up: the robot at 1 kHz, its controller at 100 Hz and one tick late.

use super::floor::{Conditions, Floor, Way};
use super::pose::Pose;
use crate::motors::{Motors, NOMINAL_VOLTAGE};
use crate::robot::Inputs;
use crate::sensing::Sensing;
use crate::trial::{Row, wheel_rates};
use identify::machine::SolveError;
use std::collections::VecDeque;
use wheelbot_firmware::{Balance, Gains, INTERVAL, Jump, Plan, Settings};

/// How often per tick the motors' torques follow their speeds; each time takes two steps of the simulation.
const STEPS: usize = 5;
/// Tilt at which a robot that balances has fallen, rad.
pub const FALLEN: f64 = std::f64::consts::FRAC_PI_3;

/// What tries to get up.
#[derive(Debug, Clone)]
pub struct Jumper {
    /// By which angle.
    pub way: Way,
    /// Where, and what it weighs.
    pub conditions: Conditions,
    /// What its controller does.
    pub plan: Plan<f64>,
    /// The balancing controllers.
    pub gains: Gains<f64>,
    /// `q̄₁, q̄₂` of (6.22), rad.
    pub bias: [f64; 2],
    /// How long it lasts, s.
    pub seconds: f64,
}

/// How it went.
#[derive(Debug, Clone)]
pub struct Jumped {
    /// One per tick.
    pub rows: Vec<Row>,
    /// Per tick, the wheel's lowest point above the floor, m.
    pub lifts: Vec<f64>,
    /// When roll and pitch were given to their controllers, s.
    pub balanced: [Option<f64>; 2],
    /// Whether it fell after that, or to another side, which ends the run.
    pub fell: bool,
}

impl Jumper {
    /// Runs it.
    ///
    /// # Errors
    /// If the equation of motion or the contacts have no solution on the way.
    pub fn run(&self, floor: &Floor, sensing: &mut Sensing) -> Result<Jumped, SolveError> {
        let parameters = floor.parameters(self.way, &self.conditions);
        let mut stepping = floor.stepping(&parameters);
        let motors = Motors {
            voltage: NOMINAL_VOLTAGE,
        };
        let mut controller = self.controller();
        let mut state = floor.lying(&parameters, &self.conditions);
        let mut pending = VecDeque::from([[0.0; 2]]);
        let mut torques = [0.0; 2];
        let mut jumped = Jumped {
            rows: Vec::new(),
            lifts: Vec::new(),
            balanced: [None; 2],
            fell: false,
        };
        for tick in 0..(self.seconds / INTERVAL).round() as usize {
            let t = tick as f64 * INTERVAL;
            let pose = floor.pose(&parameters, &state);
            let balancing = jumped.balanced.iter().any(Option::is_some);
            jumped.fell = floor.is_sideways(&state) || balancing && pose.tilt() > FALLEN;
            if jumped.fell {
                break;
            }
            let shown = floor.shown(&parameters, &state, torques)?;
            let readings = sensing.read(&shown);
            let (tilt, currents) = controller.tick(&readings);
            for (since, balanced) in jumped.balanced.iter_mut().zip(controller.balanced()) {
                *since = since.or(balanced.then_some(t));
            }
            pending.push_back(currents.map(f64::from));
            let currents = pending.pop_front().unwrap_or_default();
            let step = INTERVAL / STEPS as f64;
            for k in 0..STEPS {
                let speeds = wheel_rates(&floor.pose(&parameters, &state).state);
                torques = [0, 1].map(|wheel| motors.torque(currents[wheel], speeds[wheel]));
                let held: Vec<Vec<f64>> = torques.map(|torque| vec![torque]).to_vec();
                stepping.advance(&mut state, t + k as f64 * step, step, &held, &held)?;
            }
            let inputs: Inputs = [torques[0], torques[1], 0.0, 0.0];
            jumped.rows.push(Row {
                t,
                state: pose.state,
                inputs,
                shown,
                readings,
                tilt,
            });
            jumped.lifts.push(pose.lift);
        }
        Ok(jumped)
    }

    fn controller(&self) -> Jump<f32> {
        let balance = Balance {
            gains: self.gains.cast(),
            bias: self.bias.map(|angle| angle as f32),
        };
        Jump::new(
            self.plan.cast(),
            self.conditions.positive,
            Settings::published(),
            balance,
        )
    }
}

impl Jumped {
    /// The pose at a tick.
    pub fn pose(&self, tick: usize) -> Pose {
        Pose {
            state: self.rows[tick].state,
            lift: self.lifts[tick],
        }
    }
}
