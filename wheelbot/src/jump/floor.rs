//! The robot on a floor that it is not tied to: `on_floor.model` stepped in time, wheels and corners as contacts.

use super::pose::{Pose, WHEEL_RADIUS};
use crate::robot::INSTRUMENTS;
use dynamics_codegen::diagnostic::Report;
use dynamics_codegen::{Library, Variables, compile_keeping};
use identify::machine::{
    Instruments, Machine, Simulated, SolveError, States, Stepping, SteppingOptions,
};
use std::f64::consts::FRAC_PI_2;

/// Coordinates of `on_floor.model`: `x, y, z, yaw, lean, tip, wheel, reaction`.
pub const COORDINATES: usize = 8;
const Z: usize = 2;
const YAW: usize = 3;
const LEAN: usize = 4;
const TIP: usize = 5;

/// Parameters that differ from robot to robot; all others are constants of the compiled model.
const VARIED: [&str; 12] = [
    "m_w", "m_b", "m_r", "I_w_r", "I_w_a", "I_bx", "I_by", "I_bz", "I_r_a", "I_r_r", "mu", "aim",
];

/// Middle angle at which the robot has fallen to another side, rad: 70°.
const SIDEWAYS: f64 = 1.22;
/// Largest step, s.
const STEP: f64 = 1e-3;
/// 1/s; there is no constraint but the contacts.
const STABILISATION: f64 = 20.0;

/// Which angle the robot turns up by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Its roll: standing up.
    Roll,
    /// Its pitch: rolling up.
    Pitch,
}

impl Way {
    /// The angle from upright at which the robot rests between the steps, rad.
    pub fn edge(self) -> f64 {
        match self {
            Self::Roll => 30.0_f64.to_radians(),
            Self::Pitch => 35.0_f64.to_radians(),
        }
    }
}

/// The model, compiled once.
pub struct Floor {
    machine: Machine,
    instruments: Instruments,
    aim: usize,
}

/// One robot on one floor.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// Whether it lies on its positive side: roll or pitch is 90°, and not −90°.
    pub positive: bool,
    /// Coefficient of friction of everything on the floor.
    pub friction: f64,
    /// Masses, with their inertias, of rolling wheel, body and reaction wheel, as shares of the published ones.
    pub masses: [f64; 3],
    /// By how much it starts above the floor at one end, rad: it drops.
    pub tilt: f64,
    /// Rates of both wheels at the start, rad/s.
    pub rates: [f64; 2],
}

impl Conditions {
    /// As published, on rubber that grips.
    pub const NOMINAL: Self = Self {
        positive: true,
        friction: 0.7,
        masses: [1.0; 3],
        tilt: 0.01,
        rates: [0.0; 2],
    };
}

impl Floor {
    /// Compiles it.
    ///
    /// # Errors
    /// If the text is no model: only after an edit of it.
    ///
    /// # Panics
    /// If that took its parameter `aim` away.
    pub fn new() -> Result<Self, Report> {
        let parts = [
            include_str!("../../on_floor.model"),
            include_str!("../../imus.model"),
            include_str!("../../encoders.model"),
        ];
        let varied = Variables::Only(VARIED.map(String::from).into());
        let text = parts.concat();
        let compiled = compile_keeping("on_floor.model", &text, &Library::builtin(), &varied)?;
        let parameters = &compiled.model.parameters;
        let aim = parameters.iter().position(|p| p.name == "aim");
        let aim = aim.expect("on_floor.model has a parameter `aim`");
        let mut machine = Machine::new(compiled);
        Ok(Self {
            instruments: machine.instruments(&[]),
            aim,
            machine,
        })
    }

