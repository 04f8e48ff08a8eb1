//! Selection where a sensor's slow errors look like faint forces.

use super::corrected::corrected;
use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::finding::{Verdict, much_remains, verdict};
use super::outcome::Basis;
use super::score::Scoring;
use super::search::{Answer, Given, Inquiry, Task};
use super::selection::Selection;
use crate::machine::SolveError;

/// Share of the accelerations below which what remains may be a sensor's slow error.
const FAINT_SHARE: f64 = 0.01;
/// Multiples of the sensors' noise to try.
const LARGER_NOISE: [f64; 2] = [3.0, 10.0];
/// What sees the sensors otherwise, as noisier or as white where their errors seem to last, must bring
/// predictions at least this much nearer to the log.
const CLEARLY_NEARER: f64 = 0.9;
/// How long the predictions run that judge between noises, s.
const JUDGED_HORIZON: f64 = 1.0;

/// A search in a log as its sensors may have read it: with the noise that they show from sample to sample, with errors
/// that last where theirs seem to, and with larger noise. A real sensor's slow errors (an encoder that is not quite
/// round) look like faint forces to a filter that believes the sensor.
pub(super) struct Inquiries<'a> {
    task: Task<'a>,
    /// The log as it was read.
    start: Observed,
    given: &'a Given,
    as_read: Inquiry<'a>,
    lasting: Option<Inquiry<'a>>,
    /// Under each [`LARGER_NOISE`], as far as it was asked.
    larger: [Option<Inquiry<'a>>; LARGER_NOISE.len()],
}

/// How a log's sensors err.
#[derive(Clone, Copy)]
enum Noise {
    /// As they seem to from sample to sample.
    AsRead,
    /// With errors that last as they seem to.
    Lasting,
    /// By one of [`LARGER_NOISE`] times as much.
    Larger(usize),
}

impl<'a> Inquiries<'a> {
    /// Into a log, of which nothing was asked yet; beside other searches in it.
    pub fn new(task: Task<'a>, start: Observed, given: &'a Given) -> Self {
        Self {
            as_read: Inquiry::beside(task, start.clone(), given),
            task,
            start,
            given,
            lasting: None,
            larger: [const { None }; LARGER_NOISE.len()],
        }
    }

