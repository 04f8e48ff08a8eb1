//! In which band forces are balanced.

use super::balance::{Balance, Forces, MOST_SAMPLES};
use super::equations::Equations;
use super::{first_columns, force_options, weighed};
use crate::regression::{Band, Told, narrowing};
use crate::smooth::smooth;
use crate::trace::dictionary::Dictionary;
use crate::trace::error::TraceError;
use crate::trace::estimate::Observed;
use crate::trace::search::is_on_a_body;
use crate::trace::subject::Subject;

/// The balance of forces in the band in which these tell most of what acts on coordinates.
///
/// # Errors
/// If the log cannot be smoothed, or a state's equation has no solution along it.
pub(super) fn in_telling_band(
    dictionary: &Dictionary,
    observed: &Observed,
) -> Result<Balance, TraceError> {
    let Observed { record, hold, .. } = observed;
    let (machine, values) = (&dictionary.machine, &dictionary.defaults);
    let located = |error| TraceError::at(error, &record.t);
    let smoothed = smooth(record)?;
    let balance = Balance::everywhere(record, &smoothed, *hold);
    let missing = balance.missing(machine, values).map_err(located)?;
    let exerted = balance.exerted(machine, values).map_err(located)?;
    let still = balance.unaccelerated();
    let states = still.remembered(machine, values).map_err(located)?;
    let columns = still.added(&states, &dictionary.by_parameter, values);
    // A load without acceleration is a weight, and other masses are as near to that as noise is.
    let mut options = force_options(dictionary);
    options.retain(|option| {
        let subject = &dictionary.candidates[option.candidate].subject;
        matches!(subject, Subject::Effect { .. }) && !is_on_a_body(dictionary, subject)
    });
    let is_something = |&column: &usize| columns[column].iter().flatten().any(|x| *x != 0.0);
    let mut own = first_columns(&options);
    own.retain(is_something);
    let band = |times| Band::of(record, &smoothed, MOST_SAMPLES, times);
    let times = narrowing(|times| {
        let band = band(times);
        let limited =
            |forces: &Forces| -> Forces { forces.iter().map(|force| band.limit(force)).collect() };
        let columns: Vec<Forces> = own
            .iter()
            .map(|&column| limited(&columns[column]))
            .collect();
        let all: Vec<usize> = (0..columns.len()).collect();
        let equations = weighed(Equations::new(&limited(&missing), &columns), &all);
        Told {
            window: band.window(),
            samples: record.len(),
            left: equations.scale(),
            exerted: &limited(&exerted),
            columns: all.len(),
        }
        .uncertainty()
    });
    Ok(balance.limited_to(band(times), times))
}
