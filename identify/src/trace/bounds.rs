//! Steps of parameters that have bounds.

use super::dictionary::Dictionary;
use crate::regression::Gram;
use nalgebra::DVector;

/// Places of the columns that a step moves: all, but parameters that rest at a bound, beyond which the linear equation
/// would have them. With these among them it would move others by what it cannot move them by.
pub(super) fn free_places(
    dictionary: &Dictionary,
    (parameters, values): (&[usize], &[f64]),
    (gram, all): (&Gram, &[usize]),
) -> Vec<usize> {
    let model = &dictionary.machine.compiled.model;
    let mut free = all.to_vec();
    loop {
        let fit = gram.fit(&free);
        let leads_out = |(&place, &step): (&usize, &f64)| {
            let Some(&index) = parameters.get(place) else {
                return false;
            };
            let (value, parameter) = (values[index], &model.parameters[index]);
            value <= parameter.lower && step < 0.0 || value >= parameter.upper && step > 0.0
        };
        let steps = free.iter().zip(fit.coefficients.iter());
        let kept: Vec<usize> = steps
            .filter(|step| !leads_out(*step))
            .map(|(&place, _)| place)
            .collect();
        if kept.len() == free.len() {
            return free;
        }
        free = kept;
    }
}

/// A step that keeps the values inside their bounds and not too far from the old ones.
pub(super) fn limited(
    dictionary: &Dictionary,
    parameters: &[usize],
    values: &[f64],
    step: &DVector<f64>,
) -> DVector<f64> {
    let model = &dictionary.machine.compiled.model;
    DVector::from_fn(parameters.len(), |i, _| {
        let (old, parameter) = (values[parameters[i]], &model.parameters[parameters[i]]);
        let mut new = old + step[i];
        // Quantities that are positive by nature change by a factor at most.
        if parameter.lower > 0.0 {
            let size = old.max(parameter.lower);
            new = new.clamp(size / 2.0, size * 2.0);
        }
        new.clamp(parameter.lower, parameter.upper) - old
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::dictionary::{Ranges, Source};
    use dynamics_codegen::Library;
    use nalgebra::DMatrix;
    use std::collections::BTreeMap;

    /// A model with one parameter, a mass of 2 kg between 0.5 and 3.
    fn mass() -> Dictionary {
        let source = Source {
            name: "mass",
            text: "model mass; coordinate x: m; input x: N; parameter m: kg = 2 in 0.5..3;
                   kinetic m/2*dot(x)^2; force x = input(x);",
            library: &Library::empty(),
            parameters: &BTreeMap::new(),
        };
        let ranges = Ranges {
            positions: vec![vec![0.0, 1.0]],
            speeds: vec![1.0],
            inputs: vec![vec![0.0, 1.0]],
            measured: vec![true],
            sensors: Vec::new(),
            missing: Vec::new(),
        };
        Dictionary::new(&source, &ranges).unwrap()
    }

    /// A mass whose column is nearly that of what else is fitted: at a bound it moves inwards alone, and takes nothing
    /// of the others' steps with it.
    #[test]
    fn what_rests_at_a_bound_takes_no_part_in_a_step() {
        let dictionary = mass();
        let places = |value: f64, wanted: f64| {
            let rows = (0..30).flat_map(|k| {
                let x = f64::from(k);
                let [own, other] = [x.sin(), x.sin() + 0.1 * x.cos()];
                [wanted * own + 0.5 * other, own, other]
            });
            let rows = DMatrix::from_row_iterator(30, 3, rows);
            let gram = Gram::new(&rows, std::slice::from_ref(&(0..30)), 30);
            super::free_places(&dictionary, (&[0], &[value]), (&gram, &[0, 1]))
        };
        for (value, wanted) in [(0.5, -0.2), (3.0, 0.2)] {
            assert_eq!(places(value, wanted), [1], "{value}");
            assert_eq!(places(value, -wanted), [0, 1], "{value}");
            assert_eq!(places(1.0, wanted), [0, 1]);
        }
    }

    /// Whatever a step begins with, and wherever it leads.
    #[test]
    fn steps_stay_within_bounds() {
        let dictionary = mass();
        let after = |value: f64, step: f64| {
            let step = DVector::from_element(1, step);
            value + limited(&dictionary, &[0], &[value], &step)[0]
        };
        assert_eq!(after(2.0, 0.1), 2.1);
        assert_eq!(after(2.0, 9.0), 3.0);
        assert_eq!(after(2.0, -1.9), 1.0);
        assert_eq!(after(1.2, 9.0), 2.4);
        for value in [-4.0, -0.1, 0.0, 7.0] {
            assert!((0.5..=3.0).contains(&after(value, 0.3)), "{value}");
        }
    }
}
