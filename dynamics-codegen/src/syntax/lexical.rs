//! What must hold before the text is cut into tokens.
//!
//! The tokeniser reports neither the place of a stray character nor of an
//! unbalanced bracket, and deep nesting would cost it the stack. Both are found
//! here, in one loop over the characters.

use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, Span};

/// Brackets, and powers and signs in front of a number, may nest this deep.
pub(super) const MAX_DEPTH: usize = 64;
/// A model file may have this many bytes: it is a page, not a data set.
pub const MAX_BYTES: usize = 4 << 20;
/// Past this many findings the file is not what it claims to be.
const MAX_FINDINGS: usize = 10;

/// Faults that keep the text from being read at all.
pub(super) fn check(text: &str, source: SourceId) -> Vec<Diagnostic> {
    let span = |start: usize, end: usize| Span { source, start, end };
    if text.len() > MAX_BYTES {
        let message = format!("the file is larger than a model may be ({MAX_BYTES} bytes)");
        let help = "a model is a page of text: is this the right file?";
        return vec![Diagnostic::error(span(0, 0), message).help(help)];
    }
    let mut scan = Scan {
        text,
        source,
        at: 0,
        open: Vec::new(),
        found: Vec::new(),
    };
    while scan.at < text.len() && scan.found.len() < MAX_FINDINGS {
        scan.step();
    }
    for &(bracket, at) in scan.open.iter().take(MAX_FINDINGS) {
        scan.found.push(
            Diagnostic::error(span(at, at + 1), format!("`{bracket}` is never closed"))
                .help(format!("add the matching `{}`", closing(bracket))),
        );
    }
    scan.found
}

fn closing(open: char) -> char {
    match open {
        '(' => ')',
        '[' => ']',
        _ => '}',
    }
}

struct Scan<'a> {
    text: &'a str,
    source: SourceId,
    at: usize,
    open: Vec<(char, usize)>,
    found: Vec<Diagnostic>,
}

impl Scan<'_> {
    fn step(&mut self) {
        let rest = &self.text[self.at..];
        let Some(c) = rest.chars().next() else { return };
        if rest.starts_with("//") {
            self.at += rest.find('\n').unwrap_or(rest.len());
            return;
        }
        if rest.starts_with("/*") {
            return self.block_comment();
        }
        match c {
            '"' => return self.string(),
            '(' | '[' | '{' => self.open(c),
            ')' | ']' | '}' => self.close(c),
            _ if c.is_alphanumeric() || c.is_whitespace() || c == '_' => {}
            '+' | '-' | '*' | '/' | '^' | '=' | ';' | ':' | ',' | '.' | '<' | '>' => {}
            _ => self.error(c, format!("`{}` has no meaning here", c.escape_debug())),
        }
        self.at += c.len_utf8();
    }

    fn error(&mut self, c: char, message: String) {
        let (start, end) = (self.at, self.at + c.len_utf8());
        self.found.push(Diagnostic::error(
            Span {
                source: self.source,
                start,
                end,
            },
            message,
        ));
    }

    fn open(&mut self, c: char) {
        if self.open.len() == MAX_DEPTH {
            self.error(c, format!("brackets nest more than {MAX_DEPTH} deep"));
            if let Some(last) = self.found.pop() {
                self.found
                    .push(last.help("give the inner terms names with `let`"));
            }
            // What follows would only repeat the message.
            self.open.clear();
            self.at = self.text.len() - c.len_utf8();
            return;
        }
        self.open.push((c, self.at));
    }

    fn close(&mut self, c: char) {
        match self.open.pop() {
            Some((open, _)) if closing(open) == c => {}
            Some((open, at)) => {
                let span = Span {
                    source: self.source,
                    start: at,
                    end: at + 1,
                };
                self.error(c, format!("`{c}` does not close `{open}`"));
                if let Some(last) = self.found.pop() {
                    self.found.push(last.also(span, "opened here"));
                }
            }
            None => self.error(c, format!("`{c}` closes nothing")),
        }
    }

    fn block_comment(&mut self) {
        let (start, mut depth) = (self.at, 0_usize);
        while self.at < self.text.len() {
            let rest = &self.text[self.at..];
            let step = match () {
                () if rest.starts_with("/*") => {
                    depth += 1;
                    2
                }
                () if rest.starts_with("*/") => {
                    depth -= 1;
                    2
                }
                () => rest.chars().next().map_or(1, char::len_utf8),
            };
            self.at += step;
            if depth == 0 {
                return;
            }
        }
        let span = Span {
            source: self.source,
            start,
            end: start + 2,
        };
        self.found
            .push(Diagnostic::error(span, "this comment is never closed").help("add `*/`"));
    }

    fn string(&mut self) {
        let start = self.at;
        let mut escaped = false;
        for (offset, c) in self.text[start..].char_indices().skip(1) {
            match c {
                '"' if !escaped => {
                    self.at = start + offset + 1;
                    return;
                }
                '\n' => break,
                _ => escaped = c == '\\' && !escaped,
            }
        }
        let span = Span {
            source: self.source,
            start,
            end: start + 1,
        };
        self.found
            .push(Diagnostic::error(span, "this text is never closed").help("add `\"`"));
        self.at = start
            + self.text[start..]
                .find('\n')
                .unwrap_or(self.text.len() - start);
    }
}