    /// The model's parameters under some conditions.
    pub fn parameters(&self, way: Way, conditions: &Conditions) -> Vec<f64> {
        let [wheel, body, reaction] = conditions.masses;
        let parameters = &self.machine.compiled.model.parameters;
        let value = |name: &str, nominal: f64| match name {
            "m_w" | "I_w_r" | "I_w_a" => wheel * nominal,
            "m_b" | "I_bx" | "I_by" | "I_bz" => body * nominal,
            "m_r" | "I_r_a" | "I_r_r" => reaction * nominal,
            "mu" => conditions.friction,
            "aim" => aim(way),
            _ => nominal,
        };
        let named = parameters.iter().map(|p| value(&p.name, p.nominal));
        named.collect()
    }

    /// The robot in motion.
    pub fn stepping<'a>(&'a self, parameters: &'a [f64]) -> Stepping<'a> {
        let options = SteppingOptions {
            max_step: STEP,
            stabilisation: STABILISATION,
            exact_impacts: false,
        };
        Stepping::new(&self.machine, parameters, options)
    }

    /// At rest at an angle from upright and one from level about the other axis, with the lowest point on the floor.
    pub fn placed(&self, parameters: &[f64], [tip, lean]: [f64; 2]) -> Simulated {
        let mut state = Simulated {
            q: vec![vec![0.0]; COORDINATES],
            v: vec![vec![0.0]; COORDINATES],
            z: Vec::new(),
        };
        (state.q[TIP][0], state.q[LEAN][0]) = (tip, lean);
        // So that the heading is along the first axis.
        state.q[YAW][0] = -parameters[self.aim];
        let terms = self
            .machine
            .contact_terms(&at(&state, [0.0; 2]), parameters);
        let gaps = terms.iter().flat_map(|terms| terms.gap.iter().copied());
        state.q[Z][0] = -gaps.fold(f64::INFINITY, f64::min);
        state
    }

    /// Lying on a side as the conditions have it.
    pub fn lying(&self, parameters: &[f64], conditions: &Conditions) -> Simulated {
        let side = if conditions.positive { 1.0 } else { -1.0 };
        let mut state = self.placed(parameters, [side * (FRAC_PI_2 - conditions.tilt), 0.0]);
        let [reaction, rolling] = conditions.rates;
        (state.v[COORDINATES - 2][0], state.v[COORDINATES - 1][0]) = (rolling, reaction);
        state
    }

    /// What the instruments show without noise under torques of reaction wheel and rolling wheel, N·m.
    ///
    /// # Errors
    /// If the equation of motion has no solution there.
    pub fn shown(
        &self,
        parameters: &[f64],
        state: &Simulated,
        torques: [f64; 2],
    ) -> Result<[f64; INSTRUMENTS], SolveError> {
        let states = at(state, torques);
        let pressed = self.machine.pressed(&states, parameters)?;
        let motions: Vec<_> = pressed.into_iter().map(|p| p.motion).collect();
        let columns = self.instruments.read(&states, &motions, parameters);
        Ok(std::array::from_fn(|k| columns[k][0]))
    }

    /// Whether the robot lies on another side than those that it gets up from: its middle angle is near to a right one,
    /// where the model's angles end.
    pub fn is_sideways(&self, state: &Simulated) -> bool {
        state.q[LEAN][0].abs() > SIDEWAYS
    }

    /// Where the robot is.
    pub fn pose(&self, parameters: &[f64], state: &Simulated) -> Pose {
        let q: [f64; COORDINATES] = std::array::from_fn(|k| state.q[k][0]);
        let v: [f64; COORDINATES] = std::array::from_fn(|k| state.v[k][0]);
        Pose::new(&q, &v, parameters[self.aim], WHEEL_RADIUS)
    }
}

/// Turn of the robot in the axes of the model's angles, so that the middle one of them stays away from a right angle.
fn aim(way: Way) -> f64 {
    match way {
        Way::Roll => FRAC_PI_2,
        Way::Pitch => 0.0,
    }
}

