//! Where on its body an effect sits.
//!
//! A heavy load near a joint and a light one far from it have the same inertia about the joint:
//! mass and place lie in a narrow, curved valley, in which steps of all at once get stuck. With
//! the mass fitted anew for each place (variable projection) the way along it is open.

use super::fit::Fitted;
use crate::regression::ErrorDynamics;
use crate::trace::dictionary::Dictionary;
use crate::trace::estimate::Observed;
use crate::trace::refine::Explanation;
use crate::trace::screen::Assignment;
use crate::trace::settings::{GLANCE, SAME_FIT, SHAPE_STEPS};
use crate::trace::settle::{Adapt, settle};
use rayon::prelude::*;

/// An effect in some shape, with the strengths that suit it there.
struct Placed {
    cost: f64,
    shape: Assignment,
    strengths: Assignment,
}

/// The start of a fit of a hypothesis with one of its terms in the shape in which it explains most,
/// if that is another than it has.
pub fn placed(dictionary: &Dictionary, fitted: &Fitted, term: usize) -> Option<Explanation> {
    let explanation = &fitted.explanation;
    let part = explanation.observed.excerpt(GLANCE);
    let observed = part.as_ref().unwrap_or(&explanation.observed);
    let of = |shape: Assignment| at(dictionary, fitted, term, shape, observed);
    let candidate = &dictionary.candidates[term];
    let is_shape = |p: &&usize| candidate.shapes[0].iter().any(|(shape, _)| shape == *p);
    let shape = candidate.parameters.iter().filter(is_shape);
    let begun = of(shape.map(|&p| (p, explanation.values[p])).collect())?;
    let known = begun.cost;
    let mut steps = spacing(dictionary, term, &begun.shape);
    let mut best = begun;
    for tried in 0..SHAPE_STEPS {
        // What is near the fit has found by itself.
        if best.cost == known && tried >= SHAPE_STEPS / 3 {
            return None;
        }
        let ways: Vec<(usize, f64)> = (0..steps.len())
            .flat_map(|i| [(i, 0.5 * steps[i]), (i, -0.5 * steps[i])])
            .collect();
        let places = ways.into_par_iter().filter_map(|(i, by)| {
            let mut shape = best.shape.clone();
            shape[i].1 += by;
            of(shape)
        });
        let places: Vec<Placed> = places.collect();
        let next = places.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        match next.filter(|next| next.cost < best.cost) {
            Some(next) => best = next,
            None => steps.iter_mut().for_each(|step| *step *= 0.5),
        }
    }
    let is_better = best.cost < known - SAME_FIT;
    let mut start = explanation.clone();
    for (parameter, value) in best.shape.into_iter().chain(best.strengths) {
        start.values[parameter] = value;
    }
    is_better.then_some(start)
}

/// How far apart the values of each shape parameter are that were tried.
fn spacing(dictionary: &Dictionary, candidate: usize, shape: &Assignment) -> Vec<f64> {
    let shapes = &dictionary.candidates[candidate].shapes;
    let spacing = |&(parameter, _): &(usize, f64)| {
        let all = shapes.iter().flatten().filter(|(p, _)| *p == parameter);
        let mut values: Vec<f64> = all.map(|(_, value)| *value).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let gaps = values.windows(2).map(|pair| pair[1] - pair[0]);
        gaps.fold(0.0, f64::max)
    };
    shape.iter().map(spacing).collect()
}

/// The cost of a linear fit of all terms with one of them in some shape, under the noise of the fit that it is to
/// better; `None` where its strengths cannot be.
fn at(
    dictionary: &Dictionary,
    fitted: &Fitted,
    term: usize,
    shape: Assignment,
    observed: &Observed,
) -> Option<Placed> {
    let own = &dictionary.candidates[term];
    let bounds = &dictionary.machine.compiled.model.parameters;
    let inside = |p: usize, value: f64| (bounds[p].lower..=bounds[p].upper).contains(&value);
    if !shape.iter().all(|&(p, value)| inside(p, value)) {
        return None;
    }
    let all = fitted.hypothesis.candidates();
    let mut values = fitted.explanation.values.clone();
    for &(parameter, value) in &shape {
        values[parameter] = value;
    }
    let focus = dictionary.focus(all);
    let parameters = focus.values(&values);
    let dynamics = ErrorDynamics::new(
        focus.mover(observed, &parameters),
        &[focus.columns(observed, &parameters)],
        &observed.curve,
        observed.hold,
        &observed.correlation,
    );
    let dynamics = dynamics.ok()?;
    let readings = observed.readings(&focus, &values, &dynamics.accelerations());
    let order = dictionary.parameters_of(all);
    let is_fitted = |p: &usize| !own.parameters.contains(p) || own.strengths.contains(p);
    let fitted_columns: Vec<usize> = (0..order.len()).filter(|&i| is_fitted(&order[i])).collect();
    let mut noise = fitted.explanation.noise.clone();
    let settled = settle(
        &dynamics,
        &readings,
        &fitted_columns,
        &mut noise,
        Adapt::Not,
    );
    let steps = fitted_columns.iter().zip(settled.fit.coefficients.iter());
    let strengths: Assignment = steps
        .filter(|(i, _)| own.strengths.contains(&order[**i]))
        .map(|(&i, step)| (order[i], values[order[i]] + step))
        .collect();
    let cost = settled.cost_of_fit();
    let possible = strengths.iter().all(|&(p, value)| inside(p, value));
    (possible && cost.is_finite()).then_some(Placed {
        cost,
        shape,
        strengths,
    })
}
