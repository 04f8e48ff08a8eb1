//! The band in which inputs move a machine.
//!
//! Where positions shake by far more than the inputs could shake the model, as an encoder does that sits before
//! an elastic gear, that band says nothing of a rigid machine, and what the others say drowns in it. A band
//! of which a share `1/w` is left tells coefficients to about
//!
//! `w · (needed / exerted)²`,
//!
//! with what the motion needs of the model as given, and what the inputs exert. What the model misses does
//! not enter: so the model as given and the same with what was found in it are compared in one band, and an error
//! after is the error before the next fit.

use crate::log::rms;
use crate::regression::Band;

/// A narrower band must tell coefficients this many times better, as variances (no unit): where what is needed is
/// noise alone, all bands tell about as much, and chance would choose. On the measured logs and their halves any
/// number from 1 to 5 chooses alike.
const WORTH: f64 = 4.0;

/// How many times narrower the band should be than that in which the log shows accelerations, in doublings
/// of its window; the mean over coordinates that inputs drive, and that need a force, decides.
pub(super) fn narrowing(
    band: impl Fn(usize) -> Band,
    needed: &[Vec<f64>],
    exerted: &[Vec<f64>],
) -> usize {
    let uncertainty = |band: &Band| -> f64 {
        let of = |(needed, exerted): (&Vec<f64>, &Vec<f64>)| {
            let [needed, exerted] = [needed, exerted].map(|force| rms(&band.limit(force)));
            (needed > 0.0 && exerted > 0.0).then(|| (needed / exerted).ln())
        };
        let driven: Vec<f64> = needed.iter().zip(exerted).filter_map(of).collect();
        let mean = driven.iter().sum::<f64>() / driven.len().max(1) as f64;
        2.0 * mean + (band.window() as f64).ln()
    };
    let (mut least, mut best) = (uncertainty(&band(1)) - WORTH.ln(), 1);
    let mut window = 0;
    for times in (1..).map(|doublings| 1 << doublings) {
        let band = band(times);
        // The length of a log limits windows.
        if band.window() == window {
            break;
        }
        window = band.window();
        let told = uncertainty(&band);
        if told < least {
            (least, best) = (told, times);
        }
    }
    best
}
