//! Selection where a sensor's slow errors look like faint forces.

use super::corrected::corrected;
use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::finding::{Verdict, much_remains, verdict};
use super::outcome::Basis;
use super::score::Scoring;
use super::search::{Answer, Inquiry, Task};
use super::selection::Selection;
use crate::machine::SolveError;

/// Share of the accelerations below which what remains may be a sensor's slow error.
const FAINT_SHARE: f64 = 0.01;
/// Multiples of the sensors' noise to try.
const LARGER_NOISE: [f64; 2] = [3.0, 10.0];
/// What sees the sensors otherwise, as noisier or as white where their errors seem to last, must bring
/// predictions at least this much nearer to the log.
const WORTH_IT: f64 = 0.9;
/// How long the predictions run that judge between noises, s.
const JUDGED_HORIZON: f64 = 1.0;

/// A search in a log as its sensors may have read it: with the noise that they show from sample to sample, with errors
/// that last where theirs seem to, and with larger noise. A real sensor's slow errors (an encoder that is not quite
/// round) look like faint forces to a filter that believes the sensor.
pub(super) struct Inquiries<'a> {
    task: Task<'a>,
    /// The log as it was read.
    start: Observed,
    as_read: Inquiry<'a>,
    lasting: Option<Inquiry<'a>>,
    /// Under each [`LARGER_NOISE`], as far as it was asked.
    noisier: Vec<Inquiry<'a>>,
}

impl<'a> Inquiries<'a> {
    /// Into a log, of which nothing was asked yet.
    pub fn new(task: Task<'a>, start: Observed) -> Self {
        Self {
            as_read: Inquiry::new(task, start.clone()),
            task,
            start,
            lasting: None,
            noisier: Vec::new(),
        }
    }

    /// Asks for the terms that explain the log best under the noise that the sensors show from sample to sample, with
    /// errors that last where these seem to, unless white ones foretell the motion clearly better; where what remains is
    /// faint but real, also under larger noise. Which noise is right shows in open-loop predictions along the training
    /// log; where motion is an estimate, which agrees with the sensors that it came from, in the likelihood of what
    /// they read. See [`Inquiry::ask`].
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn ask(
        &mut self,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Selection, SolveError> {
        let Answer {
            selection: mut best,
            is_whole,
        } = self.as_read.ask(at_most, suggested)?;
        // What explains the log with white errors of the sensors says that they only seemed to last.
        if !is_whole
            && !self.is_over()
            && let Some(seen) = self.as_read.lasting()
        {
            let new = || Inquiry::new(self.task, seen.clone());
            let lasting = self.lasting.get_or_insert_with(new);
            let less_believed = lasting.ask(at_most, suggested)?.selection;
            // Sensors with errors that last are given less weight, and may hide what is there: then the
            // findings of those taken at their word foretell the motion better, where it was measured. An estimate of
            // it holds what its sensors get wrong.
            let errors = [&less_believed, &best]
                .map(|one| self.prediction_error(one).unwrap_or(f64::INFINITY));
            if !self.start.record.is_wholly_measured() || errors[1] >= WORTH_IT * errors[0] {
                best = less_believed;
            }
        }
        if self.task.only_with_terms && best.terms.is_empty() {
            return Ok(best);
        }
        // Forces beside which nothing at all shows may be a sensor's, too.
        let may_be_noise = match best.terms.is_empty() {
            true => !best.remaining.forces.is_empty(),
            false => is_faint(self.task.dictionary, &best),
        };
        if !may_be_noise || self.is_over() {
            return Ok(best);
        }
        let mut seen = vec![best];
        for (i, factor) in LARGER_NOISE.into_iter().enumerate() {
            if self.is_over() {
                break;
            }
            if self.noisier.len() == i {
                let mut noisier = self.start.clone();
                noisier.scale_noise(factor);
                self.noisier.push(Inquiry::new(self.task, noisier));
            }
            // Noise under which nothing can be fitted is none.
            if let Ok(Answer { selection, .. }) = self.noisier[i].ask(at_most, suggested) {
                seen.push(selection);
            }
        }
        Ok(self.nearest(seen))
    }

    /// See [`Inquiry::leaves_forces_at_first`], under the noise that the sensors show from sample to sample.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn leaves_forces_at_first(&mut self, at_most: usize) -> Result<bool, SolveError> {
        self.as_read.leaves_forces_at_first(at_most)
    }

    fn is_over(&self) -> bool {
        self.task.progress.ended().is_some()
    }

