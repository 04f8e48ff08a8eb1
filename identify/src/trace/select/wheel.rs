//! Small machines that tests turn, a wheel among them: what their logs say.

use crate::log::Log;
use crate::trace::{Outcome, Request, Silent, trace};
use dynamics_codegen::Library;
use std::collections::BTreeMap;

/// A wheel with a motor.
pub(in crate::trace) const WHEEL: &str = "\
model wheel;
coordinate angle: rad;
input motor: N*m;
parameter i: kg*m^2 = 0.02;
kinetic i/2*dot(angle)^2;
force angle = input(motor);
";

/// What `trace` makes of a log of the small machine `model`, given as CSV.
pub(in crate::trace) fn traced(model: &str, log: &str) -> Outcome {
    let outcome = trace(&Request {
        model_name: "wheel",
        model_text: model,
        library: &Library::builtin(),
        parameters: BTreeMap::new(),
        train: &Log::from_bytes("wheel.csv", log.as_bytes()).unwrap(),
        test: None,
        hold: None,
        horizon: 0.5,
        seed: 1,
        progress: &Silent,
    });
    outcome.unwrap()
}

/// An encoder's rectangular noise, from −0.5 to 0.5, by a linear congruence.
pub(in crate::trace) fn rectangular(seed: u64) -> impl FnMut() -> f64 {
    let mut random = seed;
    move || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}
