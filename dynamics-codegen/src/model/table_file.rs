//! Tables in files of numbers, separated by commas, semicolons or tabs.
//!
//! Of one argument: two numbers a line, the argument and the value. Of two: the first line has
//! the values of the second argument behind a cell that is not looked at, every other line a
//! value of the first argument and the values there. Empty lines and what follows `#` are passed
//! over; of one argument, the first line may be a heading.

use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, Span};

/// A number with its place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub value: f64,
    pub span: Span,
}

/// The numbers of a table before they are looked at.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// Of a table of two arguments, the values of the second.
    pub heading: Option<Vec<Cell>>,
    /// Per row the value of the first argument, and the values there.
    pub rows: Vec<(Cell, Vec<Cell>)>,
}

/// The numbers in the text of a file for a table of one argument or two.
pub(super) fn read(
    text: &str,
    source: SourceId,
    arguments: usize,
) -> Result<Rows, Box<Diagnostic>> {
    let mut lines = lines(text);
    let mut heading = None;
    if arguments == 2 {
        let first = lines.next().unwrap_or_default();
        let points = first.iter().skip(1).map(|word| number(word, source));
        heading = Some(points.collect::<Result<Vec<Cell>, Box<Diagnostic>>>()?);
    }
    let mut rows = Vec::new();
    for (position, line) in lines.enumerate() {
        let is_number = |(_, word): &(usize, &str)| word.parse::<f64>().is_ok();
        if arguments == 1 && position == 0 && !line.iter().any(is_number) {
            continue;
        }
        let cells = line.iter().map(|word| number(word, source));
        let cells = cells.collect::<Result<Vec<Cell>, Box<Diagnostic>>>()?;
        if let [first, values @ ..] = &cells[..] {
            rows.push((*first, values.to_vec()));
        }
    }
    Ok(Rows { heading, rows })
}

/// The words of every line that has some, with where they begin.
fn lines(text: &str) -> impl Iterator<Item = Vec<(usize, &str)>> {
    let mut start = 0;
    let lines = text.split_inclusive('\n').map(move |line| {
        let begin = start;
        start += line.len();
        let line = line.split('#').next().unwrap_or(line);
        // Some programs put a byte-order mark in front.
        let bare = line.strip_prefix('\u{feff}').unwrap_or(line);
        (begin + line.len() - bare.len(), bare.trim_end())
    });
    lines
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(begin, line)| {
            let mut at = begin;
            let words = line.split([',', ';', '\t']).map(|word| {
                let from = at + word.len() - word.trim_start().len();
                at += word.len() + 1;
                (from, word.trim())
            });
            words.collect()
        })
}

fn number((start, word): &(usize, &str), source: SourceId) -> Result<Cell, Box<Diagnostic>> {
    let span = Span {
        source,
        start: *start,
        end: start + word.len().max(1),
    };
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Cell { value, span }),
        _ => Err(Box::new(
            Diagnostic::error(span, format!("expected a number, found `{word}`"))
                .help("numbers have a decimal point, and `,`, `;` or a tab between them"),
        )),
    }
}
