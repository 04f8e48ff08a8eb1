//! Small machines that tests turn, a wheel among them: what their logs say.

use super::linearised::first_noise;
use crate::log::Log;
use crate::regression::Hold;
use crate::trace::dictionary::{Dictionary, Source};
use crate::trace::estimate::Observed;
use crate::trace::refine::Explanation;
use crate::trace::{Outcome, Request, trace};
use dynamics_codegen::Library;
use std::collections::BTreeMap;
use std::fmt::Write;

/// A wheel with a motor.
pub(super) const WHEEL: &str = "\
model wheel;
coordinate angle: rad;
input motor: N*m;
parameter i: kg*m^2 = 0.02;
kinetic i/2*dot(angle)^2;
force angle = input(motor);
";

/// What `trace` makes of a log of the small machine `model`, given as CSV.
pub(super) fn traced(model: &str, log: &str) -> Outcome {
    let log = Log::from_bytes("wheel.csv", log.as_bytes()).unwrap();
    trace(&Request::new("wheel", model, &Library::builtin(), &log)).unwrap()
}

/// What a search for what the small machine `model` lacks begins with: the candidates, and the
/// model as given beside its log. Of this coordinate and this input.
pub(super) fn begun(
    model: &str,
    log: &str,
    [coordinate, input]: [&str; 2],
) -> (Dictionary, Explanation) {
    begun_with(model, log, [&[coordinate], &[input]])
}

/// The same of these coordinates and these inputs.
pub(super) fn begun_with(
    model: &str,
    log: &str,
    channels: [&[&str]; 2],
) -> (Dictionary, Explanation) {
    let source = Source {
        name: "wheel",
        text: model,
        library: &Library::builtin(),
        parameters: &BTreeMap::new(),
    };
    let log = Log::from_bytes("wheel.csv", log.as_bytes()).unwrap();
    let names = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
    let [coordinates, inputs] = channels.map(names);
    let record = log.select(&coordinates, &inputs);
    let observed = Observed::new(record.unwrap(), Hold::Linear).unwrap();
    let dictionary = Dictionary::new(&source, &observed.ranges()).unwrap();
    let start = Explanation {
        noise: first_noise(&dictionary.focus(&[]), &observed, &dictionary.defaults).unwrap(),
        values: dictionary.defaults.clone(),
        observed,
    };
    (dictionary, start)
}

/// A log of the wheel, 10 s at 200 Hz: it turns along two `waves` (rad, rad/s), read with so much `noise`, rad, by the
/// torque that `torque` says of its position, velocity and acceleration.
pub(super) fn turned(
    waves: [(f64, f64); 2],
    noise: (u64, f64),
    torque: impl Fn([f64; 3]) -> f64,
) -> String {
    turned_for(2000, waves, noise, torque)
}

/// The same in so many samples.
pub(super) fn turned_for(
    samples: u32,
    waves: [(f64, f64); 2],
    (seed, noise): (u64, f64),
    torque: impl Fn([f64; 3]) -> f64,
) -> String {
    let mut text = String::from("t,q_angle,u_motor\n");
    let mut random = rectangular(seed);
    for k in 0..samples {
        let t = 0.005 * f64::from(k);
        let [q, v, a] = waves.iter().fold([0.0; 3], |[q, v, a], &(size, w)| {
            let (sin, cos) = (w * t).sin_cos();
            [q + size * sin, v + size * w * cos, a - size * w * w * sin]
        });
        let read = q + noise * random();
        writeln!(text, "{t},{read},{}", torque([q, v, a])).unwrap();
    }
    text
}

/// The candidate that is called so.
pub(super) fn named(dictionary: &Dictionary, name: &str) -> usize {
    let mut candidates = dictionary.candidates.iter();
    let place = candidates.position(|c| c.subject.to_string() == name);
    place.unwrap()
}

/// An encoder's rectangular noise, from −0.5 to 0.5, by a linear congruence.
pub(super) fn rectangular(seed: u64) -> impl FnMut() -> f64 {
    let mut random = seed;
    move || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}
