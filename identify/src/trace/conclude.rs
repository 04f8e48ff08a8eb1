//! From what was learnt and how it predicts to what is said: the verdict, what is written into the
//! model, and what only comes nearest.

use super::dictionary::Dictionary;
use super::error::TraceError;
use super::finding::{Finding, Verdict, findings, much_remains, verdict, with_places};
use super::forces;
use super::foretold::Foretold;
use super::judge::{HeldOut, is_worse, judge, trained};
use super::learn::Learnt;
use super::outcome::{
    AT_FLOOR, Basis, HoldIs, Nearest, Outcome, Split, foretells_less_than_a_mean, is_far,
    sensor_noise,
};
use super::patch::patch;
use super::run::Request;
use super::score::Score;
use super::search::is_time;
use super::selection::Selection;
use super::series::{Details, Series, weighed};
use crate::log::Record;
use crate::number::short;
use std::collections::BTreeMap;

/// The same of open-loop predictions, of which a log holds few; where there are none, they say
/// nothing.
const ROLLOUT_AT_FLOOR: f64 = 1.5;

/// What was learnt, with errors on a log that nothing was fitted to.
pub(super) struct Judgement {
    pub learnt: Learnt,
    /// Of the model as given.
    pub before: Score,
    /// With what was learnt.
    pub learnt_errors: Score,
    /// Of a model that is exactly right.
    pub noise_floor: Score,
    series: Series,
    /// What was learnt gains on that log, if it is anything.
    foretold: Option<Foretold>,
    /// Whether what was learnt predicts worse than the model as given, or makes the log less likely.
    is_worse: bool,
    /// Where nothing was found, errors on what was learnt from.
    trained: Option<Score>,
}

/// Judges what was learnt.
///
/// # Errors
/// If the log that is judged by cannot be smoothed, or the model not be evaluated along it.
pub(super) fn judged(
    learnt: Learnt,
    test: &Record,
    request: &Request<'_>,
) -> Result<Judgement, TraceError> {
    let Learnt {
        dictionary,
        selection,
        basis,
    } = &learnt;
    let hold = selection.observed.hold;
    let HeldOut {
        scores,
        series,
        foretold,
    } = match basis {
        Basis::Forces => forces::judge(dictionary, selection, test, request, hold),
        Basis::Motion => judge(dictionary, selection, test, request, hold),
    }?;
    let is_worse = is_worse(*basis, &scores) || foretold.as_ref().is_some_and(Foretold::is_worse);
    let [before, _, noise_floor] = &scores;
    let is_of_no_use = is_worse || foretold.as_ref().is_some_and(|gain| !gain.is_better());
    if is_of_no_use && !selection.terms.is_empty() && is_at_floor(before, noise_floor) {
        // What was found is nothing, and nothing has to be found.
        let learnt = Learnt {
            selection: selection.of_nothing(dictionary),
            ..learnt
        };
        return judged(learnt, test, request);
    }
    let trained = match selection.terms.is_empty() && *basis == Basis::Motion {
        true => Some({
            let of = (&[][..], &dictionary.defaults[..], &selection.observed);
            trained(dictionary, of, request.horizon)?
        }),
        false => None,
    };
    let [before, learnt_errors, noise_floor] = scores;
    Ok(Judgement {
        learnt,
        before,
        learnt_errors,
        noise_floor,
        series,
        foretold,
        is_worse,
        trained,
    })
}

impl Judgement {
    /// Whether what was learnt leaves so much that it must be asked what that is.
    pub fn leaves_much(&self) -> bool {
        let Learnt {
            selection, basis, ..
        } = &self.learnt;
        let at_floor = is_at_floor(&self.learnt_errors, &self.noise_floor);
        // In a band in which positions shake by more than forces explain, what moves them is none.
        let is_force = selection.narrowing == 1;
        !selection.terms.is_empty() && much_remains(*basis, selection) && !at_floor && is_force
    }

    /// Whether what was learnt does not make data likelier that nothing was fitted to, beside forces
    /// without a name.
    pub fn foretells_nothing(&self) -> bool {
        self.foretold
            .as_ref()
            .is_some_and(|foretold| !foretold.is_better())
    }

