//! Selection where a sensor's slow errors look like faint forces.

use super::corrected::corrected;
use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::finding::{Verdict, much_remains, verdict};
use super::outcome::Basis;
use super::score::Scoring;
use super::search::{Answer, Task, select};
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

/// Selects under the noise that the sensors show from sample to sample, with errors that last where
/// these seem to, unless white ones foretell the motion clearly better; where what
/// remains is faint but real, also under larger noise. A real sensor's slow errors (an
/// encoder that is not quite round) look like faint forces to a filter that believes the
/// sensor. Which noise is right shows in open-loop predictions along the training log; where motion is an
/// estimate, which agrees with the sensors that it came from, in the likelihood of what they read.
pub(super) fn select_with_slow_errors(
    task: Task<'_>,
    observed: Observed,
) -> Result<Selection, SolveError> {
    let Task {
        dictionary,
        progress,
        ..
    } = task;
    let start = observed.clone();
    let prediction_error = |selection: &Selection| {
        let focus = dictionary.focus(&selection.accepted());
        let scoring = Scoring {
            machine: &focus.machine,
            values: &focus.values(&selection.values),
            hold: selection.observed.hold,
            horizon: JUDGED_HORIZON,
            begun: &selection.observed.curve.begun,
        };
        let record = corrected(&start.record, &focus, scoring.values).ok()?;
        let score = scoring.score(&record).ok()?;
        Some(score.rollout.errors.total).filter(|error| error.is_finite())
    };
    let Answer {
        selection: mut best,
        is_whole,
        lasting,
    } = select(task, observed)?;
    // What explains the log with white errors of the sensors says that they only seemed to last.
    if let Some(lasting) = lasting
        && !is_whole
        && progress.ended().is_none()
    {
        let less_believed = select(task, lasting)?.selection;
        // Sensors with errors that last are given less weight, and may hide what is there: then the
        // findings of those taken at their word foretell the motion better, where it was measured. An estimate of
        // it holds what its sensors get wrong.
        let errors =
            [&less_believed, &best].map(|one| prediction_error(one).unwrap_or(f64::INFINITY));
        if !start.record.is_wholly_measured() || errors[1] >= WORTH_IT * errors[0] {
            best = less_believed;
        }
    }
    if task.only_with_terms && best.terms.is_empty() {
        return Ok(best);
    }
    let is_faint = || {
        let is_other = much_remains(Basis::Motion, &best);
        let verdict = verdict(dictionary, &best, is_other);
        let has_no_name = verdict == Verdict::Unknown || best.left_out_nameless;
        best.remaining.share_after < FAINT_SHARE && has_no_name
    };
    // Forces beside which nothing at all shows may be a sensor's, too.
    let may_be_noise = match best.terms.is_empty() {
        true => !best.remaining.forces.is_empty(),
        false => is_faint(),
    };
    if !may_be_noise || progress.ended().is_some() {
        return Ok(best);
    }
    let mut seen = vec![(prediction_error(&best).unwrap_or(f64::INFINITY), best)];
    for factor in LARGER_NOISE {
        if progress.ended().is_some() {
            break;
        }
        let mut noisier = start.clone();
        noisier.scale_noise(factor);
        // Noise under which nothing can be fitted is none.
        let Ok(Answer { selection, .. }) = select(task, noisier) else {
            continue;
        };
        if let Some(error) = prediction_error(&selection) {
            seen.push((error, selection));
        }
    }
    if !start.record.is_wholly_measured() {
        let by_likelihood = |a: &Selection, b: &Selection| {
            let [a, b] = [a, b].map(|one| one.log_likelihood[1]);
            a.total_cmp(&b)
        };
        let all = seen.into_iter().map(|(_, one)| one);
        return Ok(all.max_by(by_likelihood).expect("the first stays"));
    }
    // Of those that foretell about as well, the plainest is nearest to what holds elsewhere.
    let errors = seen.iter().map(|(error, _)| *error);
    let lowest = errors.fold(f64::INFINITY, f64::min);
    seen.retain(|(error, _)| WORTH_IT * error <= lowest);
    let plainest = seen
        .into_iter()
        .min_by_key(|(_, one)| numbers(dictionary, one));
    Ok(plainest.expect("the nearest stays").1)
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
    fn answer(inertia: f64, memory: f64) -> Answer {
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
            suggested: None,
            at_most: 1,
            only_with_terms: false,
            progress: &Silent,
        };
        select(task, start.observed).unwrap()
    }

    #[test]
    fn errors_last_where_white_ones_explain_less_and_nothing_is_found_in_their_stead() {
        let lasting = answer(0.02, 0.7);
        assert!(lasting.selection.terms.is_empty() && !lasting.is_whole);
        let memory = &lasting.lasting.unwrap().sensor_memory.0[0];
        assert!((memory[0] - 0.7).abs() < 0.1, "{memory:?}");
        // The log of another wheel asks for no such errors once that is known.
        let other = answer(0.021, 0.0);
        assert!(other.selection.terms.len() == 1 && other.is_whole);
        // A wheel as it was thought to be leaves nothing to be likelier than.
        let same = answer(0.02, 0.0);
        assert!(same.selection.terms.is_empty() && !same.is_whole && same.lasting.is_none());
    }
}
