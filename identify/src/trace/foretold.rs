//! How much likelier findings make data that nothing was fitted to, beside forces without a name.

use super::dictionary::Dictionary;
use super::linearised::linearised;
use super::refine::Explanation;
use super::settings::SURE;
use crate::machine::SolveError;
use crate::regression::Whitener;
use serde::Serialize;

/// What findings gain on data that nothing was fitted to: how much likelier they make it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Foretold {
    /// Nats in all. In the balance of forces what the squares of the forces that are left lose, in
    /// units of their mean afterwards, as far as samples are news.
    pub gain: f64,
    /// The standard error of that, from how much it differs from run to run of the log, nats.
    pub error: f64,
}

impl Foretold {
    /// Of negative log likelihoods under the model as given and with findings, run by run of the log,
    /// nats.
    pub(super) fn new(given: &[f64], patched: &[f64]) -> Self {
        let pairs = given.iter().zip(patched);
        let gains: Vec<f64> = pairs.map(|(given, patched)| given - patched).collect();
        let (count, gain) = (gains.len() as f64, gains.iter().sum::<f64>());
        let squares: f64 = gains.iter().map(|own| (own - gain / count).powi(2)).sum();
        Self {
            gain,
            error: (count * squares / (count - 1.0)).sqrt(),
        }
    }

    /// Whether the gain is more than the chance of a few runs.
    pub(super) fn is_better(&self) -> bool {
        self.gain > SURE * self.error
    }

    /// Whether data become less likely, by more than the chance of a few runs.
    pub(super) fn is_worse(&self) -> bool {
        self.gain < -SURE * self.error
    }
}

/// The negative log likelihood of each run of a log, nats, under an explanation with some terms,
/// beside the white and lasting forces that it holds.
///
/// # Errors
/// If the equation of motion has no solution along the log.
pub(super) fn costs(
    dictionary: &Dictionary,
    terms: &[usize],
    explanation: &Explanation,
) -> Result<Vec<f64>, SolveError> {
    let Explanation {
        observed,
        values,
        noise,
    } = explanation;
    let focus = dictionary.focus(terms);
    let dynamics = linearised(&focus, observed, values)?;
    let readings = observed.readings(&focus, values, &dynamics.accelerations());
    Ok(Whitener::new(&dynamics, &readings, noise).costs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_that_one_run_makes_is_chance() {
        let given = [5.0; 10];
        let even: Vec<f64> = (0..10).map(|run| 4.0 + 0.1 * f64::from(run)).collect();
        assert!(Foretold::new(&given, &even).is_better());
        let mut once = given;
        once[3] = -40.0;
        assert!(!Foretold::new(&given, &once).is_better());
        assert!(!Foretold::new(&even, &given).is_better());
        assert!(Foretold::new(&even, &given).is_worse());
        assert!(!Foretold::new(&once, &given).is_worse());
        // Ten gains of 0.55 in the mean that differ by 0.3028 (n − 1).
        let foretold = Foretold::new(&given, &even);
        assert!((foretold.gain - 5.5).abs() < 1e-12);
        assert!((foretold.error - 10.0_f64.sqrt() * 0.302_765).abs() < 1e-5);
    }
}
