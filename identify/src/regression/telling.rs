//! The band in which forces tell most.
//!
//! A band of which a share `1/w` is left tells coefficients to about
//!
//! `w · (left / exerted)²`,
//!
//! with what the inputs exert, and what is left of it by the model as given with all columns that no acceleration
//! enters: acceleration is what noise makes most of, and its own column takes that for a lighter machine. Where
//! positions shake by more than forces explain, as an encoder does that sits before an elastic gear, or noise
//! that was differentiated twice, what is left falls faster than a narrower band has fewer samples.
//!
//! Friction that the model lacks is among the columns: so the model as given and the same with what was found in
//! it are compared in one band, and an error after is the error before the next fit.

use crate::log::rms;
use crate::number::short;

/// A narrower band must tell coefficients this many times better, as variances (no unit): where what is left is
/// white, all bands tell about as much, and chance would choose. On the measured logs any number from 1 to 5 chooses
/// alike.
const WORTH: f64 = 4.0;

/// What forces tell in a band.
pub struct Told<'a> {
    /// Over how many samples a force is averaged there.
    pub window: usize,
    /// How many samples the log has.
    pub samples: usize,
    /// Per coordinate, root mean square of what columns leave that no acceleration enters.
    pub left: &'a [f64],
    /// Per coordinate, what inputs exert.
    pub exerted: &'a [Vec<f64>],
    /// How many these columns are.
    pub columns: usize,
}

/// How well a band tells coefficients.
#[derive(Debug, Clone, Copy)]
pub struct Uncertainty {
    window: usize,
    /// Logarithm of a variance; `None` where there is less to tell by than there are columns.
    value: Option<f64>,
}

impl Told<'_> {
    /// How well these forces tell coefficients: the mean over coordinates that inputs drive.
    pub fn uncertainty(&self) -> Uncertainty {
        let sizes = self.left.iter().zip(self.exerted);
        let driven: Vec<f64> = sizes
            .map(|(left, exerted)| (left, rms(exerted)))
            .filter(|&(left, exerted)| *left > f64::MIN_POSITIVE && exerted > 0.0)
            .map(|(left, exerted)| (left / exerted).ln())
            .collect();
        let mean = driven.iter().sum::<f64>() / driven.len().max(1) as f64;
        // Two means under a window of raised cosine are independent half a window apart.
        let window = self.window as f64;
        let independent = 2.0 * self.samples as f64 / window * driven.len() as f64;
        let spent = independent - self.columns as f64;
        let told = spent > 0.0;
        Uncertainty {
            window: self.window,
            value: told.then(|| 2.0 * mean + window.ln() + (independent / spent).ln()),
        }
    }
}

/// How many times narrower the band should be than that in which the log shows accelerations, in doublings
/// of its window.
pub fn narrowing(mut in_band: impl FnMut(usize) -> Uncertainty) -> usize {
    let own = in_band(1);
    let Some(value) = own.value else {
        return 1;
    };
    let (mut least, mut best, mut window) = (value - WORTH.ln(), 1, own.window);
    for times in (1..).map(|doublings| 1 << doublings) {
        let narrower = in_band(times);
        // The length of a log limits windows.
        if narrower.window == window {
            break;
        }
        window = narrower.window;
        if let Some(value) = narrower.value.filter(|value| *value < least) {
            (least, best) = (value, times);
        }
    }
    best
}

/// What must be known of a band in which forces are compared that is narrower than the one in which the log shows
/// accelerations; a force is averaged over `duration` s.
pub fn said_of_band(duration: f64) -> String {
    format!(
        "forces are compared below {} Hz: above, positions shake by more than forces of this model explain, as an \
         encoder before an elastic gear does, or noise by itself",
        short(1.0 / duration)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left in bands of 5, 9, 17, … samples, and in which of them forces tell most.
    fn chosen(left: impl Fn(f64) -> f64) -> usize {
        let exerted = vec![vec![1.0; 10]];
        narrowing(|times| {
            let window = (4 * times + 1).min(129);
            let left = [left(window as f64)];
            Told {
                window,
                samples: 4000,
                left: &left,
                exerted: &exerted,
                columns: 4,
            }
            .uncertainty()
        })
    }

    /// White errors are as well averaged afterwards, forces that no column explains stay, and noise that was
    /// differentiated twice falls until something else is left.
    #[test]
    fn only_what_shakes_is_left_out() {
        assert_eq!(chosen(|window| 0.1 / window.sqrt()), 1);
        assert_eq!(chosen(|_| 0.1), 1);
        assert_eq!(chosen(|window| 30.0 / window.powf(2.5) + 0.01), 8);
    }
}
