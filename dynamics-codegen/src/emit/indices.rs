//! Where things stand in arrays, by name: `Q_THETA` in Rust, `cartpole_q_theta` in C.

use super::axes::inputs;
use super::naming::identifier;
use crate::model::Model;
use std::collections::BTreeMap;

/// A name's place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Index {
    /// `q`, `u`, …, `_` and the name as an identifier.
    pub code: String,
    /// The name as the model writes it.
    pub name: String,
    pub place: usize,
}

/// What stands in one array.
#[derive(Debug, Clone)]
pub(super) struct Indices {
    /// `coordinate`, `input`, …
    pub what: &'static str,
    /// Which arrays these are.
    pub arrays: &'static str,
    pub entries: Vec<Index>,
}

/// The places of everything that has a name and no field of its own.
pub(super) fn indices(model: &Model) -> Vec<Indices> {
    let coordinates = model.coordinates.iter().map(|c| c.name.clone()).collect();
    let positions: Vec<String> = model.positions().into_iter().map(|p| p.name).collect();
    let inputs = inputs(model).into_iter().map(|entry| entry.name);
    let states = model.states.iter().map(|z| z.name.clone());
    let constraints = model.constraints.iter().map(|c| c.name.clone());
    let outputs = model.outputs.iter().map(|y| y.name.clone());
    let of = |what, arrays, prefix: &str, names: Vec<String>| Indices {
        what,
        arrays,
        entries: (names.into_iter().enumerate())
            .map(|(place, name)| Index {
                code: format!("{prefix}_{}", identifier(&name)),
                name,
                place,
            })
            .collect(),
    };
    let moving = if model.poses.is_empty() {
        vec![of(
            "coordinate",
            "`q`, `v` and their forces",
            "q",
            coordinates,
        )]
    } else {
        vec![
            of("position", "`q`", "q", positions),
            of("velocity", "`v` and their forces", "v", coordinates),
        ]
    };
    let rest = [
        of("input", "`u`", "u", inputs.collect()),
        of("internal state", "`z`", "z", states.collect()),
        of(
            "constraint row",
            "multipliers",
            "lambda",
            constraints.collect(),
        ),
        of("output", "the outputs", "y", outputs.collect()),
    ];
    moving.into_iter().chain(rest).collect()
}

impl Indices {
    /// The entries with names in capitals; those that differ in nothing but capitals have none.
    pub fn in_capitals(&self) -> Vec<Index> {
        let mut counts = BTreeMap::new();
        for entry in &self.entries {
            *counts.entry(entry.code.to_ascii_uppercase()).or_insert(0) += 1;
        }
        let capital = self.entries.iter().map(|entry| Index {
            code: entry.code.to_ascii_uppercase(),
            ..entry.clone()
        });
        capital.filter(|entry| counts[&entry.code] == 1).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_differ_in_capitals_have_no_constant() {
        let entries = ["a", "A", "b"].into_iter().enumerate();
        let entries = entries.map(|(place, name)| Index {
            code: format!("q_{name}"),
            name: name.to_string(),
            place,
        });
        let indices = Indices {
            what: "coordinate",
            arrays: "`q`",
            entries: entries.collect(),
        };
        let capitals = indices.in_capitals();
        assert_eq!(capitals.len(), 1);
        assert_eq!((capitals[0].code.as_str(), capitals[0].place), ("Q_B", 2));
    }
}
