//! Errors of forces on a log that nothing was fitted to.

use super::balance::{Balance, Forces};
use super::floor::left_by_noise;
use super::known;
use crate::log::{Record, rms, share_of_news};
use crate::regression::{BLOCKS, Hold};
use crate::trace::dictionary::Dictionary;
use crate::trace::error::TraceError;
use crate::trace::estimate::Observed;
use crate::trace::foretold::Foretold;
use crate::trace::judge::{HeldOut, Judged, Models, motionless};
use crate::trace::run::Request;
use crate::trace::score::{Errors, Look, ScoreError, deviation};
use crate::trace::selection::Selection;
use crate::trace::series::{Explained, Series};

/// Before, after, and the floor. The force is what the balance `M a − Q` leaves, in the band
/// in which it was looked for; accelerations and predictions are as everywhere, and infinitely wrong
/// where a model cannot move. What findings gain is what they take from the squares of what is left.
///
/// # Errors
/// If the log cannot be smoothed, or an equation of motion has no solution along it.
pub(in crate::trace) fn judge(
    dictionary: &Dictionary,
    selection: &Selection,
    test: &Record,
    request: &Request<'_>,
    hold: Hold,
) -> Result<HeldOut, TraceError> {
    let located = |error| TraceError::at(error, &test.t);
    let models = Models::new(dictionary, selection);
    let (machine, values) = (&models.patched.focus.machine, &models.patched.values);
    let balance = Balance::narrowed(test, hold, selection.narrowing)?;
    let exerted = balance.exerted(machine, values).map_err(located)?;
    let exerted = known(exerted, &selection.observed, (machine, values)).map_err(located)?;
    let scale: Vec<f64> = exerted.iter().map(|force| deviation(force)).collect();
    let missing = |model: &Judged<'_>| balance.missing(&model.focus.machine, &model.values);
    let [given, patched] = [&models.given, &models.patched].map(missing);
    let (given, patched) = (given.map_err(located)?, patched.map_err(located)?);
    let errors = |forces: &Forces| {
        let sizes: Vec<f64> = forces.iter().map(|force| rms(force)).collect();
        Errors::of(test, &sizes, &scale)
    };
    let look = |model: &Judged<'_>, left: &Forces| -> Result<Look, TraceError> {
        let (machine, values) = (&model.focus.machine, &model.values);
        let mut look = match model.scoring(hold, request.horizon).look(test) {
            Ok(look) => look,
            Err(ScoreError::Smooth(error)) => return Err(error.into()),
            Err(ScoreError::Solve(_)) => motionless(test, request.horizon)?,
        };
        look.score.force = errors(left);
        look.missing = balance
            .missing_everywhere(machine, values)
            .map_err(located)?;
        Ok(look)
    };
    let (before, after) = (
        look(&models.given, &given)?,
        look(&models.patched, &patched)?,
    );
    let observed = Observed {
        input_noise: selection.observed.input_noise.clone(),
        ..Observed::new(test.clone(), hold)?
    };
    let scoring = models.patched.scoring(hold, request.horizon);
    let mut floor = match scoring.noise_floor(&observed, true, request.seed) {
        Ok(floor) => floor,
        Err(ScoreError::Smooth(error)) => return Err(error.into()),
        Err(ScoreError::Solve(_)) => motionless(test, request.horizon)?.score,
    };
    let quiet = observed.with_quiet_inputs();
    let forces = left_by_noise((&balance, &quiet), (machine, values), None, request.seed)?;
    floor.force = errors(&forces);
    let explained = Models::without_each(dictionary, selection).map(|(subject, model)| {
        let (machine, values) = (&model.focus.machine, &model.values);
        let without = balance.missing_everywhere(machine, values)?;
        Ok(Explained::new(subject, without))
    });
    let explained = explained.collect::<Result<_, _>>().map_err(located)?;
    let series = Series::new(models.in_series(), &observed, [&before, &after], explained)
        .map_err(located)?;
    let foretold = foretold(&given, &patched);
    Ok(HeldOut {
        scores: [before.score, after.score, floor],
        series,
        foretold: (!selection.terms.is_empty()).then_some(foretold),
    })
}

/// What is gained run by run where forces that are left become others: nats, in units of what is left
/// after, as far as its samples are news.
fn foretold(given: &Forces, patched: &Forces) -> Foretold {
    let units = patched.iter().map(|left| {
        let size = rms(left).max(f64::MIN_POSITIVE.sqrt());
        0.5 * share_of_news(left) / size.powi(2)
    });
    let units: Vec<f64> = units.collect();
    let cost = |forces: &Forces, run: usize| -> f64 {
        let of = |(left, unit): (&Vec<f64>, &f64)| {
            let bound = |run: usize| run * left.len() / BLOCKS;
            let own = &left[bound(run)..bound(run + 1)];
            unit * own.iter().map(|x| x * x).sum::<f64>()
        };
        forces.iter().zip(&units).map(of).sum()
    };
    let costs =
        |forces: &Forces| -> Vec<f64> { (0..BLOCKS).map(|run| cost(forces, run)).collect() };
    Foretold::new(&costs(given), &costs(patched))
}
