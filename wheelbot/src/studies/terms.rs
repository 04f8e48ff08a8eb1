//! Which terms of the pivot's acceleration matter, [6.17] to [6.19], on a motion.

use super::replay::{Bench, Met};
use super::study::{Table, pivot};
use crate::robot::{PITCH, ROLL, WHEEL, YAW};
use crate::trial::{Row, rms};
use wheelbot_firmware::pivot::{Moving, Term, Terms, term};
use wheelbot_firmware::vector::{Attitude, dot};
use wheelbot_firmware::{INTERVAL, Settings};

/// The wheel's radius in the model, m.
const RADIUS: f64 = 0.053;

/// One line per term: its size from the true motion, and what the estimate loses without it.
pub fn table(title: &str, bench: &Bench, rows: &[Row]) -> Table {
    let met = Met::in_run(rows);
    let error = |terms| {
        let settings = Settings {
            terms,
            ..Settings::published()
        };
        bench.errors(settings, &met).felt
    };
    let both = |[roll, pitch]: [f64; 2]| [format!("{roll:.2}"), format!("{pitch:.2}")];
    let line = |one: Term| {
        let size = rms(sizes(one, rows).into_iter());
        let mut line = vec![one.equation().to_string(), format!("{size:.3}")];
        line.extend(both(error(Terms::NONE.with(one))));
        line.extend(both(error(Terms::ALL.without(one))));
        line
    };
    let mut lines: Vec<Vec<String>> = Term::ALL.map(line).to_vec();
    let whole = rms(rows.iter().map(|row| {
        let all = pivot(row);
        dot(all, all).sqrt()
    }));
    let [none, all] = [Terms::NONE, Terms::ALL].map(|terms| both(error(terms)));
    let mut last = vec!["all together".to_string(), format!("{whole:.3}")];
    last.extend(all);
    last.extend(none);
    lines.push(last);
    let header = [
        "term",
        "size, rms, m/s²",
        "roll error with it alone, °",
        "pitch error with it alone, °",
        "roll error without it, °",
        "pitch error without it, °",
    ];
    Table {
        title: title.into(),
        header: header.map(String::from).to_vec(),
        rows: lines,
    }
}

/// A term along the true motion, m/s².
pub fn sizes(one: Term, rows: &[Row]) -> Vec<f64> {
    let size = |pair: &[Row]| {
        let value = term(one, RADIUS, &attitude(&pair[1]), &moving(pair));
        dot(value, value).sqrt()
    };
    rows.windows(2).map(size).collect()
}

fn attitude(row: &Row) -> Attitude<f64> {
    Attitude::new(row.state.q[ROLL], row.state.q[PITCH])
}

/// What moves, from two ticks in a row.
fn moving(pair: &[Row]) -> Moving<f64> {
    let [before, after] = [&pair[0].state.v, &pair[1].state.v];
    let places = [ROLL, PITCH, YAW];
    let change = |value: [f64; 2]| (value[1] - value[0]) / INTERVAL;
    Moving {
        rates: places.map(|k| after[k]),
        accelerations: places.map(|k| change([before[k], after[k]])),
        wheel_rate: after[WHEEL] - after[PITCH],
        wheel_acceleration: change([before, after].map(|v| v[WHEEL] - v[PITCH])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::Sensing;
    use crate::trial::{Push, Trial};
    use wheelbot_firmware::Gains;

    /// [6.17] to [6.19] against the acceleration that the model's own sensor shows.
    #[test]
    fn all_terms_together_are_the_acceleration_of_the_wheel() {
        let mut trial = Trial::new(1.0, Gains::PUBLISHED);
        trial.start = crate::robot::leaning(0.1, 0.1);
        trial.start.v[YAW] = 4.0;
        trial.pushes = vec![Push {
            at: 0.2,
            seconds: 0.1,
            force: [1.0, 1.0],
        }];
        let rows = trial.run(&mut Sensing::new(1).unwrap()).unwrap().rows;
        let mut compared = 0;
        for row in &rows {
            // Accelerations as they are at this instant, not as differences.
            let plant = crate::robot::Wheelbot::nominal();
            let inputs = row.inputs;
            let shown = crate::robot::shown(&plant, &row.state, inputs).unwrap();
            let simulation = dynamics::Simulation::new(&plant);
            let a = simulation.acceleration(0.0, &row.state, inputs).unwrap().a;
            let v = row.state.v;
            let moving = Moving {
                rates: [v[ROLL], v[PITCH], v[YAW]],
                accelerations: [a[ROLL], a[PITCH], a[YAW]],
                wheel_rate: v[WHEEL] - v[PITCH],
                wheel_acceleration: a[WHEEL] - a[PITCH],
            };
            let found: [f64; 3] = Term::ALL.iter().fold([0.0; 3], |sum, one| {
                let x = term(*one, RADIUS, &attitude(row), &moving);
                core::array::from_fn(|k| sum[k] + x[k])
            });
            let expected = pivot(&Row { shown, ..*row });
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-8, "{found} {expected}");
                compared += 1;
            }
        }
        assert!(compared > 100);
    }
}
