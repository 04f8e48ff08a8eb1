//! Kin: effects that say the same number of the same place in another way.
//!
//! A late drive and a slow one differ little at first, and each looks like the other until its
//! time is about right. Where one has found its time, the other begins there. So does a late
//! sensor of what the drive moves: where that is the only sensor, it is the same log. And one
//! late sensor is several early ones.

use super::TIE;
use super::fitting::fit;
use super::search::{Attempt, Search, reset};
use crate::trace::refine::Explanation;
use crate::trace::rivals::{Alternative, join};
use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::model::Parameter;
use dynamics_codegen::syntax::PortKind;
use rayon::prelude::*;

/// An effect that says the same number in another way.
struct Kin {
    candidate: usize,
    /// Whether its number has the opposite sign.
    opposite: bool,
}

impl Search<'_> {
    /// The attempt with one of `terms` replaced by one of its kin, if that explains the log
    /// better.
    pub(super) fn with_kin(&self, attempt: &Attempt, terms: &[usize]) -> Option<Attempt> {
        let fitted = terms
            .iter()
            .flat_map(|&term| self.fitted_kin(attempt, term, &self.kin(term)));
        fitted
            .filter(|kin| kin.cost < attempt.cost)
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Adds to the `alternatives` of each accepted term its kin, at its place or across the
    /// drive, that explain the log about as well. Alternatives are found to first order, where
    /// times that are not short are no longer alike.
    pub(super) fn add_kin(&self, alternatives: &mut [Vec<Alternative>]) {
        for (alike, &term) in alternatives.iter_mut().zip(&self.accepted) {
            let mut kin = self.kin(term);
            // Where input and coordinate have one name, they are kin already.
            let mut across = self.across_the_drive(term);
            across.retain(|new| kin.iter().all(|known| known.candidate != new.candidate));
            kin.extend(across);
            for attempt in self.fitted_kin(&self.current, term, &kin) {
                let better = self.current.cost - attempt.cost;
                let Some(&candidate) = attempt.candidates.last() else {
                    continue;
                };
                if better > -TIE {
                    let alternative = Alternative {
                        candidate,
                        better,
                        values: attempt.explanation.values,
                    };
                    join(alike, alternative);
                }
            }
        }
    }

    /// The attempt with each of `kin` in the stead of `term`.
    fn fitted_kin(&self, attempt: &Attempt, term: usize, kin: &[Kin]) -> Vec<Attempt> {
        let parameter = |candidate: usize| self.dictionary.candidates[candidate].parameters[0];
        let model = &self.dictionary.machine.compiled.model;
        let others = attempt.candidates.iter().copied().filter(|&c| c != term);
        let others: Vec<usize> = others.collect();
        let number = attempt.explanation.values[parameter(term)];
        let start = |kin: &Kin| match kin.opposite {
            true => -number,
            false => number,
        };
        let new = kin
            .par_iter()
            .filter(|kin| !others.contains(&kin.candidate));
        // A bias to the left is no width of a dead band.
        let possible = new.filter(|kin| {
            let Parameter { lower, upper, .. } = model.parameters[parameter(kin.candidate)];
            (lower..=upper).contains(&start(kin))
        });
        let fitted = possible.map(|kin| {
            let mut explanation = attempt.explanation.clone();
            explanation.values[parameter(kin.candidate)] = start(kin);
            reset(self.dictionary, &mut explanation, term);
            let candidates = [&others[..], &[kin.candidate]].concat();
            let both = self.dictionary.focus(&[&candidates[..], &[term]].concat());
            let Explanation {
                observed, values, ..
            } = &mut explanation;
            observed.reread(&both, &attempt.explanation.values, values);
            fit(self.dictionary, &candidates, explanation).map(|kin| self.sharpened(kin))
        });
        // A kin under which the machine cannot move is no explanation.
        let fitted: Vec<Option<Attempt>> = fitted.map(Result::ok).collect();
        let fitted = fitted.into_iter().flatten();
        fitted.filter(|kin| self.is_possible(kin)).collect()
    }

    /// The channel effects at the place of `term` with one parameter of the same unit; where
    /// `term` is the time of a sensor, those of the others: one is late if all others are early.
    fn kin(&self, term: usize) -> Vec<Kin> {
        let Some((place, unit)) = self.number_of_channel(term) else {
            return Vec::new();
        };
        let alike = |candidate: usize| {
            let (at, of_unit) = self.number_of_channel(candidate)?;
            let is_sensor = |at: &(PortKind, String)| at.0 == PortKind::Coordinate;
            let opposite = unit == Dimension::TIME && is_sensor(place) && is_sensor(at);
            let is_kin = candidate != term && of_unit == unit && (at.1 == place.1 || opposite);
            is_kin.then_some(Kin {
                candidate,
                opposite: at.1 != place.1,
            })
        };
        (0..self.dictionary.candidates.len())
            .filter_map(alike)
            .collect()
    }

    /// Where `term` is a time: the times of the sensors that read what its input drives, or of
    /// the inputs that drive what its sensor reads.
    fn across_the_drive(&self, term: usize) -> Vec<Kin> {
        let given = self.dictionary.focus(&[]);
        let model = &given.machine.compiled.model;
        let drives = |input: &str, coordinate: &str| {
            let row = model.coordinates.iter().position(|c| c.name == coordinate);
            let column = model.inputs.iter().position(|u| u.name == input);
            let matrix = &given.machine.compiled.system.input_matrix;
            row.zip(column)
                .is_some_and(|(row, column)| !model.graph.is_zero(matrix[row][column]))
        };
        let time = |candidate: usize| {
            let (place, unit) = self.number_of_channel(candidate)?;
            (unit == Dimension::TIME).then_some(place)
        };
        let across = |other: &usize| match (time(term), time(*other)) {
            (Some((PortKind::Input, input)), Some((PortKind::Coordinate, read)))
            | (Some((PortKind::Coordinate, read)), Some((PortKind::Input, input))) => {
                drives(input, read)
            }
            _ => false,
        };
        let all = (0..self.dictionary.candidates.len()).filter(across);
        all.map(|candidate| Kin {
            candidate,
            opposite: false,
        })
        .collect()
    }

    /// The coordinate whose sensor a candidate says the time of.
    pub(super) fn late_sensor(&self, candidate: usize) -> Option<usize> {
        let (place, unit) = self.number_of_channel(candidate)?;
        let mut coordinates = self.dictionary.machine.compiled.model.coordinates.iter();
        let coordinate = coordinates.position(|c| c.name == place.1);
        coordinate.filter(|_| place.0 == PortKind::Coordinate && unit == Dimension::TIME)
    }

    /// The place of a candidate that is about a channel, and the unit of its only parameter.
    pub(super) fn number_of_channel(
        &self,
        candidate: usize,
    ) -> Option<(&(PortKind, String), Dimension)> {
        let candidate = &self.dictionary.candidates[candidate];
        let model = &self.dictionary.machine.compiled.model;
        let [only] = candidate.parameters[..] else {
            return None;
        };
        let parameter = &model.parameters[only];
        let place = model.effects[parameter.effect?].on.first()?;
        Some((place, parameter.dimension?)).filter(|_| candidate.channel)
    }
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, rectangular, traced};
    use crate::trace::{Outcome, Verdict};
    use std::fmt::Write;

    /// What a log says of a wheel whose motor is 12 ms late: `u(t − 0.012) = i a(t)`.
    fn late() -> Outcome {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(3);
        let waves = [(0.5, 4.0), (0.1, 11.0)];
        for k in 0..1500 {
            let t = 0.005 * f64::from(k);
            let q: f64 = waves.iter().map(|(a, w)| a * (w * t).sin()).sum();
            let late = t + 0.012;
            let a: f64 = waves
                .iter()
                .map(|(a, w)| -a * w * w * (w * late).sin())
                .sum();
            writeln!(text, "{t},{},{}", q + 2e-4 * noise(), 0.02 * a).unwrap();
        }
        traced(WHEEL, &text)
    }

    #[test]
    fn a_late_motor_and_a_late_encoder_are_the_same_log() {
        let Outcome {
            verdict, findings, ..
        } = late();
        assert_eq!(verdict, Verdict::Channel);
        assert_eq!(findings.len(), 1, "{findings:#?}");
        let found = &findings[0];
        assert!(
            (found.parameters["tau"].value - 0.012).abs() < 5e-4,
            "{found:?}"
        );
        let mut names: Vec<&str> = found
            .confounded_with
            .iter()
            .map(|r| r.effect.as_str())
            .collect();
        names.push(&found.effect);
        for known in ["input_delay", "time_shift"] {
            assert!(names.contains(&known), "{names:?}");
        }
    }
}
