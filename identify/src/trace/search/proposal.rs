//! A hypothesis that is worth a fit, and where that begins.

use super::fit::Fitted;
use super::hypothesis::Hypothesis;
use crate::trace::dictionary::Dictionary;
use crate::trace::refine::Explanation;

/// A hypothesis to fit.
#[derive(Debug, Clone)]
pub struct Proposal {
    /// Which one.
    pub hypothesis: Hypothesis,
    /// Values of all the dictionary's parameters to begin with.
    pub values: Vec<f64>,
    /// Nats, on no scale but that of the other proposals of its move: the less, the more is
    /// promised.
    pub promise: f64,
    /// Negative log likelihood that its fit should reach from here, nats: a model that holds another
    /// is at least as likely. What was fitted from another start and is no better than that is
    /// fitted again.
    pub within_reach: f64,
    /// Its fit begins with what the coordinates that nothing measures do so many seconds later, s.
    pub ahead: f64,
}

impl Proposal {
    /// Terms beside the model as `given`, begun with values, before anything else.
    pub fn first(given: &Fitted, terms: &[usize], values: &[f64]) -> Self {
        Self {
            hypothesis: given.hypothesis.exchange(&[], terms),
            values: values.to_vec(),
            promise: given.score,
            within_reach: f64::INFINITY,
            ahead: 0.0,
        }
    }

    /// Where its fit begins: with the motion and the noise of the hypothesis that it came from.
    /// Sensors that are thought to err in another way read the same of another motion.
    pub fn start(&self, dictionary: &Dictionary, from: &Fitted) -> Explanation {
        let mut start = from.explanation.clone();
        start.values.clone_from(&self.values);
        start.observed.hold = self.hypothesis.hold;
        let all = from.hypothesis.exchange(&[], self.hypothesis.candidates());
        let is_changed =
            |&&c: &&usize| !(from.hypothesis.contains(c) && self.hypothesis.contains(c));
        let misreads = |&c: &usize| {
            let mut parameters = dictionary.candidates[c].parameters.iter();
            parameters.any(|p| dictionary.sensors.sensing.contains(p))
        };
        let changed = all.candidates().iter().filter(is_changed);
        let changed: Vec<usize> = changed.copied().collect();
        if changed.iter().any(misreads) {
            let focus = dictionary.focus(all.candidates());
            start
                .observed
                .reread(&focus, &from.explanation.values, &self.values);
        }
        if self.ahead != 0.0 {
            let record = &from.explanation.observed.record;
            let ahead = vec![self.ahead; record.len()];
            let estimated = (0..record.q.len()).filter(|&i| !record.is_measured(i));
            estimated.for_each(|i| start.observed.move_in_time(i, &ahead));
        }
        start
    }
}
