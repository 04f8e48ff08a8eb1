//! A wheel that tests turn: what its log says.

use crate::log::Log;
use crate::trace::{Outcome, Request, Silent, trace};
use dynamics_codegen::Library;
use std::collections::BTreeMap;

/// What `trace` makes of a log of the wheel `model`, given as CSV.
pub(super) fn traced(model: &str, log: &str) -> Outcome {
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
pub(super) fn rectangular(seed: u64) -> impl FnMut() -> f64 {
    let mut random = seed;
    move || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}