    /// The verdict, where two measured columns tell of these `drives`. What predicts worse than
    /// the model as given explains nothing, whatever its evidence, and neither does what leaves accelerations
    /// further off than their mean is, and predictions than where they begin. Forces without a name are no
    /// reason to look further where the model as given is as near to the log as sensors allow.
    pub fn verdict(&self, drives: &[Finding], is_other: bool) -> Verdict {
        let Learnt {
            dictionary,
            selection,
            basis,
        } = &self.learnt;
        let is_nowhere = *basis == Basis::Motion
            && foretells_less_than_a_mean(&self.learnt_errors, &self.noise_floor);
        if self.is_worse || is_nowhere {
            return Verdict::Unknown;
        }
        match verdict(dictionary, selection, is_other) {
            Verdict::None if self.is_far() => Verdict::Unknown,
            Verdict::Unknown if self.lacks_nothing_visible() => Verdict::None,
            Verdict::None | Verdict::Parameter if !drives.is_empty() => Verdict::Channel,
            verdict => verdict,
        }
    }

    /// Whether nothing was found, and the model as given is as near to the log as sensors allow.
    fn lacks_nothing_visible(&self) -> bool {
        self.learnt.selection.terms.is_empty() && is_at_floor(&self.before, &self.noise_floor)
    }

    /// Whether the log cannot agree with what was learnt, whatever the search says of it.
    fn is_far(&self) -> bool {
        let is_far = |trained| is_far(&self.learnt_errors, &self.noise_floor, trained);
        self.trained.as_ref().is_some_and(is_far)
    }

    /// What a reader must know who sees that nothing was found, and errors that say otherwise.
    pub fn contradiction(&self) -> Option<String> {
        let share = |score: &Score| short(100.0 * score.acceleration.total);
        let trained = self
            .trained
            .as_ref()
            .filter(|_| self.is_far() && !self.is_worse)?;
        Some(format!(
            "the search found nothing missing, but the model's acceleration errs by {} % where it is \
             judged and by {} % where it was learnt from (the noise floor is {} %): look for samples \
             that are no measurements, and for a part of the log that is unlike the rest",
            share(&self.learnt_errors),
            share(trained),
            share(&self.noise_floor)
        ))
    }

    /// The outcome. What does not explain the log is not written into the model, and the model
    /// as written is judged; what two measured columns say of a drive is written in any case.
    pub fn outcome(
        self,
        request: &Request<'_>,
        split: Split,
        (verdict, drives): (Verdict, Vec<Finding>),
        warnings: Vec<String>,
    ) -> Outcome {
        let Learnt {
            dictionary,
            selection,
            basis,
        } = self.learnt;
        let told = |f: &Finding| {
            let same = |d: &Finding| (&d.effect, &d.on) == (&f.effect, &f.on);
            drives.iter().any(same)
        };
        let mut by_motion = findings(&dictionary, &selection);
        by_motion.retain(|finding| !told(finding));
        let (mut after, mut misfit_after) = (self.learnt_errors, selection.reduced_misfit);
        let [log_likelihood_before, mut log_likelihood_after] = selection.log_likelihood;
        let (mut found, mut remaining, mut nearest) = (drives, selection.remaining.clone(), None);
        if verdict == Verdict::Unknown {
            let errors = std::mem::replace(&mut after, self.before.clone());
            let misfit = std::mem::replace(&mut misfit_after, selection.nominal_misfit);
            log_likelihood_after = log_likelihood_before;
            let share = std::mem::replace(&mut remaining.share_after, remaining.share_before);
            remaining.forces.clone_from(&selection.given_forces);
            nearest = (!by_motion.is_empty()).then_some(Nearest {
                findings: by_motion,
                errors,
                misfit,
                share,
            });
        } else {
            found.extend(by_motion);
        }
        let if_held_otherwise = times_if_held_otherwise(&dictionary, &selection);
        let provenance = provenance(basis, [&self.before, &after], &split, request.seed);
        let robot = dictionary.machine.compiled.model.robot.as_ref();
        let described = robot.map_or(&[][..], |robot| &robot.described);
        Outcome {
            verdict,
            basis,
            patched_model: patch(request.model_text, &found, described, &provenance),
            findings: found,
            nearest,
            before: self.before,
            after,
            noise_floor: self.noise_floor,
            unnamed: None,
            misfit_before: selection.nominal_misfit,
            misfit_after,
            log_likelihood_before,
            log_likelihood_after,
            sensor_noise: sensor_noise(&selection.observed),
            input_hold: selection.observed.hold,
            input_hold_is: match (request.hold, basis) {
                (Some(_), _) => HoldIs::Stated,
                _ if !if_held_otherwise.is_empty() => HoldIs::Undecided,
                (None, Basis::Motion) => HoldIs::Found,
                (None, Basis::Forces) => HoldIs::Assumed,
            },
            if_held_otherwise,
            between_samples: BTreeMap::new(),
            split,
            unfinished: None,
            seed: request.seed,
            misread: None,
            warnings,
            next: Vec::new(),
            details: Details {
                considered: weighed(&dictionary, &selection),
                series: self.series,
            },
            foretold: self.foretold,
            remaining,
        }
    }
}

