//! What a model that is exactly right would leave of measured forces.

use super::balance::{Balance, Beside, Forces};
use crate::log::Record;
use crate::machine::Machine;
use crate::regression::Hold;
use crate::trace::error::TraceError;
use crate::trace::estimate::Observed;
use crate::trace::score::with_noise;

/// What noise of the log's sensors alone leaves of the balance of forces of a machine that obeys
/// its model, with forces `beside` it, along the log, in a band that is `narrowing` times narrower than that in
/// which it shows accelerations: per coordinate, a value per kept sample. Noise of the forces
/// themselves is known where the machine did not feel it, that of channels that somebody has filtered is not.
///
/// # Errors
/// If the log cannot be smoothed, or an equation of motion has no solution along it.
pub(crate) fn force_floor(
    record: &Record,
    machine: &Machine,
    values: &[f64],
    beside: &Beside<'_>,
    (narrowing, seed): (usize, u64),
) -> Result<Vec<Vec<f64>>, TraceError> {
    // What inputs do between samples matters to memory only, and that to no term of a fit.
    let hold = Hold::Linear;
    let balance = Balance::narrowed(record, hold, narrowing)?;
    let observed = Observed::new(record.clone(), hold)?;
    left_by_noise((&balance, &observed), (machine, values), Some(beside), seed)
}

/// The same where the log has been looked at already.
pub(super) fn left_by_noise(
    (balance, observed): (&Balance, &Observed),
    (machine, values): (&Machine, &[f64]),
    beside: Option<&Beside<'_>>,
    seed: u64,
) -> Result<Forces, TraceError> {
    // Of the channels that are some sensor's, and of inputs whose noise is known.
    let sensed = &observed.record;
    let located = |error| TraceError::at(error, &sensed.t);
    let obeying = balance.obeying(sensed, machine, values, beside);
    let obeying = obeying.map_err(located)?;
    let noisy = balance.of_another(&with_noise(obeying, observed, seed))?;
    let left = noisy.missing_beside(machine, values, beside);
    left.map_err(located)
}
