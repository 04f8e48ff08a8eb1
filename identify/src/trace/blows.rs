//! Blows: single samples of an input that a log alone cannot tell from wild ones.
//!
//! Beside quick motion a velocity seems to jump at many moments, so that the log alone cannot say whether
//! a hammer hit the machine or a line of the log is broken ([`Doubt`]). The model can: it foretells the
//! motion with the sample as logged, and with what its neighbours say in its place.

use super::dictionary::Dictionary;
use super::estimate::Observed;
use super::linearised::{first_noise, linearised};
use super::settle::{Adapt, settle};
use crate::log::{Doubt, Record, stands_out};
use crate::machine::SolveError;
use crate::regression::{ProcessNoise, Whitener};
use std::ops::Range;

/// How long after a blow the motion is asked about it, s; blows that are no farther apart are one.
const ASKED: f64 = 0.2;

/// The log with those doubtful samples of its inputs set aside that the machine did not feel, as the
/// model as given says. In doubt it did, and so it did where that model says nothing of motion.
pub(super) fn decided(dictionary: &Dictionary, mut observed: Observed) -> Observed {
    let doubts = std::mem::take(&mut observed.record.doubts);
    match unfelt(dictionary, &observed, doubts) {
        Ok(unfelt) if !unfelt.is_empty() => {
            let mut decided = without(&observed, &unfelt);
            let warnings = unfelt.into_iter().map(|doubt| doubt.warning);
            decided.record.warnings.extend(warnings);
            decided
        }
        _ => observed,
    }
}

/// Which of some doubtful samples the machine did not feel.
fn unfelt(
    dictionary: &Dictionary,
    observed: &Observed,
    doubts: Vec<Doubt>,
) -> Result<Vec<Doubt>, SolveError> {
    if doubts.is_empty() {
        return Ok(doubts);
    }
    let (logged, drawn) = (observed, &without(observed, &doubts));
    // Under the noise of whichever is likelier as a whole, so that neither shakes the machine by itself.
    let [by_logged, by_drawn] = [settled(dictionary, logged)?, settled(dictionary, drawn)?];
    let noise = match by_drawn.0 < by_logged.0 {
        true => by_drawn.1,
        false => by_logged.1,
    };
    let logged = losses(dictionary, logged, &noise)?;
    let drawn = losses(dictionary, drawn, &noise)?;
    let events = events(&observed.record, doubts);
    let windows: Vec<Range<usize>> = events
        .iter()
        .map(|event| {
            let end = event[event.len() - 1].sample + asked(&observed.record);
            event[0].sample.saturating_sub(1)..end.min(drawn.len())
        })
        .collect();
    let usual = mean_outside(&drawn, &windows);
    let mut unfelt = Vec::new();
    for (event, window) in events.into_iter().zip(windows) {
        // As standard deviations, of which half the square is what they cost.
        let strange = |losses: &[f64]| {
            let each = losses[window.clone()].iter().map(|loss| loss - usual);
            (2.0 * each.sum::<f64>().max(0.0)).sqrt()
        };
        // A controller that rings does more between two samples than either says: then the motion is strange
        // without the samples, too, and no witness against them.
        if stands_out(strange(&logged), 1.0, strange(&drawn)) {
            unfelt.extend(event);
        }
    }
    Ok(unfelt)
}

/// What samples outside of some windows cost on average, nats.
fn mean_outside(losses: &[f64], windows: &[Range<usize>]) -> f64 {
    let is_outside = |k: &usize| !windows.iter().any(|window| window.contains(k));
    let outside: Vec<usize> = (0..losses.len()).filter(is_outside).collect();
    outside.iter().map(|&k| losses[k]).sum::<f64>() / outside.len().max(1) as f64
}

/// The same log with what neighbours say in the place of some samples of inputs.
fn without(observed: &Observed, doubts: &[Doubt]) -> Observed {
    let mut without = observed.clone();
    for doubt in doubts {
        for inputs in [&mut without.record.u, &mut without.curve.u] {
            inputs[doubt.input][doubt.sample] = doubt.beside;
        }
    }
    without
}