fn at(state: &Simulated, torques: [f64; 2]) -> States {
    States {
        t: vec![0.0],
        q: state.q.clone(),
        v: state.v.clone(),
        u: torques.map(|torque| vec![torque]).to_vec(),
        ..States::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{self, PITCH, ROLL, Wheelbot};

    /// What both models say of the same robot.
    #[test]
    fn parameters_are_those_of_the_rolling_model() {
        let rolling = robot::compiled().unwrap().model;
        let text = include_str!("../../on_floor.model");
        let free = dynamics_codegen::compile("on_floor.model", text, &Library::builtin());
        let free = free.unwrap().model.parameters;
        for known in &rolling.parameters {
            let same = free.iter().find(|p| p.name == known.name).unwrap();
            assert_eq!(same.nominal, known.nominal, "{}", known.name);
        }
    }

    #[test]
    fn imus_are_those_of_the_rolling_model() {
        let rolling = include_str!("../../../models/wheelbot.model");
        let imus = include_str!("../../imus.model").lines();
        let statements: Vec<&str> = imus.filter(|line| line.ends_with(['}', ';'])).collect();
        assert_eq!(statements.len(), 12);
        for statement in statements {
            assert!(rolling.contains(statement), "{statement}");
        }
    }

    /// Between the steps it rests on an edge and the wheel, at the angles of the text.
    #[test]
    fn it_rests_at_the_angles_of_the_text() {
        let floor = Floor::new().unwrap();
        for (way, degrees, place) in [(Way::Roll, 30.0, ROLL), (Way::Pitch, 35.0, PITCH)] {
            let parameters = floor.parameters(way, &Conditions::NOMINAL);
            let mut stepping = floor.stepping(&parameters);
            let mut state = floor.placed(&parameters, [f64::to_radians(degrees) - 0.05, 0.0]);
            let none = vec![vec![0.0]; 2];
            for k in 0..200 {
                let t = f64::from(k) * 0.01;
                stepping.advance(&mut state, t, 0.01, &none, &none).unwrap();
            }
            let pose = floor.pose(&parameters, &state);
            let rests = pose.state.q[place].to_degrees();
            assert!((rests - degrees).abs() < 0.05, "{way:?}: {rests}");
            assert!(pose.lift.abs() < 1e-5, "{way:?}: {pose:?}");
        }
    }

    /// On a floor that grips, contacts do what the constraints of the rolling model do.
    #[test]
    fn a_wheel_that_grips_rolls() {
        let floor = Floor::new().unwrap();
        let conditions = Conditions {
            friction: 5.0,
            ..Conditions::NOMINAL
        };
        let parameters = floor.parameters(Way::Pitch, &conditions);
        let mut stepping = floor.stepping(&parameters);
        let (roll, pitch) = (0.1, 0.05);
        // Lean and tip are roll and pitch here, and the wheel turns against the body.
        let mut state = floor.placed(&parameters, [pitch, roll]);
        let plant = Wheelbot::nominal();
        let mut rolling = robot::leaning(roll, pitch);
        let began = floor.pose(&parameters, &state).state;
        let torques = [0.02, 0.01];
        let inputs = torques.map(|torque| vec![torque]).to_vec();
        for k in 0..150 {
            let t = f64::from(k) * 1e-3;
            stepping
                .advance(&mut state, t, 1e-3, &inputs, &inputs)
                .unwrap();
            let held = [torques[0], torques[1], 0.0, 0.0];
            rolling = robot::advanced(&plant, &rolling, held, 1e-3).unwrap();
        }
        let free = floor.pose(&parameters, &state).state;
        for k in 2..7 {
            let apart = (free.q[k] - rolling.q[k]).abs();
            assert!(apart < 2e-3, "{k}: {} {}", free.q[k], rolling.q[k]);
        }
        let way = free.q[robot::X] - began.q[robot::X];
        assert!((way - rolling.q[robot::X]).abs() < 1e-3, "{way}");
        assert!(rolling.q[ROLL] > 0.15, "it has hardly moved");
    }
}
