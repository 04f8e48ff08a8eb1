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
    /// How surely runs gain, see [`signed_ranks`].
    #[serde(skip)]
    pub(super) sureness: f64,
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
            sureness: signed_ranks(&gains),
        }
    }

    /// Whether there is a gain, and more than the chance of a few runs.
    pub(super) fn is_better(&self) -> bool {
        self.gain > 0.0 && self.sureness > SURE
    }

    /// Whether data become less likely, by more than the chance of a few runs.
    pub(super) fn is_worse(&self) -> bool {
        self.gain < 0.0 && self.sureness < -SURE
    }
}

/// Wilcoxon's signed-rank statistic: how many standard deviations the ranks of the gains' sizes, each
/// with its gain's sign, sum to above nothing, if a gain were as often a loss. Runs in which a machine
/// moves fast gain ten times what others do: gains that are all positive are sure, however much they
/// differ, while their mean, by its standard error, is not.
fn signed_ranks(gains: &[f64]) -> f64 {
    let smaller = |size: f64| gains.iter().filter(|own| own.abs() < size).count();
    let equal = |size: f64| gains.iter().filter(|own| own.abs() == size).count();
    let rank = |gain: &f64| smaller(gain.abs()) as f64 + (equal(gain.abs()) as f64 + 1.0) / 2.0;
    let signed = |gain: &f64| match *gain {
        0.0 => 0.0,
        gain => rank(&gain).copysign(gain),
    };
    let sum: f64 = gains.iter().map(signed).sum();
    let squares: f64 = gains.iter().map(|gain| rank(gain).powi(2)).sum();
    sum / squares.sqrt()
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
    fn gains_are_sure_that_most_runs_make() {
        let given = [5.0; 10];
        let even: Vec<f64> = (0..10).map(|run| 4.0 + 0.1 * f64::from(run)).collect();
        assert!(Foretold::new(&given, &even).is_better());
        let mut once = given;
        once[3] = -40.0;
        assert!(!Foretold::new(&given, &once).is_better());
        assert!(!Foretold::new(&even, &given).is_better());
        assert!(Foretold::new(&even, &given).is_worse());
        assert!(!Foretold::new(&once, &given).is_worse());
        // Ten gains that differ ten thousandfold are gains.
        let some: Vec<f64> = (0..10).map(|run| 5.0 - 3.0_f64.powi(run)).collect();
        let foretold = Foretold::new(&given, &some);
        assert!(foretold.gain < SURE * foretold.error && foretold.is_better());
        // Nothing but gains of ten sizes: Σ r/√Σ r².
        assert!((foretold.sureness - 55.0 / 385.0_f64.sqrt()).abs() < 1e-12);
        // Ten gains of 0.55 in the mean that differ by 0.3028 (n − 1).
        let foretold = Foretold::new(&given, &even);
        assert!((foretold.gain - 5.5).abs() < 1e-12);
        assert!((foretold.error - 10.0_f64.sqrt() * 0.302_765).abs() < 1e-5);
    }
}
