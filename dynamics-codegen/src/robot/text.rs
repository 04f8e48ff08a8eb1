//! Pieces of the user's text in messages.

use crate::diagnostic::nearest;

/// The longest piece that is shown, in characters.
const LONGEST: usize = 60;

/// A piece of the user's text, fit to stand in a message: short, and without
/// control characters.
pub(crate) fn shown(text: &str) -> String {
    let clean = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let mut result: String = text.chars().take(LONGEST).map(clean).collect();
    if text.chars().nth(LONGEST).is_some() {
        result.push('…');
    }
    result
}

/// The known name that was probably meant. Very long names are not compared:
/// the time grows with the square of their length.
pub(crate) fn suggest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.is_empty() || name.len() > LONGEST {
        return None;
    }
    nearest(
        name,
        known
            .into_iter()
            .filter(|candidate| candidate.len() <= LONGEST),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shown_text_is_short_and_harmless() {
        assert_eq!(shown("arm"), "arm");
        assert_eq!(shown("a\u{1b}[31m\nb"), "a\u{fffd}[31m\u{fffd}b");
        assert_eq!(shown(&"x".repeat(1000)).chars().count(), LONGEST + 1);
    }

    #[test]
    fn long_names_are_not_compared() {
        let long = "x".repeat(1 << 20);
        assert_eq!(suggest(&long, ["x"]), None);
        assert_eq!(suggest("arn", [long.as_str(), "arm"]), Some("arm"));
    }
}