    /// Of some selections, the first from the log as it was read, the one whose noise is right.
    fn nearest(&self, mut seen: Vec<Selection>) -> Selection {
        if !self.start.record.is_wholly_measured() {
            let by_likelihood = |a: &Selection, b: &Selection| {
                let [a, b] = [a, b].map(|one| one.log_likelihood[1]);
                a.total_cmp(&b)
            };
            let likeliest = seen.into_iter().max_by(by_likelihood);
            return likeliest.expect("the first stays");
        }
        let first = seen.remove(0);
        let error = self.prediction_error(&first).unwrap_or(f64::INFINITY);
        let others = seen.into_iter();
        let others = others.filter_map(|one| Some((self.prediction_error(&one)?, one)));
        let mut seen: Vec<(f64, Selection)> = others.collect();
        seen.insert(0, (error, first));
        // Of those that foretell about as well, the plainest is nearest to what holds elsewhere.
        let errors = seen.iter().map(|(error, _)| *error);
        let lowest = errors.fold(f64::INFINITY, f64::min);
        seen.retain(|(error, _)| WORTH_IT * error <= lowest);
        let plainest = seen
            .into_iter()
            .min_by_key(|(_, one)| numbers(self.task.dictionary, one));
        plainest.expect("the nearest stays").1
    }

    /// How far open-loop predictions of a selection miss the log to learn from.
    fn prediction_error(&self, selection: &Selection) -> Option<f64> {
        let focus = self.task.dictionary.focus(&selection.accepted());
        let scoring = Scoring {
            machine: &focus.machine,
            values: &focus.values(&selection.values),
            hold: selection.observed.hold,
            horizon: JUDGED_HORIZON,
            begun: &selection.observed.curve.begun,
        };
        let record = corrected(&self.start.record, &focus, scoring.values).ok()?;
        let score = scoring.score(&record).ok()?;
        Some(score.rollout.errors.total).filter(|error| error.is_finite())
    }
}

/// Whether what a selection leaves is faint and has no name.
fn is_faint(dictionary: &Dictionary, selection: &Selection) -> bool {
    let is_other = much_remains(Basis::Motion, selection);
    let verdict = verdict(dictionary, selection, is_other);
    let has_no_name = verdict == Verdict::Unknown || selection.left_out_nameless;
    selection.remaining.share_after < FAINT_SHARE && has_no_name
}

/// How many numbers the findings hold.
fn numbers(dictionary: &Dictionary, selection: &Selection) -> usize {
    let terms = selection.terms.iter();
    terms
        .map(|term| dictionary.candidates[term.candidate].size())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::progress::Silent;
    use crate::trace::wheel::{WHEEL, begun, rectangular};
    use std::fmt::Write;

    /// What is found first of a wheel of so many kg·m², thought to be of 0.02, whose encoder's errors are `memory` times
    /// the one before and something new.
    fn answer(inertia: f64, memory: f64) -> (Answer, Option<Observed>) {
        let mut text = String::from("t,q_angle,u_motor\n");
        let (mut random, mut error) = (rectangular(4), 0.0);
        for k in 0..1500 {
            let t = 0.005 * f64::from(k);
            let (q, a) = ((5.0 * t).sin(), -25.0 * (5.0 * t).sin());
            error = memory * error + 1e-3 * random();
            writeln!(text, "{t},{},{}", q + error, inertia * a).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let task = Task {
            dictionary: &dictionary,
            free_hold: false,
            only_with_terms: false,
            progress: &Silent,
        };
        let mut inquiry = Inquiry::new(task, start.observed);
        let answer = inquiry.ask(1, None).unwrap();
        (answer, inquiry.lasting().cloned())
    }

    #[test]
    fn errors_last_where_white_ones_explain_less_and_nothing_is_found_in_their_stead() {
        let (none, lasting) = answer(0.02, 0.7);
        assert!(none.selection.terms.is_empty() && !none.is_whole);
        let memory = &lasting.unwrap().sensor_memory.0[0];
        assert!((memory[0] - 0.7).abs() < 0.1, "{memory:?}");
        // The log of another wheel asks for no such errors once that is known.
        let (other, _) = answer(0.021, 0.0);
        assert!(other.selection.terms.len() == 1 && other.is_whole);
        // A wheel as it was thought to be leaves nothing to be likelier than.
        let (same, lasting) = answer(0.02, 0.0);
        assert!(same.selection.terms.is_empty() && !same.is_whole && lasting.is_none());
    }
}
