//! Whether the sensors determine each coordinate: by the information of the smoothing problem.

use super::super::dictionary::Dictionary;
use super::super::error::{TraceError, sensors_of};
use super::super::estimate::Observed;
use super::super::linearised::linearised;
use super::UNKNOWN;
use crate::log::{Record, Warning, rms};
use crate::regression::{ProcessNoise, Smoothing};

/// What is left of the uncertainty of a position that readings do not determine.
const UNDETERMINED: f64 = 0.1;

/// Notes in `record` how well its estimates are known, which are those of `observed`, the `cyclic` ones
/// of which are counted from their beginning.
///
/// # Errors
/// If the sensors leave a coordinate open that something depends on.
pub(super) fn check(
    dictionary: &Dictionary,
    (observed, cyclic): (&Observed, &[bool]),
    noise: &ProcessNoise,
    record: &mut Record,
) -> Result<(), TraceError> {
    let located = |error| TraceError::no_motion(error, &observed.record);
    let focus = dictionary.focus(&[]);
    let values = &dictionary.defaults;
    let dynamics = linearised(&focus, observed, values).map_err(located)?;
    let readings = observed.readings(&focus, values, &dynamics.accelerations());
    let variances = Smoothing::new(&dynamics, &readings, noise).variances();
    let n = dynamics.coordinate_count();
    let sd = |row: usize| {
        let each: Vec<f64> = variances.iter().map(|v| v[row].sqrt()).collect();
        rms(&each)
    };
    for i in (0..n).filter(|&i| !observed.record.is_measured(i)) {
        let (position, velocity) = (sd(i), sd(n + i));
        let is_open = position.is_nan() || position >= UNDETERMINED * UNKNOWN[0];
        let unit = focus.machine.compiled.model.coordinates[i].unit.clone();
        let coordinate = record.coordinates[i].clone();
        if is_open && !cyclic[i] {
            return Err(TraceError::Undetermined {
                coordinate,
                sensors: sensors_of(record),
                // What was not known before grows without end along the log, and says no more.
                sd: position.min(UNKNOWN[0]),
                unit,
            });
        }
        record.warnings.push(Warning::Unmeasured {
            coordinate,
            sd: (!cyclic[i]).then_some(position),
            unit,
        });
        if let Some(sensed) = &mut record.sensed {
            let position = if cyclic[i] { super::CHOSEN } else { position };
            sensed.sd[i] = [position, velocity];
        }
    }
    Ok(())
}
