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

/// How long the robot balances to find its bias, s.
const CALM: f64 = 10.0;

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
    /// The robot as it is, whatever is known of it.
    pub plant: Wheelbot<f64>,
    /// Where the robot starts; its controller knows roll and pitch there.
    pub start: State,
    /// The controllers.
    pub gains: Gains<f64>,
    /// The estimator.
    pub estimator: Settings<f32>,
    /// `q̄₁, q̄₂` of (6.22), rad.
    pub bias: [f64; 2],
    /// Ticks from a reading to the arrival of its command.
    pub delay: usize,
    /// Pushes from outside.
    pub pushes: Vec<Push>,
    /// Torques that are added to the feedback's.
    pub excitations: Vec<Excitation>,
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
            plant: Wheelbot::nominal(),
            start: robot::leaning(0.0, 0.0),
            gains,
            estimator: Settings::published(),
            bias: [0.0; 2],
            delay: 1,
            pushes: Vec::new(),
            excitations: Vec::new(),
        }
    }

    /// The same on a robot that has found its bias, as the robot does before it starts: the estimate's
    /// mean over ten seconds of balancing, in which the robot does not tilt on the whole.
    ///
    /// # Errors
    /// As [`Trial::run`].
    pub fn calibrated(self, sensing: &mut Sensing) -> Result<Self, SolveError> {
        let calm = calm(self.gains, sensing)?;
        let mean = |k: usize| {
            let sum: f64 = calm.iter().map(|row| f64::from(row.tilt.fused[k])).sum();
            sum / calm.len().max(1) as f64
        };
        Ok(Self {
            bias: [mean(0), mean(1)],
            ..self
        })
    }

    /// Runs it.
    ///
    /// # Errors
    /// If the equation of motion has no solution on the way.
    pub fn run(&self, sensing: &mut Sensing) -> Result<Outcome, SolveError> {
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
            let shown = robot::shown(&self.plant, &state, inputs)?;
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
                state = robot::advanced(&self.plant, &state, inputs, INTERVAL / STEPS as f64)?;
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
            bias: self.bias.map(|angle| angle as f32),
        };
        Firmware::new(Estimator::new(self.estimator, start), balance)
    }

    fn ahead(&self, t: f64) -> [f64; 2] {
        let torques = self.excitations.iter().map(|swing| swing.torques(t));
        torques.fold([0.0; 2], |sum, torque| {
            [sum[0] + torque[0], sum[1] + torque[1]]
        })
    }

    fn pushed(&self, t: f64) -> [f64; 2] {
        let acting = |push: &&Push| t >= push.at - 1e-9 && t < push.at + push.seconds - 1e-9;
        let acting = self.pushes.iter().filter(acting);
        acting.fold([0.0; 2], |sum, push| {
            [sum[0] + push.force[0], sum[1] + push.force[1]]
        })
    }
}

/// Ten seconds of balancing.
///
/// # Errors
/// As [`Trial::run`].
pub fn calm(gains: Gains<f64>, sensing: &mut Sensing) -> Result<Vec<Row>, SolveError> {
    Ok(Trial::new(CALM, gains).run(sensing)?.rows)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::planes;
    use crate::design::poles::poles;

    /// The linear design tells how late commands may come, and the simulation agrees: with stable poles
    /// it comes to rest, with unstable ones it sways for ever or falls.
    #[test]
    fn it_comes_to_rest_where_the_poles_are_stable() {
        let gains = Gains::PUBLISHED;
        let [roll, pitch] = planes(Some(INTERVAL)).unwrap();
        let sensing = Sensing::new(1).unwrap().without_noise();
        let lean = 0.02;
        let (mut stable, mut unstable) = (0, 0);
        for delay in 0..8 {
            let mut trial = Trial::new(10.0, gains);
            trial.delay = delay;
            trial.start = robot::leaning(lean, lean);
            let outcome = trial.run(&mut sensing.clone()).unwrap();
            let last = outcome.rows.iter().rev().take(200);
            let tilts = last.map(|row| row.state.q[ROLL].hypot(row.state.q[PITCH]));
            let rests = !outcome.fell && rms(tilts) < lean / 4.0;
            let largest = [(&roll, &gains.roll), (&pitch, &gains.pitch)]
                .map(|(plane, gain)| poles(plane, gain, delay)[0].norm())
                .into_iter()
                .fold(0.0, f64::max);
            assert_eq!(rests, largest < 1.0, "{delay} ticks late, pole {largest}");
            match rests {
                true => stable += 1,
                false => unstable += 1,
            }
        }
        assert!(stable > 1 && unstable > 1, "{stable} {unstable}");
    }

    /// The estimate in `f32` and in `f64`, on the same readings.
    #[test]
    fn single_precision_is_enough() {
        let mut trial = Trial::new(10.0, Gains::PUBLISHED);
        trial.pushes = vec![Push {
            at: 1.0,
            seconds: 0.1,
            force: [1.5, 1.5],
        }];
        let rows = trial.run(&mut Sensing::new(1).unwrap()).unwrap().rows;
        let mut estimator = Estimator::<f64>::new(Settings::published(), [0.0; 2]);
        let mut wheel = wheelbot_firmware::wheel::Wheel::new();
        let mut largest = 0.0;
        for row in &rows {
            let double = |all: [[f32; 3]; 4]| all.map(|vector| vector.map(f64::from));
            let readings = Readings {
                gyroscopes: double(row.readings.gyroscopes),
                accelerometers: double(row.readings.accelerometers),
                rolling: row.readings.rolling,
                reaction: row.readings.reaction,
            };
            wheel.read(readings.rolling, INTERVAL);
            let exact = estimator.update(&readings, &wheel).fused;
            for k in 0..2 {
                let apart = (f64::from(row.tilt.fused[k]) - exact[k]).abs();
                largest = f64::max(largest, apart);
            }
        }
        assert!(largest < 1e-5, "{largest} rad apart");
    }
}
