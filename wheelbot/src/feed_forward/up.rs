//! The pulses of both ways up, one step at a time: the first pulse by how the robot comes to rest on its edge, then the
//! second one by how it is handed to its controllers.

use super::search::{Effort, Least, Variable, least};
use super::together;
use crate::jump::draw::MOST_MASS;
use crate::jump::plans::{FIRST, Steps};
use crate::jump::run::FALLEN;
use crate::jump::{Conditions, Floor, Jumped, Ready, Way};
use crate::motors::STALL_TORQUE;
use crate::robot::{PITCH, ROLL};
use crate::sensing::Sensing;
use crate::studies::StudyError;
use rayon::prelude::*;
use wheelbot_firmware::{Gains, INTERVAL};

/// Every plan is tried on robots on little and on much friction.
const FRICTIONS: [f64; 2] = [0.6, 0.9];
/// They are held so far from flat, rad, and drop,
const TILT: f64 = 0.03;
/// with wheels that turn so fast, rad/s.
const RATES: [f64; 2] = [3.0, -3.0];
/// Added to the seed of each one's noise and biases: far from those of any study.
const NOISE: u64 = 1 << 40;

/// How long a robot balances behind the second pulse, s.
const BALANCED: f64 = 1.6;
/// Within this of its edge a robot has arrived there, rad.
const THERE: f64 = 0.05;
/// What an arrival at the edge costs per rad/s: who is fast bounces, or turns past it.
const LANDING: f64 = 0.1;
/// What a step costs per second,
const TIME: f64 = 0.1;
/// and per second beyond these.
const MOST_SECONDS: f64 = 1.0;
const LATE: f64 = 10.0;
/// What the torque of a stalled motor costs per second.
const TORQUE: f64 = 0.1;
/// Above what any run costs.
const WORST: f64 = 10.0;

/// The strongest current, A: the robot's own strongest.
const MOST_CURRENT: f64 = 15.56;

/// Robots that lie on floors, for a plan to be tried on.
pub struct Scenes {
    floor: Floor,
    robots: Vec<Ready>,
}

impl Scenes {
    /// Little and much friction with light and heavy: all four together, two on either side.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn new(gains: Gains<f64>, seed: u64) -> Result<Self, StudyError> {
        let noise = NOISE.wrapping_add(seed.wrapping_mul(100));
        let mut robots = Vec::new();
        for (grips, friction) in FRICTIONS.into_iter().enumerate() {
            for (heavy, mass) in [1.0 - MOST_MASS, 1.0 + MOST_MASS].into_iter().enumerate() {
                let conditions = Conditions {
                    positive: grips == heavy,
                    friction,
                    masses: [mass; 3],
                    tilt: TILT,
                    rates: RATES,
                };
                let sensing = Sensing::new(noise.wrapping_add(robots.len() as u64))?;
                robots.push(Ready::new(conditions, gains, sensing)?);
            }
        }
        Ok(Self {
            floor: Floor::new()?,
            robots,
        })
    }

    /// The first robot's way up by a plan.
    ///
    /// # Errors
    /// If its contacts have no solution on the way.
    pub fn shown(&self, steps: &Steps) -> Result<Jumped, StudyError> {
        let seconds = steps.second() + BALANCED;
        Ok(self.robots[0].run(&self.floor, steps, seconds)?)
    }

    /// What a step of a plan, 0 or 1, costs. A run whose contacts have no solution costs more than any other.
    pub fn cost(&self, steps: &Steps, step: usize) -> f64 {
        let seconds = steps.second() + [0.0, BALANCED][step];
        let cost = |robot: &Ready| {
            let Ok(jumped) = robot.run(&self.floor, steps, seconds) else {
                return WORST;
            };
            let run = Run {
                steps,
                jumped: &jumped,
                side: if robot.conditions.positive { 1.0 } else { -1.0 },
            };
            match step {
                0 => run.first(),
                _ => run.second(),
            }
        };
        together(&self.robots.par_iter().map(cost).collect::<Vec<_>>())
    }

    /// Looks for one step's pulse, which is replaced in the plan.
    ///
    /// # Errors
    /// As [`least`].
    pub fn improve(
        &self,
        steps: &mut Steps,
        step: usize,
        effort: Effort,
    ) -> Result<(Vec<Variable>, Least), StudyError> {
        let variables = variables(steps, step);
        let cost = |values: &[f64]| Ok(self.cost(&with(steps, step, values), step));
        let found = least(&variables, effort, &cost)?;
        *steps = with(steps, step, &found.values);
        Ok((variables, found))
    }
}