/// The times that were found as they would be under the other assumption about inputs between samples,
/// by name, where the log is about as likely so.
fn times_if_held_otherwise(
    dictionary: &Dictionary,
    selection: &Selection,
) -> BTreeMap<String, f64> {
    let Some(otherwise) = &selection.held_otherwise else {
        return BTreeMap::new();
    };
    let times = selection.terms.iter().map(|term| term.candidate);
    let times = times.filter(|&term| is_time(dictionary, term));
    let named = times.map(|term| {
        let candidate = &dictionary.candidates[term];
        let place = with_places(candidate.subject.name(), &candidate.subject.on());
        let name = dictionary.short_names(term)[0];
        (
            format!("{place} {name}"),
            otherwise[candidate.parameters[0]],
        )
    });
    named.collect()
}

/// Whether a model is as near to a log as sensor noise allows.
fn is_at_floor(score: &Score, floor: &Score) -> bool {
    let [predicted, possible] = [score, floor].map(|score| score.rollout.errors.total);
    score.acceleration.total < AT_FLOOR * floor.acceleration.total
        && (predicted.is_nan() || predicted <= ROLLOUT_AT_FLOOR * possible)
}

/// What the patched model says about its additions: errors that changed, where there are any.
fn provenance(basis: Basis, scores: [&Score; 2], split: &Split, seed: u64) -> String {
    let (kind, one_step) = match basis {
        Basis::Motion => ("acceleration error", scores.map(|s| s.acceleration.total)),
        Basis::Forces => ("force error", scores.map(|s| s.force.total)),
    };
    let rollout = scores.map(|s| s.rollout.errors.total);
    let errors = [(kind, one_step), ("rollout", rollout)];
    let errors = errors
        .iter()
        .filter(|(_, [before, after])| before.is_finite() && after.is_finite() && before != after);
    let errors = errors
        .map(|(kind, [before, after])| format!("{kind} {} -> {}", short(*before), short(*after)));
    let errors: Vec<String> = errors.collect();
    let held_out = match errors.is_empty() {
        true => String::new(),
        false => format!(": held-out {}", errors.join(", ")),
    };
    format!(
        "dynamics trace, {}{held_out} (seed {seed})",
        split.train_log
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use crate::trace::estimate::Observed;
    use crate::trace::progress::Silent;
    use crate::trace::score::{Errors, RolloutErrors};
    use crate::trace::search::{Inquiry, Task};
    use crate::trace::selection::Term;
    use crate::trace::wheel::{WHEEL, begun, named, rectangular};
    use dynamics_codegen::Library;
    use nalgebra::DMatrix;
    use std::fmt::Write;

    /// What motion says, of one term at most.
    fn found_in_motion(dictionary: &Dictionary, observed: Observed) -> Selection {
        let task = Task {
            dictionary,
            free_hold: false,
            only_with_terms: false,
            progress: &Silent,
        };
        Inquiry::new(task, observed).ask(1, None).unwrap().selection
    }

    /// The log of a wheel that its model describes, from a sample on.
    fn as_modelled(from: usize, seed: u64) -> String {
        let (mut text, mut noise) = (String::from("t,q_angle,u_motor\n"), rectangular(seed));
        for k in from..from + 1000 {
            let t = 0.004 * k as f64;
            let q = 0.9 * (3.0 * t).sin() + 0.5 * (7.0 * t).sin() + 2e-3 * noise();
            let a = -8.1 * (3.0 * t).sin() - 24.5 * (7.0 * t).sin();
            writeln!(text, "{t},{q},{}", 0.02 * a).unwrap();
        }
        text
    }

    /// Judges a wheel that its model describes with a drive that gives `gain` of what it is told, which was found.
    fn judged_with(gain: f64) -> Judgement {
        let train = as_modelled(0, 1);
        let (dictionary, start) = begun(WHEEL, &train, ["angle", "motor"]);
        let term = named(&dictionary, "input_gain(motor)");
        let mut selection = found_in_motion(&dictionary, start.observed);
        assert!(selection.terms.is_empty());
        selection.terms.push(Term {
            candidate: term,
            evidence: 69.0,
            rivals: Vec::new(),
            is_its_own: false,
        });
        selection.estimate.parameters = dictionary.parameters_of(&[term]);
        selection.estimate.covariance = DMatrix::from_element(1, 1, 1e-6);
        selection.values[selection.estimate.parameters[0]] = gain;
        let library = Library::builtin();
        let [train, test] = [train, as_modelled(1000, 2)]
            .map(|text| Log::from_bytes("wheel.csv", text.as_bytes()).unwrap());
        let request = Request::new("wheel", WHEEL, &library, &train);
        let test = test.select(&["angle".to_string()], &["motor".to_string()]);
        let learnt = Learnt {
            dictionary,
            selection,
            basis: Basis::Motion,
        };
        judged(learnt, &test.unwrap(), &request).unwrap()
    }

    /// By so little that no error is a tenth larger, or not at all.
    #[test]
    fn what_makes_the_log_no_likelier_is_no_finding() {
        for gain in [0.9995, 1.0] {
            let judged = judged_with(gain);
            assert!(judged.learnt.selection.terms.is_empty(), "{gain}");
            assert_eq!(judged.verdict(&[], false), Verdict::None);
        }
    }

    #[test]
    fn forces_without_a_name_count_where_errors_are_above_their_floor() {
        let mut judged = judged_with(1.0);
        let remaining = &mut judged.learnt.selection.remaining;
        (remaining.share_after, remaining.evidence) = (0.1, 100.0);
        assert_eq!(judged.verdict(&[], false), Verdict::None);
        judged.before.acceleration.total = 1.2 * judged.noise_floor.acceleration.total;
        assert_eq!(judged.verdict(&[], false), Verdict::Unknown);
    }

    /// A drive that gives less, which is found; but what would that be worth if accelerations were not foretold?
    #[test]
    fn what_foretells_less_than_a_mean_explains_nothing() {
        let mut text = String::from("t,q_angle,u_motor\n");
        for k in 0..1000 {
            let t = 0.004 * f64::from(k);
            let a = -8.1 * (3.0 * t).sin() - 24.5 * (7.0 * t).sin();
            let q = 0.9 * (3.0 * t).sin() + 0.5 * (7.0 * t).sin();
            writeln!(text, "{t},{q},{}", 0.02 / 0.7 * a).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let selection = found_in_motion(&dictionary, start.observed);
        let test = selection.observed.record.clone();
        let library = Library::builtin();
        let log = Log::from_bytes("wheel.csv", text.as_bytes()).unwrap();
        let request = Request::new("wheel", WHEEL, &library, &log);
        let learnt = Learnt {
            dictionary,
            selection,
            basis: Basis::Motion,
        };
        let mut judged = judged(learnt, &test, &request).unwrap();
        let found = judged.verdict(&[], false);
        assert!(found != Verdict::Unknown && found != Verdict::None);
        judged.noise_floor.acceleration.total = 0.2;
        judged.learnt_errors.acceleration.total = 0.9;
        assert_eq!(judged.verdict(&[], false), found);
        // Of a machine that sticks, where it goes is foretold.
        judged.learnt_errors.acceleration.total = 1.6;
        assert!(judged.learnt_errors.rollout.errors.total < 0.1);
        assert_eq!(judged.verdict(&[], false), found);
        judged.learnt_errors.rollout.errors.total = 1.3;
        assert_eq!(judged.verdict(&[], false), Verdict::Unknown);
        // Sensors that are no better say nothing against it.
        judged.noise_floor.acceleration.total = 1.2;
        assert_eq!(judged.verdict(&[], false), found);
    }

    /// What has no share, or has not changed, is not said beside a line of the model.
    #[test]
    fn a_patch_says_no_share_that_is_none() {
        let errors = |total| Errors {
            per_coordinate: BTreeMap::new(),
            total,
        };
        let score = |acceleration, force, rollout| Score {
            acceleration: errors(acceleration),
            force: errors(force),
            rollout: RolloutErrors {
                horizon: 0.5,
                windows: 1,
                diverged: 0,
                errors: errors(rollout),
            },
        };
        let split = Split {
            train_log: "a.csv".into(),
            train_samples: 100,
            test_log: "a.csv".into(),
            test_samples: 50,
            method: String::new(),
        };
        let said =
            |basis, before: &Score, after: &Score| provenance(basis, [before, after], &split, 1);
        let (before, after) = (score(0.5, f64::NAN, 0.3), score(0.1, f64::NAN, f64::NAN));
        insta::assert_snapshot!(said(Basis::Motion, &before, &after), @"dynamics trace, a.csv: held-out acceleration error 0.5000 -> 0.1000 (seed 1)");
        insta::assert_snapshot!(said(Basis::Forces, &before, &after), @"dynamics trace, a.csv (seed 1)");
        insta::assert_snapshot!(said(Basis::Motion, &before, &before), @"dynamics trace, a.csv (seed 1)");
    }
}
