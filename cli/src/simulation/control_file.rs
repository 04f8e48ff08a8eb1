//! The TOML file of a controller.

use super::controller::Fed;
use crate::inputs::Inputs;
use crate::mistake::{Mistake, Place};
use crate::{model, parameters};
use dynamics_codegen::Model;
use dynamics_codegen::file::Limit;
use identify::log::too_deep;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// A controller is a page.
const LIMIT: Limit = Limit {
    what: "a file of a controller",
    bytes: 1 << 20,
};
const KEYS: &str = "`docs/control.md` has all keys, with an example";
/// Samples of delay at most.
const LONGEST_DELAY: i64 = 100_000;

/// What a file says, checked against a model.
pub(super) struct File {
    /// s.
    pub interval: f64,
    /// In samples.
    pub delay: usize,
    pub feedback: Vec<Fed>,
    pub reference: Reference,
    pub inputs: Vec<usize>,
    /// A row per commanded input.
    pub gain: Vec<Vec<f64>>,
    /// Per commanded input.
    pub limits: Vec<(f64, f64)>,
}

/// What the readings should be.
pub(super) enum Reference {
    Constant(Vec<f64>),
    Over(Inputs),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    rate: Spanned<f64>,
    delay: Option<Spanned<i64>>,
    feedback: Spanned<Vec<Spanned<String>>>,
    reference: Option<Spanned<WrittenReference>>,
    gain: Spanned<BTreeMap<Spanned<String>, Spanned<Vec<f64>>>>,
    #[serde(default)]
    limits: BTreeMap<Spanned<String>, Spanned<Vec<f64>>>,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a list of numbers, or the name of a CSV file"
)]
enum WrittenReference {
    Constant(Vec<f64>),
    File(String),
}

/// Reads a file; `readings` are the names of what can be fed back.
///
/// # Errors
/// With the place of what is wrong.
pub(super) fn read(path: &Path, model: &Model, readings: &[String]) -> Result<File, Mistake> {
    let bytes = model::read(path, LIMIT)?;
    let file = path.display().to_string();
    let text = parameters::text(&file, &bytes)?;
    let reader = Reader { path, text };
    if let Some(at) = too_deep(text) {
        return Err(reader
            .mistake(at..at + 1, "brackets nest too deep")
            .help("close each `{` and `[` in the line that opens it"));
    }
    let written: Written = toml::from_str(text).map_err(|error| {
        let message = error.message().trim_end().to_string();
        match error.span() {
            Some(span) => reader.mistake(span, message),
            None => Mistake::new(format!("`{file}`: {message}")),
        }
        .help(KEYS)
    })?;
    reader.file(&written, model, readings)
}

struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Reader<'_> {
    fn mistake(&self, range: Range<usize>, message: impl Into<String>) -> Mistake {
        let place = Place {
            file: self.path.display().to_string(),
            first_line: 1,
            text: self.text.to_string(),
            range,
            label: String::new(),
        };
        Mistake::at(place, message)
    }

    fn file(&self, written: &Written, model: &Model, readings: &[String]) -> Result<File, Mistake> {
        let rate = *written.rate.get_ref();
        if !(rate.is_finite() && rate > 0.0) {
            return Err(self
                .mistake(written.rate.span(), "a rate is a number above 0")
                .help("samples per second, such as `rate = 100`"));
        }
        let delay = written.delay.as_ref().map_or(0, |d| *d.get_ref());
        let delay = match usize::try_from(delay) {
            Ok(samples) if delay <= LONGEST_DELAY => samples,
            _ => {
                let span = written.delay.as_ref().map_or(0..0, Spanned::span);
                let message = format!("a delay is 0 to {LONGEST_DELAY} samples");
                let help = "the rate is that of the controller, not of the log";
                return Err(self.mistake(span, message).help(help));
            }
        };
        let feedback = written.feedback.get_ref();
        if feedback.is_empty() {
            let message = "nothing is fed back";
            let help = "name readings, such as `feedback = [\"q_x\", \"rate(q_x)\"]`";
            return Err(self.mistake(written.feedback.span(), message).help(help));
        }
        let names: Vec<&str> = feedback
            .iter()
            .map(|name| name.get_ref().as_str())
            .collect();
        let feedback = feedback.iter().map(|name| self.fed(name, readings));
        let feedback: Vec<Fed> = feedback.collect::<Result<_, _>>()?;
        let (inputs, gain) = self.gain(written, model, names.len())?;
        let limits = self.limits(written, model, &inputs)?;
        Ok(File {
            interval: 1.0 / rate,
            delay,
            reference: self.reference(written, &names)?,
            feedback,
            inputs,
            gain,
            limits,
        })
    }

    fn fed(&self, name: &Spanned<String>, readings: &[String]) -> Result<Fed, Mistake> {
        let text = name.get_ref();
        let rated = text.strip_prefix("rate(").and_then(|t| t.strip_suffix(')'));
        let meant = rated.unwrap_or(text);
        match readings.iter().position(|reading| reading == meant) {
            Some(reading) => Ok(Fed {
                reading,
                is_rate: rated.is_some(),
            }),
            None => {
                let message = format!("nothing is called `{meant}` that could be fed back");
                let known = readings.iter().map(String::as_str);
                let mistake = self.mistake(name.span(), message);
                Err(parameters::suggest(mistake, meant, known))
            }
        }
    }

    /// Which input a key names.
    fn input(&self, name: &Spanned<String>, model: &Model) -> Result<usize, Mistake> {
        let text = name.get_ref();
        let place = model.inputs.iter().position(|u| u.name == *text);
        place.ok_or_else(|| {
            let mistake = self.mistake(name.span(), format!("the model has no input `{text}`"));
            parameters::suggest(mistake, text, model.inputs.iter().map(|u| u.name.as_str()))
        })
    }

    fn gain(
        &self,
        written: &Written,
        model: &Model,
        width: usize,
    ) -> Result<(Vec<usize>, Vec<Vec<f64>>), Mistake> {
        let (mut inputs, mut rows) = (Vec::new(), Vec::new());
        for (name, row) in written.gain.get_ref() {
            inputs.push(self.input(name, model)?);
            let numbers = row.get_ref();
            if numbers.len() != width || numbers.iter().any(|k| !k.is_finite()) {
                let message = format!("a row of gains needs {width} finite numbers");
                let help = "one per entry of `feedback`, in that order";
                return Err(self.mistake(row.span(), message).help(help));
            }
            rows.push(numbers.clone());
        }
        if rows.is_empty() {
            let message = "no input has gains";
            let help = "add a row per input: `[gain]`, then `input = [ … ]`";
            return Err(self.mistake(written.gain.span(), message).help(help));
        }
        Ok((inputs, rows))
    }

    fn limits(
        &self,
        written: &Written,
        model: &Model,
        inputs: &[usize],
    ) -> Result<Vec<(f64, f64)>, Mistake> {
        let mut limits = vec![(f64::NEG_INFINITY, f64::INFINITY); inputs.len()];
        for (name, pair) in &written.limits {
            let input = self.input(name, model)?;
            let Some(row) = inputs.iter().position(|&known| known == input) else {
                let message = format!("`{}` has limits and no gains", name.get_ref());
                let help = "add its row under `[gain]`, or take the limits out";
                return Err(self.mistake(name.span(), message).help(help));
            };
            match pair.get_ref()[..] {
                [lower, upper] if lower <= upper => limits[row] = (lower, upper),
                _ => {
                    let message = "limits are two numbers, the lower first";
                    let help = format!("such as `{} = [-2, 2]`", name.get_ref());
                    return Err(self.mistake(pair.span(), message).help(help));
                }
            }
        }
        Ok(limits)
    }

    fn reference(&self, written: &Written, names: &[&str]) -> Result<Reference, Mistake> {
        let Some(reference) = &written.reference else {
            return Ok(Reference::Constant(vec![0.0; names.len()]));
        };
        match reference.get_ref() {
            WrittenReference::Constant(values) => {
                if values.len() != names.len() || values.iter().any(|r| !r.is_finite()) {
                    let message = format!("a reference needs {} finite numbers", names.len());
                    let help = "one per entry of `feedback`, in that order";
                    return Err(self.mistake(reference.span(), message).help(help));
                }
                Ok(Reference::Constant(values.clone()))
            }
            WrittenReference::File(name) => {
                let folder = self.path.parent().unwrap_or(Path::new(""));
                Inputs::read_columns(&folder.join(name), names).map(Reference::Over)
            }
        }
    }
}
