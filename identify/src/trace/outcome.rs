//! What tracing a log says.

use super::advice::Advice;
use super::estimate::Observed;
use super::finding::{Finding, Verdict};
use super::foretold::Foretold;
use super::microscope::Unnamed;
use super::misread::Misread;
use super::progress::Ended;
use super::remaining::Remaining;
use super::score::Score;
use super::series::Details;
use crate::regression::Hold;
use serde::Serialize;
use std::collections::BTreeMap;

/// Which samples served what.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Split {
    /// The log that was learnt from.
    pub train_log: String,
    /// Its samples that were used.
    pub train_samples: usize,
    /// The log that was judged by.
    pub test_log: String,
    /// Its samples that were used.
    pub test_samples: usize,
    /// How the two were kept apart.
    pub method: String,
}

/// What effects were found in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Basis {
    /// Motion as it follows from inputs: what explains it leaves sensor noise.
    Motion,
    /// The balance of measured forces: many effects at once, or a model that cannot move as
    /// given. Other forces remain.
    Forces,
}

/// How it is known what inputs do between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum HoldIs {
    /// The request says so.
    Stated,
    /// The log is likelier so, or as likely and nothing that was found hangs on it.
    Found,
    /// The log is about as likely the other way, and times that were found are others then.
    Undecided,
    /// Nothing asked the log.
    Assumed,
}

/// A model that agrees with a log errs at most this many times as much as sensor noise makes it, and
/// as on what was learnt from, unless it errs by less than this share of the signal.
const FAR: (f64, f64) = (3.0, 3e-3);
/// One whose accelerations err at most this many times as much as sensor noise makes them is right,
/// however far from the log its predictions run.
pub(super) const AT_FLOOR: f64 = 1.05;

/// Whether a model's errors on data that nothing was fitted to are too large for one that agrees
/// with the log: many times those of a model that is exactly right, the `floor`, or those on what
/// was learnt from, as shares and in the coordinates' own units. A floor follows the log, and with
/// it samples that are no measurements; a log that is slower shows the same noise as a larger share.
pub(super) fn is_far(errors: &Score, floor: &Score, trained: &Score) -> bool {
    let far = |error: f64, floor: f64| error > FAR.0 * floor && error > FAR.1;
    let accelerations = [errors, floor].map(|score| score.acceleration.total);
    let predictions = [errors, floor].map(|score| score.rollout.errors.total);
    let at_floor = accelerations[0] < AT_FLOOR * accelerations[1];
    let own = errors.acceleration.per_coordinate.iter();
    let mut own = own.map(|(name, error)| (error, trained.acceleration.per_coordinate.get(name)));
    // Another motion may show the same noise as larger accelerations, but not where it goes.
    let is_unlike = far(accelerations[0], trained.acceleration.total)
        && (predictions[0].is_nan() || predictions[0] > FAR.0 * trained.rollout.errors.total)
        && own.any(|(error, trained)| trained.is_some_and(|trained| *error > FAR.0 * trained));
    is_unlike
        || far(accelerations[0], accelerations[1])
        || !at_floor && far(predictions[0], predictions[1])
}

/// Whether a model's accelerations err by more than those of the log deviate from their mean, and many
/// times as much as those of a model that is exactly right, the `floor`, and its predictions by more than the motion
/// goes: the mean, and that everything stays where it is, foretell the log better. A machine that sticks hardly
/// accelerates, so that what little is missing makes many times that; where it goes is foretold nevertheless.
pub(super) fn foretells_less_than_a_mean(errors: &Score, floor: &Score) -> bool {
    let [error, floor] = [errors, floor].map(|score| score.acceleration.total);
    let foretold = errors.rollout.errors.total < 1.0;
    error > 1.0 && error > FAR.0 * floor && !foretold
}

