//! Where on its body an effect sits, before it is fitted.
//!
//! A heavy load near a joint and a light one far from it have the same inertia about the joint:
//! mass and place lie in a narrow, curved valley, in which steps of all at once get stuck. With
//! the mass fitted anew for each place (variable projection) the way along it is open.

use super::search::{Attempt, Search};
use crate::regression::{Columns, ErrorDynamics};
use crate::trace::estimate::Observed;
use crate::trace::refine::{Adapt, settle};
use crate::trace::screen::{Assignment, Considered};
use rayon::prelude::*;

/// Steps of the search for a place; each goes one way or halves its length.
const STEPS: usize = 12;
/// Samples that it looks at.
const SAMPLES: usize = 1500;

/// An effect at a place, with the strengths that suit it there.
struct Placed {
    cost: f64,
    shape: Assignment,
    strengths: Assignment,
}

impl Search<'_> {
    /// The fit of an effect on a body, begun where on it the effect explains most, if that
    /// is better than `attempt`.
    pub(super) fn placed_better(&self, leader: &Considered, attempt: &Attempt) -> Option<Attempt> {
        let observed = &self.current.explanation.observed;
        let part = observed.excerpt(SAMPLES);
        let observed = part.as_ref().unwrap_or(observed);
        let mut best = self.placed(leader.candidate, self.shape_of(leader), observed)?;
        let mut steps = self.spacing(leader.candidate, &best.shape);
        for _ in 0..STEPS {
            let ways: Vec<(usize, f64)> = (0..steps.len())
                .flat_map(|i| [(i, 0.5 * steps[i]), (i, -0.5 * steps[i])])
                .collect();
            let places = ways.into_par_iter().filter_map(|(i, by)| {
                let mut shape = best.shape.clone();
                shape[i].1 += by;
                self.placed(leader.candidate, shape, observed)
            });
            let places: Vec<Placed> = places.collect();
            let next = places
                .into_iter()
                .min_by(|a, b| a.cost.total_cmp(&b.cost))
                .filter(|next| next.cost < best.cost);
            match next {
                Some(next) => best = next,
                None => steps.iter_mut().for_each(|step| *step *= 0.5),
            }
        }
        let values = [best.shape, best.strengths].concat();
        let placed = Considered {
            values,
            ..leader.clone()
        };
        let again = self.attempt(&[&placed]).ok()?;
        (again.cost < attempt.cost).then_some(again)
    }

    fn shape_of(&self, leader: &Considered) -> Assignment {
        let shapes = &self.dictionary.candidates[leader.candidate].shapes[0];
        let is_shape = |p: &usize| shapes.iter().any(|(shape, _)| shape == p);
        let values = leader.values.iter().copied();
        values.filter(|(p, _)| is_shape(p)).collect()
    }

    /// How far apart the values of each shape parameter are that were tried.
    fn spacing(&self, candidate: usize, shape: &Assignment) -> Vec<f64> {
        let shapes = &self.dictionary.candidates[candidate].shapes;
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

    /// The cost of a linear fit of the accepted terms and an effect in one shape, under the
    /// noise that suits it; `None` where its strengths cannot be.
    fn placed(&self, candidate: usize, shape: Assignment, observed: &Observed) -> Option<Placed> {
        let dictionary = self.dictionary;
        let own = &dictionary.candidates[candidate];
        let bounds = &dictionary.machine.compiled.model.parameters;
        let inside = |p: usize, value: f64| (bounds[p].lower..=bounds[p].upper).contains(&value);
        if !shape.iter().all(|&(p, value)| inside(p, value)) {
            return None;
        }
        let mut all = self.accepted.clone();
        all.push(candidate);
        let explanation = &self.current.explanation;
        let mut values = explanation.values.clone();
        for &(parameter, value) in &shape {
            values[parameter] = value;
        }
        let focus = dictionary.focus(&all);
        let parameters = focus.values(&values);
        let columns = [Columns {
            machine: &focus.machine,
            tape: &focus.by_parameter,
            sensors: Some(&focus.sensors),
            parameters: &parameters,
        }];
        let dynamics = ErrorDynamics::new(
            &focus.machine,
            &focus.slopes,
            &columns,
            &observed.curve,
            observed.hold,
            &parameters,
        );
        let dynamics = dynamics.ok()?;
        let readings = observed.readings(&focus, &values, &dynamics.accelerations());
        let order = dictionary.parameters_of(&all);
        let is_fitted = |p: &usize| !own.parameters.contains(p) || own.strengths.contains(p);
        let fitted: Vec<usize> = (0..order.len()).filter(|&i| is_fitted(&order[i])).collect();
        let mut noise = explanation.noise.clone();
        let settled = settle(&dynamics, &readings, &fitted, &mut noise, Adapt::ToFit);
        let steps = fitted.iter().zip(settled.fit.coefficients.iter());
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
}
