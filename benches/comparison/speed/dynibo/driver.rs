//! The Rust crate dynibo behind the driver: answers the commands of `driver.h`.
//!
//!     dynibo-driver STATES.txt ROBOT.urdf (fixed | floating)
//!     dynibo-driver ROBOT.urdf                                  prints the joints in dynibo's order
//!
//! A row of the states has the base's place (x, y, z, quaternion x, y, z, w) and twist (angular, then linear, in
//! the world's axes) where it floats, then q, v of the joints and all generalised forces.

use dynibo::{BaseState, FloatingRobot, Frame, Robot, Twist};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::error::Error;
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::time::Instant;

const STATES: usize = 64;

enum Machine {
    Fixed(Robot),
    Floating(FloatingRobot),
}

struct State {
    base: BaseState,
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
}

struct Driver {
    machine: Machine,
    states: Vec<State>,
    zero: Vec<f64>,
    mass: Vec<f64>,
    bias: Vec<f64>,
    acceleration: Vec<f64>,
}

impl Driver {
    fn mass(&mut self, s: usize) -> dynibo::Result<()> {
        let x = &self.states[s];
        match &mut self.machine {
            Machine::Fixed(robot) => robot.mass_matrix(&x.q, &mut self.mass),
            Machine::Floating(robot) => robot.mass_matrix(&x.base, &x.q, &mut self.mass),
        }
    }

    fn bias(&mut self, s: usize) -> dynibo::Result<()> {
        let (x, zero, out) = (&self.states[s], &self.zero, &mut self.bias);
        match &mut self.machine {
            Machine::Fixed(robot) => robot.inverse_dynamics(&x.q, &x.v, zero, &[], out),
            Machine::Floating(robot) => robot.inverse_dynamics(&x.base, &x.q, &x.v, zero, &[], out),
        }
    }

    fn forward(&mut self, s: usize) -> dynibo::Result<()> {
        let (x, out) = (&self.states[s], &mut self.acceleration);
        match &mut self.machine {
            Machine::Fixed(robot) => robot.forward_dynamics(&x.q, &x.v, &x.tau, &[], out),
            Machine::Floating(robot) => {
                robot.forward_dynamics(&x.base, &x.q, &x.v, &x.tau, &[], out)
            }
        }
    }

    fn run(&mut self, function: &str, s: usize) -> Result<(), Box<dyn Error>> {
        match function {
            "mass" => self.mass(s)?,
            "bias" => self.bias(s)?,
            "both" => {
                self.mass(s)?;
                self.bias(s)?;
            }
            "forward" => self.forward(s)?,
            other => return Err(format!("there is no function {other}").into()),
        }
        Ok(())
    }

    fn results(&self, function: &str) -> Vec<f64> {
        match function {
            "mass" => self.mass.clone(),
            "bias" => self.bias.clone(),
            "both" => [&self.mass[..], &self.bias[..]].concat(),
            _ => self.acceleration.clone(),
        }
    }

    /// Nanoseconds per evaluation. The function is chosen outside of the loop.
    fn time(&mut self, function: &str, count: usize) -> Result<f64, Box<dyn Error>> {
        self.run(function, 0)?;
        let start = Instant::now();
        for k in 0..count {
            let s = black_box(k % STATES);
            match function {
                "mass" => self.mass(s)?,
                "bias" => self.bias(s)?,
                "both" => {
                    self.mass(s)?;
                    self.bias(s)?;
                }
                _ => self.forward(s)?,
            }
        }
        Ok(start.elapsed().as_nanos() as f64 / count as f64)
    }
}

fn state(row: &[f64], joints: usize, floats: bool) -> Result<State, Box<dyn Error>> {
    let mut rest = row;
    let mut take = |count: usize| {
        let (these, others) = rest.split_at(count);
        rest = others;
        these.to_vec()
    };
    let base = if floats {
        let (place, twist) = (take(7), take(6));
        let turned = Quaternion::new(place[6], place[3], place[4], place[5]);
        let frame: Frame = Isometry3::from_parts(
            Translation3::new(place[0], place[1], place[2]),
            UnitQuaternion::from_quaternion(turned),
        );
        let twist = Twist::new(
            Vector3::from_row_slice(&twist[..3]),
            Vector3::from_row_slice(&twist[3..]),
        );
        BaseState::new(frame, twist, Twist::zeros())?
    } else {
        BaseState::stationary(Frame::identity())?
    };
    Ok(State {
        base,
        q: take(joints),
        v: take(joints),
        tau: take(joints + if floats { 6 } else { 0 }),
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, urdf] = &arguments[..] {
        let robot = Robot::from_urdf(urdf)?;
        for number in 0..robot.joint_count() {
            println!("{}", robot.joint_name(number)?);
        }
        return Ok(());
    }
    let [_, states, urdf, base] = &arguments[..] else {
        return Err("dynibo-driver STATES.txt ROBOT.urdf (fixed | floating)".into());
    };
    let floats = base == "floating";
    let (machine, joints, count) = if floats {
        let robot = FloatingRobot::from_urdf(urdf)?;
        let (joints, count) = (robot.joint_count(), robot.generalized_count());
        (Machine::Floating(robot), joints, count)
    } else {
        let robot = Robot::from_urdf(urdf)?;
        let (joints, count) = (robot.joint_count(), robot.generalized_count());
        (Machine::Fixed(robot), joints, count)
    };
    let mut rows = Vec::new();
    for line in std::fs::read_to_string(states)?.lines() {
        let row: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        rows.push(state(&row?, joints, floats)?);
    }
    let mut driver = Driver {
        machine,
        states: rows,
        zero: vec![0.0; joints],
        mass: vec![0.0; count * count],
        bias: vec![0.0; count],
        acceleration: vec![0.0; count],
    };
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let [command, function, number] = words[..] else {
            return Err(format!("`{line}` is no command").into());
        };
        let number: usize = number.parse()?;
        let answer = if command == "value" {
            driver.run(function, number)?;
            let texts: Vec<String> = driver
                .results(function)
                .iter()
                .map(f64::to_string)
                .collect();
            texts.join(" ")
        } else {
            driver.time(function, number)?.to_string()
        };
        println!("{answer}");
        std::io::stdout().flush()?;
    }
    Ok(())
}
