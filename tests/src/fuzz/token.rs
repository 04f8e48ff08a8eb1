//! Texts of any kind as words, numbers, spaces and signs.

use std::borrow::Cow;

/// What a token is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// A name or a keyword.
    Word,
    /// Digits with a point and an exponent, without a sign.
    Number,
    /// Spaces and tabs, or one line end.
    Space,
    /// One character of anything else.
    Sign,
}

/// A piece of a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Token<'a> {
    /// What it is.
    pub class: Class,
    /// How it is written.
    pub text: Cow<'a, str>,
}

impl Token<'_> {
    /// Whether it ends a line.
    pub fn is_line_end(&self) -> bool {
        self.text == "\n"
    }
}

/// Cuts a text up; the tokens in a row are the text.
pub fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let (class, length) = match first {
            c if c.is_alphabetic() || c == '_' => {
                (Class::Word, run(rest, |c| c.is_alphanumeric() || c == '_'))
            }
            c if c.is_ascii_digit() => (Class::Number, number(rest)),
            '\n' => (Class::Space, 1),
            ' ' | '\t' | '\r' => (Class::Space, run(rest, |c| matches!(c, ' ' | '\t' | '\r'))),
            c => (Class::Sign, c.len_utf8()),
        };
        let (token, behind) = rest.split_at(length);
        tokens.push(Token {
            class,
            text: Cow::Borrowed(token),
        });
        rest = behind;
    }
    tokens
}

/// The bytes of the characters in front that are `wanted`.
fn run(text: &str, wanted: impl Fn(char) -> bool) -> usize {
    text.find(|c| !wanted(c)).unwrap_or(text.len())
}

/// The bytes of the number in front: `12`, `1.5`, `2e-3`, but of `0..1` the `0`.
fn number(text: &str) -> usize {
    let digits = |from: usize| from + run(&text[from..], |c| c.is_ascii_digit());
    let mut end = digits(0);
    if text[end..].starts_with('.') && digits(end + 1) > end + 1 {
        end = digits(end + 1);
    }
    let exponent = text[end..].strip_prefix(['e', 'E']).map(|behind| {
        let sign = usize::from(behind.starts_with(['-', '+']));
        end + 1 + sign
    });
    match exponent {
        Some(from) if digits(from) > from => digits(from),
        _ => end,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_its_tokens() {
        let text = "let é_1 = -2.5e-3*x^2 in 0..1;\r\n\t/// 1e\n";
        let found = tokens(text);
        let joined: String = found.iter().map(|token| token.text.as_ref()).collect();
        assert_eq!(joined, text);
        let of = |class: Class| -> Vec<&str> {
            let tokens = found.iter().filter(|token| token.class == class);
            tokens.map(|token| token.text.as_ref()).collect()
        };
        assert_eq!(of(Class::Number), ["2.5e-3", "2", "0", "1", "1"]);
        assert_eq!(of(Class::Word), ["let", "é_1", "x", "in", "e"]);
        assert_eq!(found.iter().filter(|token| token.is_line_end()).count(), 2);
    }
}
