//! A crane: what varies from lift to lift are the fields of a struct, everything else is
//! folded into the code.

use dynamics::integrate::State;
use dynamics::{Dual, Dynamics, Point, Scalar, Simulation, acceleration_full_rank};

/// The trolley's mass and gravity are numbers in the code. The functions are methods of the struct.
#[derive(Clone, Copy, Dynamics)]
#[dynamics(
    model = "crane.model",
    functions = "inverse_dynamics, inverse_dynamics_derivatives, forward_dynamics_derivatives"
)]
struct Crane<T> {
    /// Mass of the load, kg.
    load: T,
    /// Length of the rope, m.
    rope: T,
}

/// Sway after `seconds` of pushing the trolley with `force`, from rest: Runge–Kutta, 1 ms.
fn push(
    crane: &Crane<f64>,
    force: f64,
    seconds: f64,
) -> Result<f64, dynamics::constrained::SolveError> {
    let simulation = Simulation::new(crane);
    let mut state = State {
        q: [0.0; 2],
        v: [0.0; 2],
        z: [],
    };
    let step = 1e-3;
    for k in 0..(seconds / step).round() as u32 {
        state = simulation.rk4_step(step * f64::from(k), &state, step, |_, _| [force])?;
    }
    Ok(state.q[Crane::<f64>::Q_SWAY])
}

/// Square of the frequency of small sway, (rad/s)², from the derivative of the acceleration
/// by the angle; and how it changes with the rope, from the same with the length seeded.
fn sway(crane: &Crane<f64>) -> (f64, f64) {
    // Inside: the derivative by the angle. Outside: that by the length of the rope.
    type Number = Dual<Dual<f64, 1>, 1>;
    let number = Number::from_f64;
    let seeded = Crane {
        load: number(crane.load),
        rope: Dual::variable(Dual::constant(crane.rope), 0),
    };
    let angle = Dual::constant(Dual::variable(0.0, 0));
    let x = Point {
        t: number(0.0),
        q: [number(0.0), angle],
        v: [number(0.0); 2],
        u: [number(0.0)],
        z: [],
    };
    let slope = acceleration_full_rank(&seeded, &x, None).a[1];
    (-slope.re.eps[0], -slope.eps[0].eps[0])
}

/// The crane linearised where it hangs still: derivatives of the accelerations of trolley and
/// sway by the angle, and by the force.
fn linearised(crane: &Crane<f64>) -> [[f64; 2]; 2] {
    let slopes = crane.forward_dynamics_derivatives(&Point::zero());
    let by_angle = slopes
        .forward_dynamics_by_position
        .map(|row| row[Crane::<f64>::Q_SWAY]);
    let by_force = slopes
        .forward_dynamics_by_input
        .map(|row| row[Crane::<f64>::U_X]);
    [by_angle, by_force]
}

/// The force that accelerates the trolley by `a`, m/s², while the rope hangs straight.
fn force_to_start(crane: &Crane<f64>, a: f64) -> f64 {
    // What the trolley needs, so that the load is not accelerated: θ̈ = −a/l.
    crane.inverse_dynamics(&Point::zero(), &[a, -a / crane.rope])[0]
}

fn main() -> Result<(), dynamics::constrained::SolveError> {
    let nominal = Crane::nominal();
    let [[x, sway_by_angle], [_, by_force]] = linearised(&nominal);
    println!(
        "hanging still: {x:.2} m/s² and {sway_by_angle:.2} rad/s² per rad, {:.4} rad/s² per N; \
         {:.0} N start the trolley by 1 m/s²",
        by_force,
        force_to_start(&nominal, 1.0),
    );
    for rope in [3.0, 6.0, 12.0] {
        let crane = Crane { rope, ..nominal };
        let (square, slope) = sway(&crane);
        println!(
            "{rope:4} m of rope: one sway in {:.2} s, {:+.3} s per metre; {:+.2}° after 2 s of 100 N",
            std::f64::consts::TAU / square.sqrt(),
            -std::f64::consts::PI * slope / square.powf(1.5),
            push(&crane, 100.0, 2.0)?.to_degrees(),
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ω² = g/l (1 + m/M), M the trolley's 40 kg.
    #[test]
    fn frequency_is_that_of_the_textbook() {
        let crane = Crane {
            load: 90.0,
            rope: 4.0,
        };
        let (square, slope) = sway(&crane);
        let expected = 9.81 / 4.0 * (1.0 + 90.0 / 40.0);
        assert!((square - expected).abs() < 1e-12);
        assert!((slope + expected / 4.0).abs() < 1e-12);
    }

    /// Ẋ = A X + B u of the textbook: ẍ = m/M g θ + F/M, θ̈ = −ω² θ − F/(M l).
    #[test]
    fn linearisation_is_that_of_the_textbook() {
        let crane = Crane {
            load: 90.0,
            rope: 4.0,
        };
        let [[x, sway], [x_by_force, sway_by_force]] = linearised(&crane);
        assert!((x - 90.0 / 40.0 * 9.81).abs() < 1e-12, "{x}");
        assert!((sway + 9.81 / 4.0 * (1.0 + 90.0 / 40.0)).abs() < 1e-12);
        assert!((x_by_force - 1.0 / 40.0).abs() < 1e-15);
        assert!((sway_by_force + 1.0 / (40.0 * 4.0)).abs() < 1e-15);
    }

    /// The trolley alone is accelerated, and the inverse dynamics undo the linearised ones.
    #[test]
    fn inverse_dynamics_undo_forward_dynamics() {
        let crane = Crane::nominal();
        assert!((force_to_start(&crane, 1.0) - 40.0).abs() < 1e-12);
        let [by_angle, _] = linearised(&crane);
        // τ(θ, a(θ)) stays zero: ∂τ/∂θ at fixed a, and M ∂a/∂θ = −∂τ/∂θ.
        let hanging = crane.inverse_dynamics_derivatives(&Point::zero(), &[0.0; 2]);
        let rest = crane.inverse_dynamics(&Point::zero(), &by_angle);
        for (row, rest) in hanging.inverse_dynamics_by_position.iter().zip(rest) {
            assert!((row[1] + rest).abs() < 1e-10, "{} {rest}", row[1]);
        }
    }

    /// At first the trolley moves as if the load were not there: θ̈ = -F/(M l).
    #[test]
    fn a_push_swings_the_load_back() {
        let crane = Crane::nominal();
        let angle = push(&crane, 100.0, 0.01).unwrap();
        let expected = -0.5 * 100.0 / (40.0 * 6.0) * 0.01_f64.powi(2);
        assert!((angle / expected - 1.0).abs() < 1e-3, "{angle} {expected}");
    }
}
