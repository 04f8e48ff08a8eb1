//! Simple effects in the stead of rich ones that the log does not need.
//!
//! A rich effect finds its way where a simple one gets stuck, and one that was rich enough
//! while another was missing may be too rich beside it. What both call by the same name
//! begins where the rich one has ended.

use super::TIE;
use super::fitting::fit;
use super::search::{Attempt, Search, leaves_forces, reset};
use rayon::prelude::*;

/// How many plainer effects at the place of a term are tried.
const PLAINER: usize = 2;

/// A term, and what is tried in its stead.
type Stead = (usize, Vec<usize>);

impl Search<'_> {
    /// The attempt with one of `terms` made simpler, if that explains the log as well.
    pub(super) fn simplified(&self, attempt: &Attempt, terms: &[usize]) -> Option<Attempt> {
        let stead = |&term: &usize| {
            self.simpler(term, attempt)
                .into_iter()
                .map(move |simple| (term, simple))
        };
        self.in_stead(attempt, terms.iter().flat_map(stead).collect())
    }

    /// Where forces remain: the accepted terms with one replaced by an effect of another kind, at
    /// its place and with fewer parameters, if that explains the log as well. A rich effect
    /// resembles many, and leads before what it only resembles.
    pub(super) fn plainer(&self) -> Option<Attempt> {
        if !leaves_forces(&self.current) {
            return None;
        }
        let candidates = &self.dictionary.candidates;
        let plainer = |&term: &usize| {
            let rich = &candidates[term];
            let others = self
                .first_round
                .iter()
                .map(|considered| considered.candidate);
            let others = others
                .filter(|other| !self.accepted.contains(other))
                .filter(move |&other| {
                    let other = &candidates[other];
                    other.subject.on() == rich.subject.on()
                        && other.channel == rich.channel
                        && other.size() < rich.size()
                });
            others.take(PLAINER).map(move |other| (term, vec![other]))
        };
        let steads = self.accepted.iter().flat_map(plainer).collect();
        self.in_stead(&self.current, steads)
    }

    /// The plainest attempt with something in the stead of a term, if it explains the log as well.
    fn in_stead(&self, attempt: &Attempt, steads: Vec<Stead>) -> Option<Attempt> {
        let tried = steads.par_iter().map(|(rich, simple)| {
            let mut explanation = attempt.explanation.clone();
            reset(self.dictionary, &mut explanation, *rich);
            for &candidate in simple {
                for (parameter, value) in self.inherited(candidate, *rich, attempt) {
                    explanation.values[parameter] = value;
                }
            }
            let others = attempt.candidates.iter().copied().filter(|c| c != rich);
            let candidates: Vec<usize> = others.chain(simple.iter().copied()).collect();
            // Under which the machine cannot move, it is no explanation.
            fit(self.dictionary, &candidates, explanation).ok()
        });
        let tried: Vec<Option<Attempt>> = tried.collect();
        let possible = tried
            .into_iter()
            .flatten()
            .filter(|simple| simple.cost < attempt.cost + TIE && self.is_possible(simple));
        possible.min_by(|a, b| {
            let size = |a: &Attempt| a.estimate.parameters.len();
            size(a).cmp(&size(b)).then(a.cost.total_cmp(&b.cost))
        })
    }

    /// One of two accepted terms alone, if it explains the log as well: a simple one that came
    /// first may have left a rich one little to explain, far from where that is alone.
    pub(super) fn alone(&self) -> Option<Attempt> {
        let [a, b] = self.accepted[..] else {
            return None;
        };
        let tried = [(a, b), (b, a)].into_par_iter().map(|(kept, gone)| {
            let afresh = self.first_round.iter().find(|c| c.candidate == kept)?;
            let mut explanation = self.current.explanation.clone();
            reset(self.dictionary, &mut explanation, gone);
            for &(parameter, value) in &afresh.values {
                explanation.values[parameter] = value;
            }
            let alone = fit(self.dictionary, &[kept], explanation).ok()?;
            let limit = self.current.cost + TIE;
            (alone.cost < limit).then_some(alone)
        });
        let tried: Vec<Option<Attempt>> = tried.collect();
        tried
            .into_iter()
            .flatten()
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Candidates at the place of `rich` that have fewer parameters and share some of its;
    /// and two at a time that share all.
    fn simpler(&self, rich: usize, attempt: &Attempt) -> Vec<Vec<usize>> {
        let candidates = &self.dictionary.candidates;
        let on = candidates[rich].subject.on();
        let names = self.dictionary.short_names(rich);
        let relatives: Vec<usize> = (0..candidates.len())
            .filter(|&c| !attempt.candidates.contains(&c))
            .filter(|&c| candidates[c].size() < candidates[rich].size())
            .filter(|&c| candidates[c].channel == candidates[rich].channel)
            .filter(|&c| candidates[c].subject.on() == on)
            .filter(|&c| {
                let own = self.dictionary.short_names(c);
                own.iter().any(|name| names.contains(name))
            })
            .collect();
        let mut found: Vec<Vec<usize>> = relatives.iter().map(|&c| vec![c]).collect();
        let is_part = |c: &usize| {
            let mut own = self.dictionary.short_names(*c).into_iter();
            own.all(|name| names.contains(&name))
        };
        let parts: Vec<usize> = relatives.into_iter().filter(is_part).collect();
        for (i, &a) in parts.iter().enumerate() {
            for &b in &parts[i + 1..] {
                if candidates[a].size() + candidates[b].size() < candidates[rich].size() {
                    found.push(vec![a, b]);
                }
            }
        }
        found
    }

    /// Where a candidate begins in the stead of `rich`: what both have in common as it is
    /// there, the rest as it was beside the model as given.
    fn inherited(&self, candidate: usize, rich: usize, attempt: &Attempt) -> Vec<(usize, f64)> {
        let afresh = self.first_round.iter().find(|c| c.candidate == candidate);
        let mut values = afresh.map_or_else(Vec::new, |c| c.values.clone());
        let names = self.dictionary.short_names(rich);
        let theirs = &self.dictionary.candidates[rich].parameters;
        let own = self.dictionary.short_names(candidate);
        let places = &self.dictionary.candidates[candidate].parameters;
        for (name, &parameter) in own.iter().zip(places) {
            if let Some(position) = names.iter().position(|n| n == name) {
                values.push((parameter, attempt.explanation.values[theirs[position]]));
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, rectangular, traced};
    use std::fmt::Write;

    /// A wheel on a hardening spring, `hard q³`, with another of 0.3 N·m that rests at 0.25:
    /// the other alone is `0.3 (q³ − 0.75 q² + …)`, of which the first part is more of `hard`.
    #[test]
    fn a_term_that_came_first_goes_where_the_second_does_alone() {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(7);
        let waves = [(0.7, 2.0), (0.4, 5.3)];
        for k in 0..2000 {
            let t = 0.005 * f64::from(k);
            let sum = |f: fn(f64, f64, f64) -> f64| -> f64 {
                waves.iter().map(|&(a, w)| f(a, w, t)).sum()
            };
            let q = sum(|a, w, t| a * (w * t).sin());
            let a = sum(|a, w, t| -a * w * w * (w * t).sin());
            let u = 0.02 * a + 0.2 * q.powi(3) + 0.3 * (q - 0.25).powi(3);
            writeln!(text, "{t},{},{u}", q + 2e-4 * noise()).unwrap();
        }
        let spring = "parameter hard: N*m = 0.2 in 0..; potential hard/4*angle^4;";
        let findings = traced(&format!("{WHEEL}{spring}"), &text).findings;
        let names: Vec<&str> = findings.iter().map(|f| f.effect.as_str()).collect();
        assert_eq!(names, ["cubic_spring"], "{findings:#?}");
        let spring = &findings[0].parameters;
        assert!((spring["k_3"].value - 0.3).abs() < 0.01, "{spring:?}");
        assert!((spring["q_0"].value - 0.25).abs() < 0.01, "{spring:?}");
    }
}
