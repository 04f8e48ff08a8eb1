//! The map as TOML writes it.

use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    #[serde(default)]
    pub time: Time,
    #[serde(default)]
    pub columns: BTreeMap<Spanned<String>, Column>,
    #[serde(default)]
    pub transmission: Vec<Spanned<Transmission>>,
}

/// `[time]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Time {
    #[serde(default = "t")]
    pub column: String,
    pub unit: Option<Spanned<String>>,
    pub start: Option<Spanned<f64>>,
}

impl Default for Time {
    fn default() -> Self {
        Self {
            column: t(),
            unit: None,
            start: None,
        }
    }
}

fn t() -> String {
    "t".to_owned()
}

/// `q_arm = { … }` under `[columns]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Column {
    pub column: Option<String>,
    pub terms: Option<Vec<Term>>,
    pub unit: Option<Spanned<String>>,
    pub sign: Option<Spanned<f64>>,
    pub factor: Option<Spanned<f64>>,
    pub offset: Option<Spanned<f64>>,
    pub wraps: Option<Spanned<f64>>,
    pub fill: Option<Fill>,
}

/// One of several columns that add up.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Term {
    pub column: String,
    pub factor: Spanned<f64>,
    pub unit: Option<Spanned<String>>,
    pub wraps: Option<Spanned<f64>>,
}

/// What stands in cells without a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Fill {
    /// The value before.
    Hold,
    /// A straight line between the measurements on both sides.
    Linear,
}

/// `[[transmission]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Transmission {
    pub coordinates: Vec<String>,
    pub inputs: Option<Vec<String>>,
    pub ratio: Vec<Vec<f64>>,
    pub position: Option<Vec<String>>,
    pub velocity: Option<Vec<String>>,
    pub acceleration: Option<Vec<String>>,
    pub torque: Option<Vec<String>>,
    pub position_unit: Option<Spanned<String>>,
    pub velocity_unit: Option<Spanned<String>>,
    pub acceleration_unit: Option<Spanned<String>>,
    pub torque_unit: Option<Spanned<String>>,
    pub offset: Option<Vec<f64>>,
    pub wraps: Option<Spanned<f64>>,
}
