//! What forces remember: where a coordinate has lately come from.

use super::dictionary::Dictionary;
use super::selection::Selection;
use super::subject::Subject;
use crate::log::segments;

/// The ways over which accepted effects forget, by coordinate: the log has said how far
/// bristles bend, even where it does not say whose they are. They are shapes of a force with states, in
/// the coordinate's unit.
pub(super) fn remembered_ways(dictionary: &Dictionary, selection: &Selection) -> Vec<(usize, f64)> {
    let model = &dictionary.machine.compiled.model;
    let terms = selection.terms.iter().map(|term| term.candidate);
    let mut ways = Vec::new();
    for term in terms.filter(|&term| remembers(dictionary, term)) {
        let candidate = &dictionary.candidates[term];
        if candidate.channel {
            continue;
        }
        let on = candidate.subject.on();
        let coordinates = model.coordinates.iter().enumerate();
        for (i, coordinate) in coordinates.filter(|(_, own)| on.contains(&own.name)) {
            let shapes = candidate.parameters.iter();
            let own = shapes.filter(|&&p| {
                model.parameters[p].unit == coordinate.unit && !candidate.strengths.contains(&p)
            });
            ways.extend(own.map(|&p| (i, selection.values[p])));
        }
    }
    ways
}

/// Whether a candidate is a law of force without memory: an effect, on no channel, without states.
pub(super) fn is_memoryless(dictionary: &Dictionary, candidate: usize) -> bool {
    let own = &dictionary.candidates[candidate];
    let is_effect = matches!(own.subject, Subject::Effect { .. });
    is_effect && !own.channel && !remembers(dictionary, candidate)
}

/// Whether a candidate has states of its own.
pub(super) fn remembers(dictionary: &Dictionary, candidate: usize) -> bool {
    let candidate = &dictionary.candidates[candidate];
    let model = &dictionary.machine.compiled.model;
    let own = |effect: usize| {
        let mut parameters = model.effects[effect].parameters.iter();
        parameters.any(|p| candidate.parameters.contains(p))
    };
    let mut states = model.states.iter();
    states.any(|state| state.effect.is_some_and(own))
}

/// `ṗ = v − |v| p/r` from nothing on, exactly for a way that goes on in one direction; anew
/// after each gap.
pub(super) fn past(t: &[f64], v: &[f64], way: f64) -> Vec<f64> {
    let way = way.max(f64::MIN_POSITIVE);
    let mut past = vec![0.0; v.len()];
    for range in segments(t) {
        for k in range.clone().skip(1) {
            let step = 0.5 * (v[k] + v[k - 1]) * (t[k] - t[k - 1]);
            let decay = (-step.abs() / way).exp();
            past[k] = past[k - 1] * decay + step.signum() * way * (1.0 - decay);
        }
    }
    past
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_past_of_a_steady_motion_settles() {
        let t: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let v = vec![2.0; t.len()];
        let past = past(&t, &v, 0.5);
        assert_eq!(past[0], 0.0);
        assert!((past[999] - 0.5).abs() < 1e-6, "the way");
    }
}
