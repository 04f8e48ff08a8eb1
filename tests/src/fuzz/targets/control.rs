//! A controller, as `simulate --control` reads it.

use super::{check_mistake, file};
use crate::fuzz::{Corpus, Input};
use dynamics_cli::simulation::Controller;

/// Samples that are taken: more than most delays.
const SAMPLES: usize = 10;
/// More readings than a model has.
const READINGS: usize = 1000;

pub(super) fn run(input: &Input) -> bool {
    let model = &Corpus::get().hosts()[input.host].compiled.model;
    match Controller::read(file(input).path(), model) {
        Ok(controller) => {
            check_controller(controller);
            true
        }
        Err(mistake) => {
            check_mistake(&mistake);
            false
        }
    }
}

/// A command has a value for every input that is commanded.
fn check_controller(mut controller: Controller) {
    assert!(controller.interval > 0.0);
    let count = controller.inputs.len();
    let readings: Vec<f64> = (0..READINGS).map(|k| (k as f64).sin()).collect();
    for k in 0..SAMPLES {
        let t = k as f64 * controller.interval;
        if let Some(command) = controller.sample(t, &readings, &vec![0.0; count]) {
            assert_eq!(command.len(), count);
        }
    }
}
