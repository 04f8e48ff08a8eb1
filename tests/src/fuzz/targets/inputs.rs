//! Inputs over time, as `simulate --inputs` reads them.

use super::{check_mistake, file};
use crate::fuzz::{Corpus, Input};
use dynamics_cli::inputs::Inputs;

pub(super) fn run(input: &Input) -> bool {
    let model = &Corpus::get().hosts()[input.host].compiled.model;
    let names: Vec<&str> = model.inputs.iter().map(|u| u.name.as_str()).collect();
    match Inputs::read(file(input).path(), &names) {
        Ok(inputs) => {
            check_inputs(&inputs, names.len());
            true
        }
        Err(mistake) => {
            check_mistake(&mistake);
            false
        }
    }
}

/// Corners come one after the other, to the last time, and there are values at each.
fn check_inputs(inputs: &Inputs, count: usize) {
    let (first, last) = inputs.range();
    assert!(first <= last && first.is_finite() && last.is_finite());
    let mut corner = first;
    while let Some(next) = inputs.next_corner(corner) {
        assert!(next > corner);
        assert_eq!(inputs.at(next).len(), count);
        corner = next;
    }
    assert_eq!(corner, last);
}
