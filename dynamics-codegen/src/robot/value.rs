//! Whether an attribute's text is what it must be.

use super::text::{shown, suggest};
use super::xml::Places;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use roxmltree::Attribute;

/// What an attribute's value must look like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Form {
    /// Any text but none.
    Name,
    /// Any text.
    Text,
    /// `major.minor`.
    Version,
    /// One of the words.
    Word(&'static [&'static str]),
    /// A number.
    Number(Range),
    /// So many finite numbers.
    Vector(usize),
    /// From so many to so many finite numbers.
    Between(usize, usize),
}

/// Which numbers are allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Range {
    /// Every finite number.
    Finite,
    /// Finite, and not negative.
    NotNegative,
    /// Every number, infinity included.
    Any,
    /// Not negative, infinity included.
    NotNegativeOrInfinite,
}

/// What is wrong with an attribute's value, if anything. `name` is how messages
/// call the attribute, `meaning` what it is and in which unit.
pub(crate) fn check(
    places: Places,
    attribute: &Attribute,
    form: Form,
    name: &str,
    meaning: &str,
) -> Option<Diagnostic> {
    let value = attribute.value();
    let at = places.value(attribute);
    match form {
        Form::Text => None,
        Form::Version => parse_version(value).is_none().then(|| {
            Diagnostic::error(at, format!("{name} is `{}`", shown(value)))
                .label(format!("expected {meaning}"))
        }),
        Form::Name if value.trim().is_empty() => Some(
            Diagnostic::error(at, format!("{name} is empty")).label(format!("expected {meaning}")),
        ),
        Form::Name => check_name(at, value, name),
        Form::Word(words) => check_word(at, value, words, name),
        Form::Number(range) => check_number(at, value, range, name, meaning),
        Form::Vector(count) => check_vector(places, attribute, [count; 2], name, meaning),
        Form::Between(least, most) => check_vector(places, attribute, [least, most], name, meaning),
    }
}

/// `major.minor`.
pub(crate) fn parse_version(text: &str) -> Option<(u32, u32)> {
    let (major, minor) = text.trim().split_once('.')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

/// Bytes of a name at most: names stand in every line of generated code.
const LONGEST_NAME: usize = 256;

/// Names become those of coordinates, columns of logs and lines of reports.
fn check_name(at: Span, value: &str, name: &str) -> Option<Diagnostic> {
    if value.len() > LONGEST_NAME {
        let message = format!("{name} has more than {LONGEST_NAME} bytes");
        return Some(Diagnostic::error(at, message).label("expected a shorter name"));
    }
    let control = value.chars().find(|c| c.is_control())?;
    let code = u32::from(control);
    let what = match control {
        '\n' | '\r' => "a line break".to_string(),
        '\t' => "a tabulator".to_string(),
        _ => format!("the control character U+{code:04X}"),
    };
    Some(
        Diagnostic::error(at, format!("{name} holds {what}"))
            .label("a name is one line of visible characters")
            .help(format!("leave out `&#{code};` wherever the name stands")),
    )
}

fn check_word(at: Span, value: &str, words: &[&str], name: &str) -> Option<Diagnostic> {
    if words.contains(&value) {
        return None;
    }
    let error = Diagnostic::error(at, format!("{name} is `{}`", shown(value)))
        .label(format!("expected one of {}", words.join(", ")));
    Some(match suggest(value.trim(), words.iter().copied()) {
        Some(word) => error.help(format!("did you mean `{word}`?")),
        None => error,
    })
}

fn check_number(
    at: Span,
    value: &str,
    range: Range,
    name: &str,
    meaning: &str,
) -> Option<Diagnostic> {
    let expected = format!("expected {meaning}");
    let Ok(number) = value.trim().parse::<f64>() else {
        return Some(not_a_number(at, value, name, &expected));
    };
    let infinite = matches!(range, Range::Any | Range::NotNegativeOrInfinite);
    let positive = matches!(range, Range::NotNegative | Range::NotNegativeOrInfinite);
    if number.is_nan() || (number.is_infinite() && !infinite) {
        return Some(
            Diagnostic::error(at, format!("{name} is not finite: {}", shown(value.trim())))
                .label(expected),
        );
    }
    if number.is_finite() && number.abs() > LARGEST {
        return Some(too_large(at, value.trim(), name, expected));
    }
    if positive && number < 0.0 {
        return Some(
            Diagnostic::error(at, format!("{name} is negative: {}", shown(value.trim())))
                .label(format!("{expected}, not below 0")),
        );
    }
    None
}

fn check_vector(
    places: Places,
    attribute: &Attribute,
    [least, most]: [usize; 2],
    name: &str,
    meaning: &str,
) -> Option<Diagnostic> {
    let value = attribute.value();
    let at = places.value(attribute);
    let count = match least == most {
        true => most.to_string(),
        false => format!("{least} to {most}"),
    };
    let expected = format!("expected {count} numbers separated by blanks: {meaning}");
    for word in value.split_whitespace() {
        let place = word_place(places, attribute, word);
        match word.parse::<f64>() {
            Err(_) => return Some(not_a_number(place, word, name, &expected)),
            Ok(x) if !x.is_finite() => {
                return Some(
                    Diagnostic::error(place, format!("{name} is not finite: {}", shown(word)))
                        .label(expected),
                );
            }
            Ok(x) if x.abs() > LARGEST => return Some(too_large(place, word, name, expected)),
            Ok(_) => {}
        }
    }
    let found = value.split_whitespace().count();
    (!(least..=most).contains(&found)).then(|| {
        let plural = if found == 1 { "" } else { "s" };
        Diagnostic::error(
            at,
            format!("{name} has {found} number{plural}, not {count}"),
        )
        .label(expected)
    })
}

/// The largest number of any use: beyond, products would overflow.
const LARGEST: f64 = 1e30;

fn too_large(at: Span, found: &str, name: &str, expected: String) -> Diagnostic {
    Diagnostic::error(at, format!("{name} is too large: {}", shown(found))).label(expected)
}

fn not_a_number(at: Span, found: &str, name: &str, expected: &str) -> Diagnostic {
    if found.trim().is_empty() {
        return Diagnostic::error(at, format!("{name} is empty")).label(expected);
    }
    let error = Diagnostic::error(
        at,
        format!("{name} is not a number: `{}`", shown(found.trim())),
    )
    .label(expected);
    if found.contains(',') {
        return error.help("write a decimal point, not a comma, and separate numbers by blanks");
    }
    error
}

/// The place of a word within a value; the whole value if it is written with
/// character references and the two cannot be matched.
fn word_place(places: Places, attribute: &Attribute, word: &str) -> Span {
    let whole = places.value(attribute);
    let value = attribute.value();
    let range = attribute.range_value();
    if range.len() != value.len() {
        return whole;
    }
    // `word` is a slice of `value`.
    let offset = word.as_ptr() as usize - value.as_ptr() as usize;
    places.span(range.start + offset..range.start + offset + word.len())
}
