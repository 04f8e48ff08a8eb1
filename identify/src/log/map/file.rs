//! The map as TOML writes it.

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;

/// The keys of the whole file.
pub(super) const KEYS: [&str; 5] = ["time", "files", "columns", "sensors", "transmission"];

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    #[serde(default)]
    pub time: Time,
    #[serde(default)]
    pub files: Files,
    #[serde(default)]
    pub columns: BTreeMap<Spanned<String>, Column>,
    #[serde(default)]
    pub sensors: BTreeMap<Spanned<String>, Column>,
    #[serde(default)]
    pub transmission: Vec<Spanned<Transmission>>,
}

/// `[time]`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Time {
    pub column: Option<Spanned<Source>>,
    pub unit: Option<Spanned<String>>,
    pub rate: Option<Spanned<f64>>,
    pub start: Option<Spanned<f64>>,
    pub topic: Option<String>,
}

/// `[files]`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Files {
    #[serde(default)]
    pub beside: Vec<Spanned<String>>,
}

/// A column of the log: its name, or its number, from 1 on, in a log without a header, where
/// columns are called by their numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Source(pub String);

impl<'de> Deserialize<'de> for Source {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrNumber;
        impl Visitor<'_> for NameOrNumber {
            type Value = Source;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a column's name, or its number from 1 on in a log without a header")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Source, E> {
                Ok(Source(name.to_owned()))
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Source, E> {
                match number {
                    1.. => Ok(Source(number.to_string())),
                    _ => Err(E::invalid_value(
                        serde::de::Unexpected::Signed(number),
                        &self,
                    )),
                }
            }
        }
        deserializer.deserialize_any(NameOrNumber)
    }
}

/// `q_arm = { … }` under `[columns]`, `gyro_z = { … }` under `[sensors]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Column {
    pub column: Option<Source>,
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
    pub column: Source,
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
    pub position: Option<Vec<Source>>,
    pub velocity: Option<Vec<Source>>,
    pub acceleration: Option<Vec<Source>>,
    pub torque: Option<Vec<Source>>,
    pub position_unit: Option<Spanned<String>>,
    pub velocity_unit: Option<Spanned<String>>,
    pub acceleration_unit: Option<Spanned<String>>,
    pub torque_unit: Option<Spanned<String>>,
    pub offset: Option<Vec<f64>>,
    pub wraps: Option<Spanned<f64>>,
}
