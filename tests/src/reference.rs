//! What CasADi says about the models: the files of `casadi/expected`.
//!
//! The equations there follow from energies and constraints stated a second time, in
//! `casadi/models.py`, by another differentiator and another solver.

use crate::files::root;
use serde_json::Value;

/// One file: a model and its states.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The model's name.
    pub model: String,
    /// Names of the coordinates, in the order of the arrays.
    pub coordinates: Vec<String>,
    /// Names of the inputs, in the order of the arrays.
    pub inputs: Vec<String>,
    /// Names of the parameters, in the order of the columns of `da_dp`.
    pub parameters: Vec<String>,
    /// The states with what was computed there.
    pub cases: Vec<Case>,
}

/// One state: its inputs and what CasADi found.
#[derive(Debug, Clone)]
pub struct Case {
    value: Value,
    place: String,
}

impl Reference {
    /// Reads the file of `model`.
    ///
    /// # Panics
    /// If it is missing or not as `casadi/derive.py` writes it.
    pub fn read(model: &str) -> Self {
        let path = root().join(format!("tests/casadi/expected/{model}.json"));
        let text =
            std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let value: Value =
            serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let names = |key: &str| -> Vec<String> {
            let list = value[key].as_array();
            let list = list.unwrap_or_else(|| panic!("{}: no {key}", path.display()));
            let text = |name: &Value| name.as_str().expect("names are text").to_string();
            list.iter().map(text).collect()
        };
        let cases = value["cases"].as_array().expect("a list of cases");
        Self {
            model: model.to_string(),
            coordinates: names("coordinates"),
            inputs: names("inputs"),
            parameters: names("parameters"),
            cases: cases
                .iter()
                .enumerate()
                .map(|(index, value)| Case {
                    value: value.clone(),
                    place: format!("{model}, state {index}"),
                })
                .collect(),
        }
    }
}

impl Case {
    /// Which model and state, for messages.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// The time, s.
    pub fn time(&self) -> f64 {
        self.entries("t")[0].expect("time is a number")
    }

    /// The value of a parameter.
    pub fn parameter(&self, name: &str) -> f64 {
        let value = self.value["parameters"][name].as_f64();
        value.unwrap_or_else(|| panic!("{}: no parameter {name}", self.place))
    }

    /// A vector, or a matrix row by row.
    pub fn numbers(&self, key: &str) -> Vec<f64> {
        let number = |x: Option<f64>| x.unwrap_or_else(|| panic!("{}: null in {key}", self.place));
        self.entries(key).into_iter().map(number).collect()
    }

    /// As [`numbers`](Self::numbers); `None` where the quantity is not defined.
    pub fn entries(&self, key: &str) -> Vec<Option<f64>> {
        let value = self.value.get(key);
        let value = value.unwrap_or_else(|| panic!("{}: no {key}", self.place));
        let mut entries = Vec::new();
        flatten(value, &mut entries);
        entries
    }
}

fn flatten(value: &Value, entries: &mut Vec<Option<f64>>) {
    match value {
        Value::Array(list) => list.iter().for_each(|value| flatten(value, entries)),
        Value::Null => entries.push(None),
        value => entries.push(Some(value.as_f64().expect("a number"))),
    }
}

/// The largest differences met so far, by quantity.
#[derive(Debug, Default)]
pub struct Deviations(Vec<(String, f64)>);

impl Deviations {
    /// Asserts that no entry is further off than `tolerance` times the largest entry of
    /// `expected` , and remembers the largest ratio.
    ///
    /// # Panics
    /// If one is, if the lengths differ, or if anything is not finite.
    pub fn check(
        &mut self,
        (place, name): (&str, &str),
        found: &[f64],
        expected: &[f64],
        tolerance: f64,
    ) {
        assert_eq!(found.len(), expected.len(), "{place}: size of {name}");
        let finite = found.iter().chain(expected).all(|x| x.is_finite());
        assert!(finite, "{place}: {name}\n{found:?}\n{expected:?}");
        let size = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let pairs = found.iter().zip(expected);
        let off = pairs.fold(0.0, |m: f64, (x, y)| m.max((x - y).abs()));
        let ratio = off / size.max(1e-300);
        assert!(
            ratio <= tolerance,
            "{place}: {name} is {ratio:.2e} off\n{found:?}\n{expected:?}"
        );
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, worst)) => *worst = worst.max(ratio),
            None => self.0.push((name.to_string(), ratio)),
        }
    }

    /// Every quantity with its largest deviation.
    pub fn summary(&self) -> String {
        let entries: Vec<String> = self.0.iter().map(|(n, d)| format!("{n} {d:.1e}")).collect();
        entries.join(", ")
    }
}
