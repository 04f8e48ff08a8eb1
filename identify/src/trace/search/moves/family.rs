//! One effect at every place of its kind.
//!
//! Applies where forces remain, if all together are worth more than any single term is. What is built alike errs
//! alike: an empty battery weakens four rotors, and every joint of an arm rubs. Taken one after the other, the first
//! would be what resembles them all: a heavier hull.

use super::Move;
use super::merge::is_on_a_body;
use crate::trace::screen::{ShapedCandidate, Together};
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::{MARGIN, MAX_TERMS, SHORTLISTED};
use crate::trace::subject::Subject;
use std::collections::BTreeMap;

/// One effect at every place of its kind.
pub struct Family;

impl Move for Family {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        if !at.fitted.leaves_forces() {
            return Vec::new();
        }
        let most = MAX_TERMS.saturating_sub(at.terms().len());
        let single = at.considered.first().map_or(0.0, |best| best.score);
        let mut together = at.screen.together(&families(at));
        let is_better = |all: &Together| {
            let is_family = (2..=most).contains(&all.candidates.len());
            is_family && all.score > MARGIN.max(single)
        };
        together.retain(is_better);
        together.retain(|all| !at.dictionary.nested.doubles(&all.candidates));
        together.sort_by(|a, b| b.score.total_cmp(&a.score));
        together.truncate(SHORTLISTED);
        let each = together.into_iter().map(|all| Proposal {
            hypothesis: at.fitted.hypothesis.exchange(&[], &all.candidates),
            values: at.with(&all.values),
            promise: -all.score,
            within_reach: at.fitted.estimate.cost,
            ahead: 0.0,
        });
        each.collect()
    }
}

/// Of each effect that has a place of its own in several coordinates, inputs or sensors of one unit: all that is not
/// there yet, each in the shape that suits it best by itself.
fn families<'a>(at: &'a Neighbourhood<'_>) -> Vec<Vec<&'a ShapedCandidate>> {
    let dictionary = at.dictionary;
    let model = &dictionary.machine.compiled.model;
    let base: Vec<usize> = (0..at.screen.base.len()).collect();
    let mut families: BTreeMap<_, BTreeMap<usize, (f64, &ShapedCandidate)>> = BTreeMap::new();
    for (option, gram) in at.screen.options.iter().zip(&at.grams) {
        let candidate = &dictionary.candidates[option.candidate];
        let Subject::Effect { template, on } = &candidate.subject else {
            continue;
        };
        if on.len() > 1 || is_on_a_body(dictionary, &candidate.subject) {
            continue;
        }
        let units = candidate.parameters.iter();
        let units: Vec<_> = units
            .map(|&p| model.parameters[p].dimension.map(|d| d.to_string()))
            .collect();
        let own = (0..option.columns.len()).map(|i| base.len() + i);
        let misfit = gram
            .fit(&base.iter().copied().chain(own).collect::<Vec<_>>())
            .misfit;
        let family = families.entry((template, units)).or_default();
        let known = family.get(&option.candidate);
        if known.is_none_or(|(known, _)| misfit < *known) {
            family.insert(option.candidate, (misfit, option));
        }
    }
    let members = families.into_values().map(|family| {
        let options = family.into_values().map(|(_, option)| option);
        options.collect::<Vec<_>>()
    });
    members.filter(|members| members.len() > 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::Hold;
    use crate::trace::refine::Effort;
    use crate::trace::search::fit::as_given;
    use crate::trace::wheel::{begun_with, rectangular};
    use std::fmt::Write;

    /// A puck of 1 kg in a liquid, pushed by what its motion along two waves each way takes: `u = a + d v`.
    fn log(drag: [f64; 2]) -> String {
        let mut text = String::from("t,q_x,q_y,u_x,u_y\n");
        let mut noise = rectangular(7);
        for k in 0..1500 {
            let t = 0.005 * f64::from(k);
            let ways = [[(0.3, 3.0), (0.1, 7.0)], [(0.2, 4.0), (0.1, 9.0)]];
            let moved = ways.map(|waves| {
                waves.iter().fold([0.0; 3], |[q, v, a], (size, w)| {
                    let (sin, cos) = f64::sin_cos(w * t);
                    [q + size * sin, v + size * w * cos, a - size * w * w * sin]
                })
            });
            let read = moved.map(|[q, ..]| q + 2e-4 * noise());
            let push = [0, 1].map(|i: usize| moved[i][2] + drag[i] * moved[i][1]);
            writeln!(text, "{t},{},{},{},{}", read[0], read[1], push[0], push[1]).unwrap();
        }
        text
    }

    /// Families of `effect` that are proposed beside a puck without drag: places and values.
    fn proposed(effect: &str, log: &str) -> Vec<Vec<(Vec<String>, f64)>> {
        const PUCK: &str = "\
model puck;
coordinate x: m;
coordinate y: m;
input x: N;
input y: N;
parameter m: kg = 1;
kinetic m/2*(dot(x)^2 + dot(y)^2);
force x = input(x);
force y = input(y);
";
        let (dictionary, start) = begun_with(PUCK, log, [&["x", "y"], &["x", "y"]]);
        let given = as_given(&dictionary, &start.observed, Hold::Linear, Effort::FULL).unwrap();
        let at = Neighbourhood::new(&dictionary, &given, &[], false).unwrap();
        let proposals = Family.propose(&at, &Explored::default());
        let families = proposals.iter().map(|proposal| {
            let terms = proposal.hypothesis.candidates().iter();
            let terms = terms.map(|&term| &dictionary.candidates[term]);
            let terms = terms.filter(|one| one.subject.name() == effect);
            terms
                .map(|one| (one.subject.on(), proposal.values[one.parameters[0]]))
                .collect()
        });
        families
            .filter(|family: &Vec<_>| !family.is_empty())
            .collect()
    }

    #[test]
    fn drag_both_ways_is_proposed_at_once_and_drag_one_way_is_not() {
        let both = proposed("viscous", &log([0.8, 0.5]));
        let [(x, of_x), (y, of_y)] = &both[0][..] else {
            panic!("{both:?}");
        };
        assert_eq!([&x[..], &y[..]], [["x"], ["y"]]);
        assert!(
            (of_x - 0.8).abs() < 0.05 && (of_y - 0.5).abs() < 0.05,
            "{both:?}"
        );
        assert!(proposed("viscous", &log([0.8, 0.0])).is_empty());
    }
}
