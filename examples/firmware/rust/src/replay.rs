//! What runs, whatever the machine.

use crate::recorded::{RECORDS, Record, START};
use crate::target::Target;
use dynamics::Point;
use generated::wheelbot::{Parameters, constrained_dynamics};
use wheelbot_firmware::{Balance, Estimator, Firmware, Gains, Readings, Settings};

/// The nine numbers that are printed of a tick, or of an evaluation of the equation of motion.
type Results = [f32; 9];

/// Everything, printed line by line.
pub fn run(target: &mut impl Target) {
    let balance = Balance {
        gains: Gains::PUBLISHED.cast(),
        bias: [0.0; 2],
    };
    let mut firmware = Firmware::new(Estimator::new(Settings::published(), START), balance);
    for record in &RECORDS {
        let readings = Readings {
            gyroscopes: record.gyroscopes,
            accelerometers: record.accelerometers,
            reaction: record.reaction,
            rolling: record.rolling,
        };
        let (cost, results) = target.cost(|| tick(&mut firmware, &readings));
        target.print("tick", cost, &results);
    }
    for record in &RECORDS {
        let (cost, results) = target.cost(|| motion(record));
        target.print("motion", cost, &results);
    }
}

/// Tilt, rates, tilt by the accelerometers alone, currents.
#[inline(never)]
fn tick(firmware: &mut Firmware<f32>, readings: &Readings<f32>) -> Results {
    let (tilt, currents) = firmware.tick(readings, [0.0; 2]);
    let ([a, b], [c, d, e], [f, g], [h, i]) = (tilt.fused, tilt.rates, tilt.felt, currents);
    [a, b, c, d, e, f, g, h, i]
}

/// Accelerations and multipliers.
#[inline(never)]
fn motion(record: &Record) -> Results {
    let point = Point {
        t: 0.0,
        q: record.q,
        v: record.v,
        u: record.u,
        z: [],
    };
    let found = constrained_dynamics(&Parameters::nominal(), &point);
    let [a, b, c, d, e, f, g] = found.constrained_acceleration;
    let [h, i] = found.constrained_multipliers;
    [a, b, c, d, e, f, g, h, i]
}