/// Doubts that are near each other, as one.
fn events(record: &Record, mut doubts: Vec<Doubt>) -> Vec<Vec<Doubt>> {
    doubts.sort_by_key(|doubt| doubt.sample);
    let mut events: Vec<Vec<Doubt>> = Vec::new();
    for doubt in doubts {
        match events.last_mut() {
            Some(event) if doubt.sample <= event[event.len() - 1].sample + asked(record) => {
                event.push(doubt);
            }
            _ => events.push(vec![doubt]),
        }
    }
    events
}

/// [`ASKED`] in samples, at least two.
fn asked(record: &Record) -> usize {
    (ASKED / record.step()).ceil().max(2.0) as usize
}

/// How unlikely the log is under the model as given beside forces as large as it says, nats, and these.
fn settled(
    dictionary: &Dictionary,
    observed: &Observed,
) -> Result<(f64, ProcessNoise), SolveError> {
    let (focus, values) = (dictionary.focus(&[]), &dictionary.defaults);
    let mut noise = first_noise(&focus, observed, values)?;
    // What inputs do between samples would excuse either.
    noise.unseen = 0.0;
    let dynamics = linearised(&focus, observed, values)?;
    let readings = observed.readings(&focus, values, &dynamics.accelerations());
    let cost = settle(&dynamics, &readings, &[], &mut noise, Adapt::ToData).cost();
    Ok((cost, noise))
}

/// What each sample costs under the model as given, beside forces of a known size, nats.
fn losses(
    dictionary: &Dictionary,
    observed: &Observed,
    noise: &ProcessNoise,
) -> Result<Vec<f64>, SolveError> {
    let (focus, values) = (dictionary.focus(&[]), &dictionary.defaults);
    let dynamics = linearised(&focus, observed, values)?;
    let readings = observed.readings(&focus, values, &dynamics.accelerations());
    Ok(Whitener::new(&dynamics, &readings, noise).losses())
}

#[cfg(test)]
mod tests {
    use super::super::wheel::{WHEEL, begun, rectangular};
    use super::*;
    use crate::log::Warning;
    use std::fmt::Write;

    /// A hammer hits a wheel, and another cell of the log is broken; both look alike.
    #[test]
    fn the_model_tells_a_blow_from_a_broken_cell() {
        let (hit, broken) = (300, 700);
        let u = |k: usize| 0.05 * (0.02 * k as f64).sin();
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(4);
        let (mut q, mut v, step) = (0.0, 0.0, 0.01);
        for k in 0..1000 {
            let felt = u(k) + if k == hit { 2.0 } else { 0.0 };
            let logged = felt + if k == broken { 2.0 } else { 0.0 };
            let t = step * k as f64;
            writeln!(text, "{t},{},{logged}", q + 2e-3 * noise()).unwrap();
            q += step * v + 0.5 * step * step * felt / 0.02;
            v += step * felt / 0.02;
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let mut observed = start.observed;
        let doubt = |sample: usize| Doubt {
            input: 0,
            sample,
            beside: u(sample),
            warning: Warning::StrangeRate { step: 1.0 },
        };
        // As a log has it that cannot tell the two apart.
        for sample in [hit, broken] {
            let logged = u(sample) + 2.0;
            observed.record.u[0][sample] = logged;
            observed.curve.u[0][sample] = logged;
        }
        observed.record.doubts = vec![doubt(hit), doubt(broken)];
        let said = observed.record.warnings.len();
        let decided = decided(&dictionary, observed);
        for inputs in [&decided.record.u[0], &decided.curve.u[0]] {
            assert!((inputs[hit] - u(hit) - 2.0).abs() < 1e-12);
            assert!((inputs[broken] - u(broken)).abs() < 1e-12);
        }
        assert_eq!(decided.record.warnings.len(), said + 1);
        assert!(decided.record.doubts.is_empty());
    }
}
