//! Logs of sensors in the place of coordinates.

use super::{FitError, Request};
use crate::log::Record;
use crate::machine::Hold;
use crate::trace::estimated_motion;
use std::collections::BTreeMap;

/// A record with coordinates that no column shows as estimated from the model's own sensors,
/// through the model as given beside forces without a name. They are taken as if they had been
/// measured: how uncertain they are shows in what the forces of the log leave unexplained.
///
/// # Errors
/// If the sensors do not determine them, or the model cannot be evaluated along the log.
pub(super) fn taken_as_measured(request: &Request<'_>, record: Record) -> Result<Record, FitError> {
    let parameters = request.compiled.model.parameters.iter();
    let values = parameters.zip(request.parameters);
    let values: BTreeMap<String, f64> = values.map(|(p, &value)| (p.name.clone(), value)).collect();
    let source = request.source;
    let source = (source.name, source.text, source.library);
    let record = estimated_motion(source, &values, record, Hold::Linear)
        .map_err(|error| FitError::Unmeasured(Box::new(error)))?;
    Ok(record.taken_as_measured())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Inertia, Source, fit};
    use crate::log::Log;
    use crate::trace::swing::{SWING, swing};
    use dynamics_codegen::{Library, compile};

    /// Of the friction of a pendulum whose angle is not in the log, by the torque that is.
    #[test]
    fn friction_is_fitted_without_a_position() {
        let library = Library::builtin();
        let compiled = compile("swing", SWING, &library).unwrap();
        let log = Log::from_bytes("swing.csv", swing(0.3, &[]).as_bytes()).unwrap();
        let source = Source {
            name: "swing",
            text: SWING,
            library: &library,
        };
        let request = Request {
            inertia: Inertia::Fixed,
            ..Request::new(source, &compiled, &[2.0], &log)
        };
        let found = fit(&request).unwrap();
        let friction = found.terms.iter().find(|term| term.term == "friction");
        let coefficients = &friction.unwrap().coefficients;
        let viscous = coefficients
            .iter()
            .find(|(name, _)| name.contains("viscous"));
        let (_, viscous) = viscous.unwrap_or_else(|| panic!("{:?}", found.terms));
        let miss = (viscous.value - 0.3).abs();
        assert!(miss < 0.02 && miss < 4.0 * viscous.std, "{viscous:?}");
        assert!(found.after.total < 0.2 * found.before.total);
    }
}
