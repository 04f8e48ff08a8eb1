//! A skate on a slope: the module of the model is built by `build.rs`, with every parameter
//! variable.

use dynamics::constrained::SolveError;
use dynamics::integrate::State;
use dynamics::{Dual, Point, Simulation, acceleration_full_rank};

/// What `build.rs` made of `skate.model`.
#[allow(
    dead_code,
    clippy::all,
    reason = "a model offers more than one program uses"
)]
mod skate {
    include!(concat!(env!("OUT_DIR"), "/skate.rs"));
}

use skate::{Parameters, Q_HEADING, Q_X, Q_Y, Skate, constrained_dynamics_derivatives};

/// The position after `seconds`, released from rest across the slope and spinning with `spin`, rad/s.
fn glide(skate: &Skate<f64>, spin: f64, seconds: f64) -> Result<State<f64, 3, 0>, SolveError> {
    let simulation = Simulation::new(skate);
    let mut state = State {
        q: [0.0; 3],
        v: [0.0, 0.0, spin],
        z: [],
    };
    let step = 1e-3;
    for k in 0..(seconds / step).round() as u32 {
        state = simulation.rk4_step(step * f64::from(k), &state, step, |_, _| [])?;
    }
    Ok(state)
}

/// The force on the blade at rest, N, and its derivative by the angle of the slope, N/rad:
/// multipliers through dual numbers.
fn side_force(skate: &Skate<f64>) -> (f64, f64) {
    let mut parameters = skate.parameters.map(Dual::<f64, 1>::constant);
    parameters.slope = Dual::variable(skate.parameters.slope, 0);
    let seeded = Skate { parameters };
    let force = acceleration_full_rank(&seeded, &Point::zero(), None).constraint_force[1];
    (force.re, force.eps[0])
}

/// How the acceleration across and up the slope changes with the heading, m/s² per rad, at rest.
fn turning(skate: &Skate<f64>, heading: f64) -> [f64; 2] {
    let mut x = Point::zero();
    x.q[Q_HEADING] = heading;
    let slopes = constrained_dynamics_derivatives(&skate.parameters, &x);
    let slopes = slopes.constrained_acceleration_by_position;
    [slopes[Q_X][Q_HEADING], slopes[Q_Y][Q_HEADING]]
}

fn main() -> Result<(), SolveError> {
    let parameters = Parameters {
        slope: 0.2,
        ..Parameters::nominal()
    };
    let skate = Skate { parameters };
    let (force, derivative) = side_force(&skate);
    println!("across the slope the blade carries {force:.1} N, {derivative:+.1} N per radian more");
    let [start, _] = turning(&skate, 0.0);
    println!("turned out of rest across the slope it speeds up by {start:.2} m/s² per radian");
    for seconds in [1.0, 2.0, 4.0, 8.0] {
        let q = glide(&skate, 1.0, seconds)?.q;
        let (x, y) = (q[Q_X], q[Q_Y]);
        println!("after {seconds} s: {x:7.3} m across, {y:+7.3} m up");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From rest, the speed along the blade is k (cos ωt − 1) with k = g sin(slope)/ω, so
    /// x = k (t/2 + sin(2ωt)/(4ω) − sin(ωt)/ω) and y = −k (1 − cos ωt)²/(2ω): the skate
    /// drifts across the slope and comes back up (Neimark and Fufaev 1972).
    #[test]
    fn the_spinning_skate_comes_back_up() {
        let skate = Skate {
            parameters: Parameters::nominal(),
        };
        let spin = 1.5;
        let k = 9.81 * 0.1_f64.sin() / spin;
        for seconds in [0.5, 2.0, 7.0] {
            let [x, y, heading] = glide(&skate, spin, seconds).unwrap().q;
            let angle = spin * seconds;
            assert!((heading - angle).abs() < 1e-9);
            let wave = (2.0 * angle).sin() / 4.0 - angle.sin();
            let expected = k * (seconds / 2.0 + wave / spin);
            assert!((x - expected).abs() < 1e-6, "{x} {expected}");
            let expected = -k * (1.0 - angle.cos()).powi(2) / (2.0 * spin);
            assert!((y - expected).abs() < 1e-6, "{y} {expected}");
        }
    }

    /// Along the blade a = −g sin(slope) sin θ: ẍ = −g sin(slope) sin 2θ/2, ÿ = −g sin(slope) sin² θ.
    #[test]
    fn derivatives_are_those_of_the_inclined_plane() {
        let skate = Skate {
            parameters: Parameters::nominal(),
        };
        let pull = -9.81 * 0.1_f64.sin();
        for heading in [0.0, 0.4, -1.3] {
            let [across, up] = turning(&skate, heading);
            assert!((across - pull * (2.0 * heading).cos()).abs() < 1e-12);
            assert!((up - pull * (2.0 * heading).sin()).abs() < 1e-12);
        }
    }

    /// What the blade does not take up has to be supplied: all of it without the blade.
    #[test]
    fn inverse_dynamics_hold_the_weight() {
        let skate: Skate<f64> = Skate {
            parameters: Parameters::nominal(),
        };
        let [x, y, turn] = skate::inverse_dynamics(&skate.parameters, &Point::zero(), &[0.0; 3]);
        assert!(x.abs() < 1e-12 && turn.abs() < 1e-12);
        assert!((y - 60.0 * 9.81 * 0.1_f64.sin()).abs() < 1e-9);
    }

    /// m g sin(slope), and m g cos(slope) per radian.
    #[test]
    fn the_blade_carries_the_weight_along_the_slope() {
        let (force, derivative) = side_force(&Skate {
            parameters: Parameters::nominal(),
        });
        assert!((force - 60.0 * 9.81 * 0.1_f64.sin()).abs() < 1e-9);
        assert!((derivative - 60.0 * 9.81 * 0.1_f64.cos()).abs() < 1e-9);
    }
}
