//! How deep a text in TOML nests: its parser goes into inline tables as deep as they are, also
//! where none of them is ever closed.

/// Brackets nest at most this deep; a map needs four.
pub(super) const DEEPEST: usize = 32;

/// Where the first bracket too many of a text in TOML is opened, in bytes.
pub fn too_deep(text: &str) -> Option<usize> {
    // What closes each bracket that is open.
    let mut open: Vec<u8> = Vec::new();
    let mut at = 0;
    while let Some(rest) = text.get(at..).filter(|rest| !rest.is_empty()) {
        let step = match rest.as_bytes()[0] {
            b'"' | b'\'' => quoted(rest),
            b'#' => rest.find('\n').unwrap_or(rest.len()),
            b'{' | b'[' if open.len() == DEEPEST => return Some(at),
            b'{' => {
                open.push(b'}');
                1
            }
            b'[' => {
                open.push(b']');
                1
            }
            // One of another kind closes nothing: the parser is still inside.
            closing @ (b'}' | b']') => {
                open.pop_if(|last| *last == closing);
                1
            }
            _ => rest.chars().next().map_or(1, char::len_utf8),
        };
        at += step;
    }
    None
}

/// The bytes of a string from its first quote to its last, or to the end of the line where one
/// that must not go on there is not closed.
fn quoted(text: &str) -> usize {
    let quote = &text[..1];
    let long = quote.repeat(3);
    let (mark, ends_with_line) = match text.starts_with(&long) {
        true => (long.as_str(), false),
        false => (quote, true),
    };
    let mut at = mark.len();
    while let Some(next) = text[at..].chars().next() {
        if text[at..].starts_with(mark) {
            return at + mark.len();
        }
        at += match next {
            '\n' if ends_with_line => return at,
            // What is escaped closes nothing.
            '\\' if quote == "\"" => {
                let escaped = text[at + 1..].chars().next();
                1 + escaped.filter(|c| *c != '\n').map_or(0, char::len_utf8)
            }
            _ => next.len_utf8(),
        };
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_in_strings_and_comments_do_not_count() {
        let many = "[{".repeat(DEEPEST);
        for text in [
            format!("a = \"{many}\""),
            format!("a = '{many}'"),
            format!("a = \"\"\"\n\"{many}\n\"\"\""),
            format!("a = \"\\\"{many}\" # {many}\n"),
            format!("# ü {many}\n"),
            "[columns]\nq_ü = { column = \"ü\" }\n".repeat(100),
        ] {
            assert_eq!(too_deep(&text), None, "{text}");
        }
    }

    /// A table that nobody closes, again and again.
    #[test]
    fn what_is_never_closed_nests() {
        let text = "q_a = { column = \"a\"\n".repeat(20_000);
        let line = "q_a = { column = \"a\"\n".len();
        assert_eq!(too_deep(&text), Some(DEEPEST * line + 6));
        // One that is closed by another kind of bracket is not.
        let text = "q_a = { column = 1]\n".repeat(DEEPEST + 1);
        assert!(too_deep(&text).is_some());
        // Nor is one that is closed in a string.
        let text = "q_a = { column = \"}\n".repeat(DEEPEST + 1);
        assert!(too_deep(&text).is_some());
    }
}