    /// Asks for the terms that explain the log best under the noise that the sensors show from sample to sample; where
    /// that may be wrong, under the one that is right. See [`Inquiry::ask`].
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn ask(
        &mut self,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Selection, SolveError> {
        let mut as_read = self.as_read.ask_at_first(at_most, suggested)?;
        // The whole log may show what the part does not that is searched first.
        if self.is_settled(&as_read) {
            as_read = self.as_read.ask(at_most, suggested)?;
            if self.is_settled(&as_read) {
                return Ok(as_read.selection);
            }
        }
        let noise = self.right_noise(&as_read, at_most, suggested)?;
        let answer = match (noise, self.under(noise).ask(at_most, suggested)) {
            // What the part can be fitted under, the whole need not be.
            (Noise::Larger(_), Err(_)) => self.as_read.ask(at_most, suggested)?,
            (_, answer) => answer?,
        };
        Ok(answer.selection)
    }

    /// Whether no other noise is asked beside an answer from the log as it was read.
    fn is_settled(&self, as_read: &Answer) -> bool {
        self.is_over() || !(self.may_last(as_read) || self.may_be_noise(&as_read.selection))
    }

    /// Whether the sensors' errors may last. What explains the log with white ones says that they only seemed to.
    fn may_last(&self, as_read: &Answer) -> bool {
        !as_read.is_whole && self.as_read.lasting().is_some()
    }

    /// Whether what a selection leaves may be a sensor's: what is faint, and forces beside which nothing at all shows.
    fn may_be_noise(&self, selection: &Selection) -> bool {
        match selection.terms.is_empty() {
            true => !self.task.only_with_terms && !selection.remaining.forces.is_empty(),
            false => is_faint(self.task.dictionary, selection),
        }
    }

    /// Which noise is right, in the part of the log that is searched first: errors that last where they seem to, unless
    /// white ones foretell the motion clearly better; where what remains may be noise, larger ones. It shows in
    /// open-loop predictions along the training log; where motion is an estimate, which agrees with the sensors that it
    /// came from, in the likelihood of what they read.
    fn right_noise(
        &mut self,
        as_read: &Answer,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Noise, SolveError> {
        let ask = |this: &mut Self, noise: Noise| {
            let answer = this.under(noise).ask_at_first(at_most, suggested)?;
            Ok((noise, answer.selection))
        };
        let mut best = ask(self, Noise::AsRead)?;
        let mut may_be_noise = self.may_be_noise(&as_read.selection);
        if self.may_last(as_read) {
            let lasting = ask(self, Noise::Lasting)?;
            // Sensors with errors that last are given less weight, and may hide what is there: then the
            // findings of those taken at their word foretell the motion better, where it was measured. An estimate of
            // it holds what its sensors get wrong.
            let errors = [&lasting, &best].map(|(_, one)| self.prediction_error(one));
            if !self.start.record.is_wholly_measured() || errors[1] >= CLEARLY_NEARER * errors[0] {
                may_be_noise = self.may_be_noise(&lasting.1);
                best = lasting;
            }
        }
        if !may_be_noise {
            return Ok(best.0);
        }
        let mut others = Vec::new();
        for factor in 0..LARGER_NOISE.len() {
            if !self.is_over() {
                // Noise under which nothing can be fitted is none.
                others.extend(ask(self, Noise::Larger(factor)).ok());
            }
        }
        Ok(self.nearest(best, others))
    }

    /// The search under some noise.
    fn under(&mut self, noise: Noise) -> &mut Inquiry<'a> {
        match noise {
            Noise::AsRead => &mut self.as_read,
            Noise::Lasting => {
                let seen = self.as_read.lasting().unwrap_or(&self.start);
                let new = || Inquiry::new(self.task, seen.clone());
                self.lasting.get_or_insert_with(new)
            }
            Noise::Larger(factor) => {
                let new = || {
                    let mut noisier = self.start.clone();
                    noisier.scale_noise(LARGER_NOISE[factor]);
                    Inquiry::new(self.task, noisier)
                };
                self.larger[factor].get_or_insert_with(new)
            }
        }
    }

    /// What the part of the log says that is searched first, under the noise that the sensors show from sample to sample;
    /// `None` where that may be wrong. See [`Inquiry::ask_at_first`].
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn settled_at_first(
        &mut self,
        at_most: usize,
        suggested: Option<&Selection>,
    ) -> Result<Option<Selection>, SolveError> {
        let as_read = self.as_read.ask_at_first(at_most, suggested)?;
        Ok(self.is_settled(&as_read).then_some(as_read.selection))
    }

    /// See [`Inquiry::confirmed`], under the noise that the sensors show from sample to sample.
    ///
    /// # Errors
    /// If the equation of motion cannot be solved along the curve.
    pub fn confirmed(&self, suggested: &Selection) -> Result<Option<Selection>, SolveError> {
        Inquiry::beside(self.task, self.start.clone(), self.given).confirmed(suggested)
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

    /// Which noise is right: that of the first selection, or of others under larger ones.
    fn nearest(&self, first: (Noise, Selection), others: Vec<(Noise, Selection)>) -> Noise {
        let seen = std::iter::once(first).chain(others);
        if !self.start.record.is_wholly_measured() {
            let likelihood = |(_, one): &(Noise, Selection)| one.log_likelihood[1];
            let likeliest = seen.max_by(|a, b| likelihood(a).total_cmp(&likelihood(b)));
            return likeliest.expect("the first stays").0;
        }
        let measured = seen.map(|(noise, one)| (self.prediction_error(&one), noise, one));
        let mut seen: Vec<(f64, Noise, Selection)> = measured.collect();
        // Of those that foretell about as well, the plainest is nearest to what holds elsewhere.
        let errors = seen.iter().map(|(error, ..)| *error);
        let lowest = errors.fold(f64::INFINITY, f64::min);
        if lowest.is_infinite() {
            return seen[0].1;
        }
        seen.retain(|(error, ..)| CLEARLY_NEARER * error <= lowest);
        let plainest = seen
            .iter()
            .min_by_key(|(_, _, one)| numbers(self.task.dictionary, one));
        plainest.expect("the nearest stays").1
    }

    /// How far open-loop predictions of a selection miss the log to learn from; beyond all bounds where it makes none.
    fn prediction_error(&self, selection: &Selection) -> f64 {
        let focus = self.task.dictionary.focus(&selection.accepted());
        let scoring = Scoring {
            machine: &focus.machine,
            values: &focus.values(&selection.values),
            hold: selection.observed.hold,
            horizon: JUDGED_HORIZON,
            begun: &selection.observed.curve.begun,
        };
        let record = corrected(&self.start.record, &focus, scoring.values).ok();
        let score = record.and_then(|record| scoring.score(&record).ok());
        let error = score.map(|score| score.rollout.errors.total);
        error
            .filter(|error| error.is_finite())
            .unwrap_or(f64::INFINITY)
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
