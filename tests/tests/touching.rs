//! Contacts in generated code: held by constraints that come and go, with friction, it moves as the
//! machine of `identify` does.

use dynamics::constrained::Tolerance;
use dynamics::{Point, System as _, acceleration};
use identify::machine::{Machine, States};
use integration_tests::models;

/// The generated module of the model with contacts.
#[path = "fixtures/touching.rs"]
pub mod touching;

use touching::{COORDINATES, INPUTS, Touching};

/// A state; the drive is also what closes the feeler's contact.
fn place(drive: f64) -> Point<f64, COORDINATES, INPUTS, 0> {
    let mut u = [0.0; INPUTS];
    u[0] = drive;
    Point {
        t: 0.3,
        q: [0.1, -0.2, 0.4, 0.3, 0.2, 0.5, -0.4],
        v: [0.6, 0.1, 0.3, -0.2, 0.1, 2.0, 0.4],
        u,
        z: [],
    }
}

fn machine_states(x: &Point<f64, COORDINATES, INPUTS, 0>, inputs: usize) -> States {
    let column = |values: &[f64]| values.iter().map(|&x| vec![x]).collect();
    States {
        t: vec![x.t],
        q: column(&x.q),
        v: column(&x.v),
        u: column(&x.u[..inputs]),
        ..States::default()
    }
}

#[test]
fn held_and_open_contacts_move_alike() {
    let machine = Machine::new(models::read(models::TOUCHING));
    let values = machine.nominal_parameters();
    let touching = Touching::<f64>::nominal();
    // The multipliers stand behind the inputs.
    assert_eq!(touching.multipliers_at(), Some(machine.input_count()));
    for drive in [1.5, 0.4, -0.7] {
        let x = place(drive);
        let states = machine_states(&x, machine.input_count());
        let motion = machine.motion(&states, &values).unwrap().remove(0);
        let solution = acceleration(&touching, &x, None, &Tolerance::default()).unwrap();
        for (a, b) in solution.a.iter().zip(motion.acceleration.iter()) {
            assert!(
                (a - b).abs() < 1e-9 * (1.0 + b.abs()),
                "drive {drive}: {a} {b}"
            );
        }
        for (a, b) in solution.lambda.iter().zip(motion.multiplier.iter()) {
            assert!(
                (a - b).abs() < 1e-9 * (1.0 + b.abs()),
                "drive {drive}: {a} {b}"
            );
        }
        // The second constraint holds where the drive is above zero, and not elsewhere.
        assert_eq!(motion.multiplier[1] != 0.0, drive > 0.0);
    }
}
