//! One simulated run: the robot at 1 kHz, its controller at 100 Hz and one tick late.

use crate::excitation::Excitation;
use crate::motors::{Motors, NOMINAL_VOLTAGE};
use crate::robot::{self, INSTRUMENTS, Inputs, PITCH, REACTION, ROLL, State, WHEEL, Wheelbot};
use crate::sensing::Sensing;
use dynamics::constrained::SolveError;
use std::collections::VecDeque;
use wheelbot_firmware::{Balance, Estimator, Firmware, Gains, INTERVAL, Readings, Settings, Tilt};

/// Steps of the simulation per tick.
const STEPS: usize = 10;
/// Roll or pitch at which the robot has fallen, rad: there its body is on the floor.
const FALLEN: f64 = std::f64::consts::FRAC_PI_3;

/// A push from outside.
#[derive(Debug, Clone, Copy)]
pub struct Push {
    /// When it begins, s.
    pub at: f64,
    /// How long it lasts, s.
    pub seconds: f64,
    /// Forward and to the left, N.
    pub force: [f64; 2],
}

/// What happens in a run.
#[derive(Debug, Clone)]
pub struct Trial {
    /// How long it lasts, s.
    pub seconds: f64,
    /// Where the robot starts; its controller knows roll and pitch there.
    pub start: State,
    /// The controllers.
    pub gains: Gains<f64>,
    /// The estimator.
    pub estimator: Settings<f32>,
    /// Ticks from a reading to the arrival of its command.
    pub delay: usize,
    /// Pushes from outside.
    pub pushes: Vec<Push>,
    /// Torques that are added to the feedback's.
    pub excitation: Option<Excitation>,
}

/// The robot at a tick.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// s.
    pub t: f64,
    /// How it moves.
    pub state: State,
    /// What acts until the next tick begins.
    pub inputs: Inputs,
    /// What the instruments showed, without noise.
    pub shown: [f64; INSTRUMENTS],
    /// What the controller read.
    pub readings: Readings<f32>,
    /// What it made of that.
    pub tilt: Tilt<f32>,
}

/// A run as it went.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// One per tick.
    pub rows: Vec<Row>,
    /// Whether the robot fell, which ends the run.
    pub fell: bool,
}

impl Trial {
    /// A robot that starts upright on published settings, one tick late, with nothing happening.
    pub fn new(seconds: f64, gains: Gains<f64>) -> Self {
        Self {
            seconds,
            start: robot::leaning(0.0, 0.0),
            gains,
            estimator: Settings::published(),
            delay: 1,
            pushes: Vec::new(),
            excitation: None,
        }
    }

    /// Runs it.
    ///
    /// # Errors
    /// If the equation of motion has no solution on the way.
    pub fn run(&self, sensing: &mut Sensing) -> Result<Outcome, SolveError> {
        let plant = Wheelbot::nominal();
        let motors = Motors {
            voltage: NOMINAL_VOLTAGE,
        };
        let mut firmware = self.firmware();
        let mut pending = VecDeque::from(vec![[0.0; 2]; self.delay]);
        let (mut state, mut inputs) = (self.start, Inputs::default());
        let (mut rows, mut fell) = (Vec::new(), false);
        let ticks = (self.seconds / INTERVAL).round() as usize;
        for tick in 0..ticks {
            let t = tick as f64 * INTERVAL;
            [inputs[2], inputs[3]] = self.pushed(t);
            // The torques of the tick before still act.
            let shown = robot::shown(&plant, &state, inputs)?;
            let readings = sensing.read(&shown);
            let ahead = self.ahead(t).map(|torque| torque as f32);
            let (tilt, currents) = firmware.tick(&readings, ahead);
            pending.push_back(currents.map(f64::from));
            let currents = pending.pop_front().unwrap_or_default();
            let begin = state;
            for _ in 0..STEPS {
                let speeds = wheel_rates(&state);
                for k in 0..2 {
                    inputs[k] = motors.torque(currents[k], speeds[k]);
                }
                state = robot::advanced(&plant, &state, inputs, INTERVAL / STEPS as f64)?;
            }
            rows.push(Row {
                t,
                state: begin,
                inputs,
                shown,
                readings,
                tilt,
            });
            fell = state.q[ROLL].abs().max(state.q[PITCH].abs()) > FALLEN;
            if fell {
                break;
            }
        }
        Ok(Outcome { rows, fell })
    }

    fn firmware(&self) -> Firmware<f32> {
        let start = [ROLL, PITCH].map(|k| self.start.q[k] as f32);
        let balance = Balance {
            gains: self.gains.cast(),
            bias: [0.0; 2],
        };
        Firmware::new(Estimator::new(self.estimator, start), balance)
    }

    fn ahead(&self, t: f64) -> [f64; 2] {
        self.excitation.map_or([0.0; 2], |swing| swing.torques(t))
    }

    fn pushed(&self, t: f64) -> [f64; 2] {
        let acting = |push: &&Push| t >= push.at - 1e-9 && t < push.at + push.seconds - 1e-9;
        let acting = self.pushes.iter().filter(acting);
        acting.fold([0.0; 2], |sum, push| {
            [sum[0] + push.force[0], sum[1] + push.force[1]]
        })
    }
}

/// Rates of the reaction wheel and of the rolling wheel against the body, rad/s.
pub fn wheel_rates(state: &State) -> [f64; 2] {
    [state.v[REACTION], state.v[WHEEL] - state.v[PITCH]]
}

/// Root of the mean square.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, total) = values.fold((0_usize, 0.0), |(n, sum), x| (n + 1, sum + x * x));
    (total / count.max(1) as f64).sqrt()
}
