//! The machine: `models/wheelbot.model` with its instruments, as Rust and as a compiled model.

use dynamics::Point;
use dynamics::constrained::SolveError;
use dynamics::integrate::State as Motion;
use dynamics::{Simulation, constrained::Baumgarte};
use dynamics_codegen::diagnostic::Report;
use dynamics_codegen::{Compiled, Library, compile};

/// What `build.rs` made of the model.
#[allow(
    dead_code,
    missing_docs,
    clippy::all,
    reason = "a model offers more than one program uses"
)]
mod model {
    include!(concat!(env!("OUT_DIR"), "/wheelbot.rs"));
}

pub use model::Wheelbot;

/// Coordinates and their rates: `x, y, roll, pitch, yaw, wheel, reaction`.
pub type State = Motion<f64, 7, 0>;

/// Places of the coordinates: the contact point, m,
pub const X: usize = 0;
/// its second coordinate, m,
pub const Y: usize = 1;
/// `q₁`, rad,
pub const ROLL: usize = 2;
/// `q₂`, rad,
pub const PITCH: usize = 3;
/// `q₃`, rad,
pub const YAW: usize = 4;
/// `q₄`, rad,
pub const WHEEL: usize = 5;
/// and `q₅`, rad.
pub const REACTION: usize = 6;

/// What acts: torques of the reaction wheel and of the rolling wheel, N·m, and a push at the axle of
/// the reaction wheel along the heading, forward and to the left, N.
pub type Inputs = [f64; 4];

/// How many numbers the instruments show.
pub const INSTRUMENTS: usize = 29;

/// 1/s. RK4 lets the wheel slip by a part in 10⁹ of its speed in a second; this takes that back.
const STABILISATION: f64 = 10.0;

/// The model with its instruments, from its text.
///
/// # Errors
/// If the text is no model: only after an edit of it that the build script would refuse.
pub fn compiled() -> Result<Compiled, Report> {
    let text = include_str!(concat!(env!("OUT_DIR"), "/wheelbot.model"));
    compile("wheelbot.model", text, &Library::builtin())
}

/// The state of rest upright but for roll and pitch, rad.
pub fn leaning(roll: f64, pitch: f64) -> State {
    let mut q = [0.0; 7];
    (q[ROLL], q[PITCH]) = (roll, pitch);
    // The encoder is at zero.
    q[WHEEL] = pitch;
    State {
        q,
        v: [0.0; 7],
        z: [],
    }
}

/// The state `step` seconds later under constant inputs: one Runge–Kutta step of fourth order.
///
/// # Errors
/// If the equation of motion has no solution there.
pub fn advanced(
    plant: &Wheelbot<f64>,
    state: &State,
    inputs: Inputs,
    step: f64,
) -> Result<State, SolveError> {
    let simulation = Simulation::new(plant).with_baumgarte(Baumgarte::critical(STABILISATION));
    simulation.rk4_step(0.0, state, step, |_, _| inputs)
}

/// What the instruments show without noise, in the order of the model's sensors.
///
/// # Errors
/// If the equation of motion has no solution there.
pub fn shown(
    plant: &Wheelbot<f64>,
    state: &State,
    inputs: Inputs,
) -> Result<[f64; INSTRUMENTS], SolveError> {
    let solution = Simulation::new(plant).acceleration(0.0, state, inputs)?;
    let acceleration = core::array::from_fn(|i| solution.a[i]);
    Ok(shown_at(plant, state, acceleration))
}

/// What the instruments show at stated accelerations: of a robot that a hand moves.
pub fn shown_at(
    plant: &Wheelbot<f64>,
    state: &State,
    acceleration: [f64; 7],
) -> [f64; INSTRUMENTS] {
    let point = Point {
        t: 0.0,
        q: state.q,
        v: state.v,
        u: [0.0; 4],
        z: [],
    };
    model::sensors(&plant.parameters, &point, &acceleration, &[0.0; 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The generated module and the compiled text are of one model.
    #[test]
    fn instruments_are_those_of_the_text() {
        let sensors = compiled().unwrap().model.sensors;
        assert_eq!(sensors.len(), INSTRUMENTS);
        assert_eq!(sensors[24].name, "rolling");
        assert_eq!(sensors[26].name, "pivot_x");
    }

    /// Rolled freely for a second without torque it keeps its energy and does not slip.
    #[test]
    fn a_free_roll_keeps_energy_and_contact() {
        let plant = Wheelbot::nominal();
        let mut state = leaning(0.1, 0.05);
        (state.v[WHEEL], state.v[YAW]) = (20.0, 0.5);
        state.v[X] = 20.0 * plant.parameters.r_w;
        let energy = |state: &State| {
            let point = Point {
                t: 0.0,
                q: state.q,
                v: state.v,
                u: [0.0; 4],
                z: [],
            };
            let mass = model::mass_matrix(&plant.parameters, &point);
            let kinetic: f64 = (0..49)
                .map(|k| 0.5 * state.v[k / 7] * mass[k / 7][k % 7] * state.v[k % 7])
                .sum();
            let p = &plant.parameters;
            let (up, along) = (state.q[ROLL].cos(), state.q[PITCH].cos());
            let hub = p.r_w * up;
            let heights = [
                (p.m_w, hub),
                (p.m_b, hub + p.l_wb * up * along),
                (p.m_r, hub + (p.l_wb + p.l_br) * up * along),
            ];
            kinetic + heights.iter().map(|(m, h)| m * p.g * h).sum::<f64>()
        };
        let before = energy(&state);
        for _ in 0..500 {
            state = advanced(&plant, &state, [0.0; 4], 1e-3).unwrap();
        }
        assert!((energy(&state) - before).abs() < 1e-6 * before);
        let slip = state.v[X] - plant.parameters.r_w * state.v[WHEEL] * state.q[YAW].cos();
        assert!(slip.abs() < 1e-8, "{slip}");
    }
}