/// What comes nearest to an explanation where nothing is one, and what it would do. Nothing of it
/// is written into the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Nearest {
    /// What it is made of, strongest first.
    pub findings: Vec<Finding>,
    /// Errors with it, on data that neither fitting nor selection saw.
    pub errors: Score,
    /// Mean squared whitened prediction error with it, on the training data.
    pub misfit: f64,
    /// Root mean square of the accelerations that unexplained forces make with it, as a share of
    /// the machine's own.
    pub share: f64,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Outcome {
    /// What kind of error the model has.
    pub verdict: Verdict,
    /// What effects were found in.
    pub basis: Basis,
    /// What it lacks, strongest first: what the patched model has written in.
    pub findings: Vec<Finding>,
    /// What was weighed and found wanting, if the verdict is that nothing explains the log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nearest: Option<Nearest>,
    /// Errors on data that neither fitting nor selection saw, of the model as given.
    pub before: Score,
    /// The same of the patched model. Of drives alone, as two measured columns show them, nothing
    /// changes: the log has what they put out. Where columns are mistaken, of the model as given
    /// on the log read otherwise.
    pub after: Score,
    /// The same if the patched model were exactly right.
    pub noise_floor: Score,
    /// What is gained by what was found, or comes nearest, on data that neither fitting nor selection
    /// saw; drives that two measured columns show are not counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub foretold: Option<Foretold>,
    /// What the findings leave unexplained; if there are none, what the model as given does.
    pub remaining: Remaining,
    /// What has no name, if the verdict says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unnamed: Option<Unnamed>,
    /// Mean squared whitened prediction error on the training data, of the model as given; not a
    /// number where columns are mistaken and nothing was fitted.
    pub misfit_before: f64,
    /// The same of the patched model; one if sensor noise explains it.
    pub misfit_after: f64,
    /// Log likelihood of the training samples under the model as given, nats, if noise alone is to blame for what it
    /// leaves; up to what depends on the log alone. Of two models traced on one log the larger is the likelier, if they
    /// differ by more than about ten nats: the smallest forces that are looked for are a share of the model's own. Not
    /// a number where columns are mistaken and nothing was fitted.
    pub log_likelihood_before: f64,
    /// The same of the patched model.
    pub log_likelihood_after: f64,
    /// Estimated standard deviation of each channel's noise; of an input where the machine did not feel
    /// it.
    pub sensor_noise: BTreeMap<String, f64>,
    /// What inputs do between samples.
    pub input_hold: Hold,
    /// How that is known.
    pub input_hold_is: HoldIs,
    /// The times that were found, s, if inputs do the other thing between samples, by effect, place
    /// and name (`input_delay (motor) tau`): where the log does not tell the two apart.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub if_held_otherwise: BTreeMap<String, f64>,
    /// How late channels are beside that, s, where it is half a sample or less: what a drive does
    /// between the samples of a log, and no finding.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub between_samples: BTreeMap<String, f64>,
    /// Which samples served what.
    pub split: Split,
    /// Why the search ended before it was done; what was found is the best until then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unfinished: Option<Ended>,
    /// Seed of everything random.
    pub seed: u64,
    /// Columns of the log that are probably not what they are taken for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub misread: Option<Misread>,
    /// What should be known about the logs.
    pub warnings: Vec<String>,
    /// What to do next, the most useful first.
    pub next: Vec<Advice>,
    /// The model with the findings written in.
    pub patched_model: String,
    /// Curves and candidates, for plots; not part of the JSON outcome. Where something comes
    /// nearest, curves "after" are with that.
    #[serde(skip)]
    pub details: Details,
}

/// Estimated standard deviation of each channel's noise, by column.
pub(super) fn sensor_noise(observed: &Observed) -> BTreeMap<String, f64> {
    let record = &observed.record;
    let mut noise = BTreeMap::new();
    let sensed = record.sensed.iter().flat_map(|sensed| &sensed.readings);
    noise.extend(sensed.map(|reading| (reading.name.clone(), reading.sd)));
    let coordinates = record.coordinates.iter().enumerate();
    for (i, name) in coordinates.filter(|(i, _)| record.is_measured(*i)) {
        noise.insert(format!("q_{name}"), observed.position_sd[i]);
        if record.dq[i].is_some() {
            noise.insert(format!("dq_{name}"), observed.velocity_sd[i]);
        }
        if record.ddq[i].is_some() {
            noise.insert(format!("ddq_{name}"), observed.acceleration_sd[i]);
        }
    }
    for (input, sd) in observed.noisy_inputs() {
        noise.insert(format!("u_{}", record.inputs[input]), sd);
    }
    noise
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::score::{Errors, RolloutErrors};
    use proptest::prelude::*;

    fn score(acceleration: f64, rollout: f64) -> Score {
        let errors = |total| Errors {
            per_coordinate: BTreeMap::from([("j".to_string(), total)]),
            total,
        };
        Score {
            acceleration: errors(acceleration),
            force: errors(f64::NAN),
            rollout: RolloutErrors {
                horizon: 0.5,
                windows: 1,
                diverged: 0,
                errors: errors(rollout),
            },
        }
    }

    #[test]
    fn errors_at_the_floor_or_too_small_to_matter_are_not_far() {
        let floor = score(0.0065, 0.002);
        let is_far = |errors: &Score, floor: &Score| super::is_far(errors, floor, floor);
        assert!(is_far(&score(0.258, 0.002), &floor));
        assert!(is_far(&score(0.01, 0.1), &floor));
        // Of an unstable machine.
        assert!(!is_far(&score(0.0065, 0.1), &floor));
        assert!(!is_far(&score(0.01, f64::NAN), &floor));
        assert!(!is_far(&score(0.002, 0.002), &score(1e-5, 1e-5)));
    }

    #[test]
    fn a_floor_that_follows_the_log_does_not_hide_that_it_is_unlike_the_other() {
        let (errors, floor) = (score(0.5, 0.03), score(0.5, 0.03));
        let mut trained = score(0.01, 0.003);
        assert!(is_far(&errors, &floor, &trained));
        assert!(!is_far(&errors, &floor, &score(0.01, 0.03)));
        // As much noise beside more motion.
        trained.acceleration.per_coordinate.insert("j".into(), 0.4);
        assert!(!is_far(&errors, &floor, &trained));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// What is not far stays so with smaller errors, and with more noise.
        #[test]
        fn less_is_never_farther(
            [a, r] in prop::array::uniform2(0.0..1.0_f64),
            [floor_a, floor_r] in prop::array::uniform2(1e-4..1.0_f64),
            less in 0.0..1.0_f64,
        ) {
            let (errors, floor) = (score(a, r), score(floor_a, floor_r));
            if !is_far(&errors, &floor, &floor) {
                prop_assert!(a <= 3.0 * floor_a || a <= 3e-3);
                prop_assert!(!is_far(&score(less * a, less * r), &floor, &floor));
                let more = score(floor_a / less.max(1e-3), floor_r / less.max(1e-3));
                prop_assert!(!is_far(&errors, &more, &more));
            }
        }
    }
}
