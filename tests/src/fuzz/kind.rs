//! What is damaged.

use std::fmt;
use std::str::FromStr;

/// A kind of file that a user writes or records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// A model, `*.model`.
    Model,
    /// A robot description, URDF.
    Urdf,
    /// An effect template, applied to a model.
    Effect,
    /// A log: CSV, plain or gzipped, or a recording of messages.
    Log,
    /// A map of a log's columns, TOML.
    Map,
    /// States, JSON lines, as `--states` and `--init` read them.
    State,
    /// Inputs over time, CSV, as `--inputs` reads them.
    Inputs,
    /// A controller, TOML, as `--control` reads it.
    Control,
    /// A robot description, MJCF.
    Mjcf,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Model,
        Self::Urdf,
        Self::Effect,
        Self::Log,
        Self::Map,
        Self::State,
        Self::Inputs,
        Self::Control,
        Self::Mjcf,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Urdf => "urdf",
            Self::Effect => "effect",
            Self::Log => "log",
            Self::Map => "map",
            Self::State => "state",
            Self::Inputs => "inputs",
            Self::Control => "control",
            Self::Mjcf => "mjcf",
        }
    }

    /// How many of a thousand inputs are of this kind: many where the language is large,
    /// few where one input takes long (robots are derived, effects compiled with a model).
    pub fn per_mille(self) -> u64 {
        match self {
            Self::Model => 200,
            Self::Urdf => 60,
            Self::Effect => 120,
            Self::Log => 100,
            Self::Map => 160,
            Self::State => 150,
            Self::Inputs => 100,
            Self::Control => 60,
            Self::Mjcf => 50,
        }
    }

    /// Whether its files are tables of rows and columns.
    pub(super) fn is_table(self) -> bool {
        matches!(self, Self::Log | Self::Inputs)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Kind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = Self::ALL.map(Self::name).join(", ");
        let mut all = Self::ALL.into_iter();
        all.find(|kind| kind.name() == text)
            .ok_or_else(|| format!("there is no kind `{text}`; there are {names}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_inputs_are_shared_out() {
        assert_eq!(Kind::ALL.map(Kind::per_mille).iter().sum::<u64>(), 1000);
        for kind in Kind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        assert!("xacro".parse::<Kind>().is_err());
    }
}
