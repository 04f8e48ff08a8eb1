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
pub(super) const MAX_BYTES: usize = 4 << 20;
/// Bytes of a name or of a number at most. Names stand in every line of generated code, the model's
/// in front of every one of C's, and what is called after a name of a robot description may be
/// longer than that. An integer is read in time with the square of its digits.
pub(crate) const LONGEST_WORD: usize = 512;
const EMPTY: &str =
    "a model begins with `model name;`, an effect template with `effect name(joint);`";
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
    if text.trim().is_empty() {
        return vec![Diagnostic::error(span(0, 0), "the file is empty").help(EMPTY)];
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

/// What a character was probably meant to be.
fn hint(c: char) -> Option<&'static str> {
    Some(match c {
        '²' | '³' | '¹' => "a power is written `x^2`",
        '·' | '×' | '⋅' => "a product is written `a*b`",
        '÷' => "a quotient is written `a/b`",
        '−' | '–' | '—' => "a minus sign is written `-`",
        '|' => "an absolute value is written `abs(x)`",
        '%' => "there is no remainder; a percentage is a number such as `0.05`",
        '#' => "a comment begins with `//`",
        '\'' => "a rate is written `dot(x)`",
        '°' => "angles are in radians: `30*pi/180`",
        '≤' | '≥' => "bounds are written `in 0..1`",
        '\0' => "this does not look like a text file",
        '“' | '”' | '„' => "a text stands between plain quotes `\"`",
        _ => return None,
    })
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
            return self.line_comment();
        }
        if rest.starts_with("/*") {
            return self.block_comment();
        }
        match c {
            '"' => return self.string(),
            '(' | '[' | '{' => self.open(c),
            ')' | ']' | '}' => self.close(c),
            '+' | '-' | '*' | '/' | '^' | '=' | ';' | ':' | ',' | '.' | '<' | '>' => {}
            _ if c.is_whitespace() => {}
            _ if c.is_alphanumeric() || c == '_' => return self.word(),
            _ => {
                self.meaningless(c);
                // A row of them is one mistake.
                while self.text[self.at..].starts_with([c, ' ']) {
                    self.at += self.text[self.at..]
                        .chars()
                        .next()
                        .map_or(1, char::len_utf8);
                }
                return;
            }
        }
        self.at += c.len_utf8();
    }

    /// A name or a number: whatever the tokeniser takes for one.
    fn word(&mut self) {
        let rest = &self.text[self.at..];
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let end = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
        if end > LONGEST_WORD {
            let message = format!("a name or a number has at most {LONGEST_WORD} bytes");
            self.fault(end, message);
            self.at += end;
            return;
        }
        let word = &rest[..end];
        let plain = word.bytes().all(|b| b.is_ascii_digit())
            || (word.is_ascii() && !word.starts_with(|c: char| c.is_ascii_digit()));
        if !plain && word.parse::<proc_macro2::TokenStream>().is_err() {
            match word.chars().find(|&c| hint(c).is_some()) {
                Some(odd) => {
                    self.at += word.find(odd).unwrap_or(0);
                    self.meaningless(odd);
                    self.at += odd.len_utf8();
                    return;
                }
                None => self.fault(
                    word.len(),
                    format!("`{word}` is neither a name nor a number"),
                ),
            }
        }
        self.at += end;
    }

    fn meaningless(&mut self, c: char) {
        let shown = if c.is_control() {
            c.escape_default().to_string()
        } else {
            c.to_string()
        };
        self.error(c, format!("`{shown}` has no meaning here"));
        if let Some(hint) = hint(c) {
            self.mend(hint);
        }
    }

    /// Says how to mend the last error.
    fn mend(&mut self, help: &str) {
        if let Some(last) = self.found.pop() {
            self.found.push(last.help(help));
        }
    }

    fn error(&mut self, c: char, message: String) {
        self.fault(c.len_utf8(), message);
    }

    /// An error at the next `length` bytes.
    fn fault(&mut self, length: usize, message: String) {
        let span = Span {
            source: self.source,
            start: self.at,
            end: self.at + length,
        };
        self.found.push(Diagnostic::error(span, message));
    }

    fn open(&mut self, c: char) {
        if self.open.len() == MAX_DEPTH {
            self.error(c, format!("brackets nest more than {MAX_DEPTH} deep"));
            self.mend("give the inner terms names with `let`");
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
            None => {
                self.error(c, format!("`{c}` closes nothing"));
                self.mend("remove it, or open a bracket before it");
            }
        }
    }

    fn line_comment(&mut self) {
        let rest = &self.text[self.at..];
        let line = &rest[..rest.find('\n').unwrap_or(rest.len())];
        let end = self.at + line.len();
        // In a doc comment the tokeniser takes a lone carriage return amiss.
        let body = line.strip_suffix('\r').unwrap_or(line);
        if let Some(offset) = body.find('\r') {
            self.at += offset;
            self.error('\r', "a carriage return without a line feed".to_string());
            self.mend("save the file with plain line ends");
        }
        self.at = end;
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
        for (offset, c) in self.text[start..].char_indices().skip(1) {
            self.at = start + offset;
            match c {
                '"' => {
                    self.at += 1;
                    return;
                }
                '\\' => {
                    self.error(c, "a text has no `\\`".to_string());
                    self.mend("paths are written with `/`");
                }
                '\n' | '\r' => break,
                _ => {}
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
