//! Which effects of a library are a drive's delay, lag, gain and bias: told by what they make of a
//! test signal, whatever they are called.

use super::Drive;
use crate::log::rms;
use crate::machine::{Hold, States};
use crate::trace::dictionary::Dictionary;
use dynamics_codegen::syntax::PortKind;

/// How long a test signal is, in steps of [`TEST_STEP`], s.
const TEST_SAMPLES: usize = 5000;
const TEST_STEP: f64 = 2e-4;
/// The frequencies in it, rad/s: a delay and a lag differ by much.
const TEST_WAVES: [f64; 2] = [9.0, 40.0];
/// Delay and lag (s), gain and bias that are tried on it.
const TEST_VALUES: [f64; 4] = [0.03, 0.03, 1.3, 0.2];
/// The four where they do nothing.
const NOTHING: [f64; 4] = [0.0, 0.0, 1.0, 0.0];
/// An effect is one of the four if what it changes differs by less than this share.
const THE_SAME: f64 = 0.05;

/// The candidates that are a delay, a lag, a gain and a bias of an input.
pub(super) fn parts(dictionary: &Dictionary, input: &str) -> [Option<usize>; 4] {
    let t: Vec<f64> = (0..TEST_SAMPLES).map(|k| TEST_STEP * k as f64).collect();
    let wave = |&t: &f64| TEST_WAVES.iter().map(|w| (w * t).sin()).sum::<f64>();
    let command: Vec<f64> = t.iter().map(wave).collect();
    let Some(given) = answer(dictionary, None, input, (&t, &command)) else {
        return [None; 4];
    };
    let drive = Drive {
        t: &t,
        command: &given,
        answer: &given,
    };
    let model = &dictionary.machine.compiled.model;
    let place = (PortKind::Input, input.to_string());
    let is_alone = |&candidate: &usize| {
        let candidate = &dictionary.candidates[candidate];
        let [only] = candidate.parameters[..] else {
            return false;
        };
        let effect = model.parameters[only].effect.map(|e| &model.effects[e]);
        candidate.channel && effect.is_some_and(|effect| effect.on == [place.clone()])
    };
    let alone: Vec<usize> = (0..dictionary.candidates.len()).filter(is_alone).collect();
    std::array::from_fn(|part| {
        let mut values = NOTHING;
        values[part] = TEST_VALUES[part];
        // What the part takes away of what arrives.
        let expected = drive.left(values);
        let is_part = |&&candidate: &&usize| {
            let parameter = dictionary.candidates[candidate].parameters[0];
            let bounds = &model.parameters[parameter];
            let value = TEST_VALUES[part];
            if !(bounds.lower..=bounds.upper).contains(&value) {
                return false;
            }
            let changed = answer(dictionary, Some((candidate, value)), input, (&t, &command));
            changed.is_some_and(|changed| {
                let pairs = given.iter().zip(&changed).zip(&expected);
                let apart: Vec<f64> = pairs.map(|((g, c), e)| g - c - e).collect();
                rms(&apart) < THE_SAME * rms(&expected)
            })
        };
        alone.iter().find(is_part).copied()
    })
}

/// What arrives of a command, with a candidate whose only parameter has a value; `None` if the model
/// cannot say it.
fn answer(
    dictionary: &Dictionary,
    candidate: Option<(usize, f64)>,
    input: &str,
    (t, command): (&[f64], &[f64]),
) -> Option<Vec<f64>> {
    let alone: Vec<usize> = candidate.iter().map(|(index, _)| *index).collect();
    let focus = dictionary.focus(&alone);
    let mut values = dictionary.defaults.clone();
    if let Some((index, value)) = candidate {
        values[dictionary.candidates[index].parameters[0]] = value;
    }
    let values = focus.values(&values);
    let model = &focus.machine.compiled.model;
    let index = model.inputs.iter().position(|u| u.name == input)?;
    let nothing = |count: usize| vec![vec![0.0; t.len()]; count];
    let n = model.coordinates.len();
    let mut states = States {
        t: t.to_vec(),
        q: nothing(n),
        v: nothing(n),
        u: nothing(model.inputs.len()),
        ..States::default()
    };
    states.u[index] = command.to_vec();
    let states = focus
        .machine
        .remember(&states, Hold::Linear, &values)
        .ok()?;
    Some(focus.machine.arriving(index, &states, &values))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::wheel::{WHEEL, begun};

    /// Whatever the effects are called, and beside a gain that the model states.
    #[test]
    fn the_parts_are_told_by_what_they_do() {
        let mut text = String::from("t,q_angle,u_motor\n");
        for k in 0..400 {
            let t = 0.005 * f64::from(k);
            text += &format!("{t},{},{}\n", (3.0 * t).sin(), (3.0 * t).cos());
        }
        let (dictionary, _) = begun(WHEEL, &text, ["angle", "motor"]);
        let names = parts(&dictionary, "motor").map(|found| {
            let candidate = &dictionary.candidates[found.unwrap()];
            candidate.subject.name().to_string()
        });
        assert_eq!(
            names,
            ["input_delay", "input_lag", "input_gain", "input_bias"]
        );
        let stated = format!("{WHEEL}effect input_gain(motor) {{ gain = 0.7 }}\n");
        let (dictionary, _) = begun(&stated, &text, ["angle", "motor"]);
        let found = parts(&dictionary, "motor").map(|found| found.is_some());
        assert_eq!(found, [true, true, false, true]);
    }
}
