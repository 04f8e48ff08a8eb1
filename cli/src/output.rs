//! What is said: results on standard output, everything else on standard error.
//!
//! Names come out of files, and a terminal obeys what they may hold. Nothing goes to either
//! stream but through here, where control characters are shown instead of sent.

use crate::mistake::Mistake;
use dynamics_codegen::diagnostic::visible;
use std::io::{self, BufWriter, IsTerminal, StdoutLock, Write};

/// Whether messages may be coloured: on a terminal, unless `NO_COLOR` says otherwise.
fn colours_on_stderr() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Says something on standard error.
pub fn complain(text: &str) {
    say(&visible(text));
}

/// Says on standard error what stops the work, or what its compiler found in a model.
pub fn explain(mistake: &Mistake) {
    say(&mistake.render(colours_on_stderr()));
}

/// Says something on standard error that does not stop the work.
pub fn warn(mistake: &Mistake) {
    say(&mistake.render_as_warning(colours_on_stderr()));
}

fn say(text: &str) {
    // Nobody is left to hear that standard error is closed.
    writeln!(io::stderr(), "{text}").ok();
}

/// Standard output, buffered; a closed pipe comes back as an error, not a panic.
pub fn stdout() -> Visible<BufWriter<StdoutLock<'static>>> {
    Visible::new(BufWriter::new(io::stdout().lock()))
}

/// Text on its way to a terminal, with control characters shown.
#[derive(Debug)]
pub struct Visible<W> {
    inner: W,
    /// The beginning of a character whose end is still to come.
    begun: Vec<u8>,
}

impl<W: Write> Visible<W> {
    /// Text on its way to `inner`.
    pub fn new(inner: W) -> Self {
        let begun = Vec::new();
        Self { inner, begun }
    }
}

impl<W: Write> Write for Visible<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.begun.extend_from_slice(bytes);
        let (text, rest) = whole_characters(&self.begun);
        self.inner.write_all(visible(&text).as_bytes())?;
        self.begun = rest;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// The text in some bytes, and those at the end that are the beginning of a character.
fn whole_characters(bytes: &[u8]) -> (String, Vec<u8>) {
    let end = match std::str::from_utf8(bytes) {
        Err(error) if error.error_len().is_none() => error.valid_up_to(),
        _ => bytes.len(),
    };
    let (text, rest) = bytes.split_at(end);
    (String::from_utf8_lossy(text).into_owned(), rest.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_wherever_the_text_is_cut() {
        let text = "a\u{1b}[31mb\u{9b}2Jé\r\n\tc\u{202e}d\n";
        let expected = "a\\u001b[31mb\\u009b2Jé\r\n\tc\\u202ed\n";
        for piece in [1, 2, 3, 100] {
            let mut shown = Visible::new(Vec::new());
            for bytes in text.as_bytes().chunks(piece) {
                shown.write_all(bytes).unwrap();
            }
            let shown = String::from_utf8(shown.inner).unwrap();
            // An end of line that comes in two pieces is taken for a return of its own.
            assert_eq!(
                shown.replace("\\u000d", "\r"),
                expected,
                "in pieces of {piece}"
            );
        }
    }
}
