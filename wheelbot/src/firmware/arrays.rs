//! The arrays that a routine reads and writes, from named numbers.

use super::recorded::Recorded;
use dynamics_codegen::emit::{Array, Entry};
use dynamics_codegen::graph::{ExprId, SymbolId};

/// A number's name and its unit.
pub(super) type Named = (String, &'static str);

/// The arguments that were taken so far.
#[derive(Default)]
pub(super) struct Arguments {
    pub arrays: Vec<Array<SymbolId>>,
}

impl Arguments {
    /// One more array, row by row.
    pub fn take<const K: usize, const N: usize>(
        &mut self,
        name: &str,
        meaning: &str,
        rows: [[Named; K]; N],
    ) -> [[Recorded; K]; N] {
        let mut entries = Vec::new();
        let numbers = rows.map(|row| {
            row.map(|named| {
                let (symbol, number) = Recorded::argument(&named.0);
                entries.push((entry(named), symbol));
                number
            })
        });
        self.arrays.push(array(name, meaning, entries));
        numbers
    }

    /// One more array of a single row.
    pub fn take_row<const K: usize>(
        &mut self,
        name: &str,
        meaning: &str,
        row: [Named; K],
    ) -> [Recorded; K] {
        let [row] = self.take(name, meaning, [row]);
        row
    }
}

/// An array of results.
pub(super) fn results<const K: usize>(
    name: &str,
    meaning: &str,
    named: [Named; K],
    numbers: [Recorded; K],
) -> Array<ExprId> {
    let expressions = numbers.map(Recorded::expression);
    let entries = named.into_iter().map(entry).zip(expressions).collect();
    array(name, meaning, entries)
}

fn array<E>(name: &str, meaning: &str, entries: Vec<(Entry, E)>) -> Array<E> {
    Array {
        name: name.to_string(),
        meaning: meaning.to_string(),
        entries,
    }
}

fn entry((name, unit): Named) -> Entry {
    Entry {
        name,
        unit: unit.to_string(),
    }
}