/// Current and time of a step's pulse and, where a rolling wheel lands, what brakes it; from those of a plan on.
fn variables(steps: &Steps, step: usize) -> Vec<Variable> {
    let variable = |name, start, within| Variable {
        name,
        start,
        within,
    };
    let pulse = steps.pulses[step];
    let mut variables = vec![
        variable("current, A", pulse.current, [3.0, MOST_CURRENT]),
        variable("time, s", pulse.seconds, [pulse.easing.max(0.03), 0.4]),
    ];
    if (steps.way, step) == (Way::Pitch, 0) {
        variables.push(variable("brake, A", steps.brake, [0.0, MOST_CURRENT]));
    }
    variables
}

/// A plan with other values of [`variables`].
fn with(steps: &Steps, step: usize, values: &[f64]) -> Steps {
    let mut steps = *steps;
    (steps.pulses[step].current, steps.pulses[step].seconds) = (values[0], values[1]);
    if let Some(&brake) = values.get(2) {
        steps.brake = brake;
    }
    steps
}

/// A way up as it went.
struct Run<'a> {
    steps: &'a Steps,
    jumped: &'a Jumped,
    side: f64,
}

impl Run<'_> {
    /// The angle that turns, rad from upright: a right one at the start.
    fn angle(&self, tick: usize) -> f64 {
        self.side * self.jumped.rows[tick].state.q[self.place()]
    }

    fn rate(&self, tick: usize) -> f64 {
        self.jumped.rows[tick].state.v[self.place()]
    }

    fn place(&self) -> usize {
        match self.steps.way {
            Way::Roll => ROLL,
            Way::Pitch => PITCH,
        }
    }

    /// Ticks from a time on.
    fn from(&self, t: f64) -> std::ops::Range<usize> {
        let rows = self.jumped.rows.len();
        ((t / INTERVAL).round() as usize).min(rows)..rows
    }

    /// What the first step costs. Who does not get as far as the edge: 1 and more, by how far it stays away. Who does: by
    /// its rate there, and by how far from the edge it is in the end.
    fn first(&self) -> f64 {
        let edge = self.steps.way.edge();
        let ticks = self.from(FIRST);
        let there = ticks.clone().find(|&k| self.angle(k) < edge + THERE);
        let missed = match (there, ticks.clone().last()) {
            (Some(k), Some(last)) => LANDING * self.rate(k).abs() + (self.angle(last) - edge).abs(),
            _ => {
                let nearest = ticks.clone().map(|k| self.angle(k));
                1.0 + nearest.fold(f64::INFINITY, f64::min) - edge
            }
        };
        missed + self.price(FIRST, there)
    }

    /// What the second step costs. Who is never handed over: 2 and more, by how far from upright it stays. Who falls behind
    /// that: 1 and more, by how soon. Who stands: by its largest tilt behind that.
    fn second(&self) -> f64 {
        let begin = self.steps.second();
        let ticks = self.from(begin);
        let tilt = |k: usize| self.jumped.pose(k).tilt();
        let [roll, pitch] = self.jumped.balanced;
        let Some(since) = roll.zip(pitch).map(|(roll, pitch)| roll.max(pitch)) else {
            return 2.0 + ticks.map(tilt).fold(FALLEN, f64::min);
        };
        let behind = self.from(since);
        let missed = match self.jumped.fell {
            true => 2.0 - behind.len() as f64 * INTERVAL / BALANCED,
            false => behind.clone().map(tilt).fold(0.0, f64::max) / FALLEN,
        };
        missed + self.price(begin, behind.clone().next())
    }

    /// Of time and torque from the beginning of a step until a tick, or to the end.
    fn price(&self, begin: f64, until: Option<usize>) -> f64 {
        let ticks = self.from(begin);
        let until = until.unwrap_or(ticks.end);
        let seconds = until.saturating_sub(ticks.start) as f64 * INTERVAL;
        let driving = usize::from(self.steps.way == Way::Pitch);
        let torques = ticks.map(|k| self.jumped.rows[k].inputs[driving] / STALL_TORQUE);
        let torque: f64 = torques.map(|share| share * share * INTERVAL).sum();
        TIME * seconds + LATE * (seconds - MOST_SECONDS).max(0.0) + TORQUE * torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jump::plans::{found, published};

    /// Numbers of a plan cost less than the robot's own, and less than with a pulse a fifth shorter or longer: the search
    /// has something to go by on either side.
    #[test]
    fn the_plans_are_where_the_cost_is_least() {
        if left_out::too_slow() {
            return;
        }
        let scenes = Scenes::new(Gains::PUBLISHED, 1).unwrap();
        for way in [Way::Roll, Way::Pitch] {
            for step in [0, 1] {
                let plan = found(way);
                let mut worse = plan;
                worse.pulses[step] = published(way).pulses[step];
                let cost = scenes.cost(&plan, step);
                assert!(cost < scenes.cost(&worse, step), "{way:?}, {step}: {cost}");
                for share in [0.8, 1.2] {
                    let mut other = plan;
                    other.pulses[step].seconds *= share;
                    let there = scenes.cost(&other, step);
                    assert!(cost < there, "{way:?}, {step}, {share}: {cost}, {there}");
                }
            }
        }
    }
}
