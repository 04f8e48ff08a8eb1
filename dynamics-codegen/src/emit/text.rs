//! Text of a model inside comments: shown as it is where that is safe.

/// The lines of a text, trimmed, with characters that could end a comment, change
/// the direction of reading or fool the eye written as `\u{…}`.
pub(super) fn plain_lines(text: &str) -> Vec<String> {
    let lines = text.split(['\n', '\r', '\u{85}', '\u{2028}', '\u{2029}']);
    let mut lines: Vec<String> = lines.map(|line| visible(line.trim())).collect();
    while lines.last().is_some_and(String::is_empty) {
        lines.pop();
    }
    let leading = lines.iter().take_while(|line| line.is_empty()).count();
    lines.split_off(leading)
}

/// One line; line breaks become spaces.
pub(super) fn one_line(text: &str) -> String {
    plain_lines(text).join(" ")
}

/// As [`plain_lines`], for rustdoc: no link, no HTML, and no code block, which
/// `cargo test` would run.
pub(super) fn markdown_lines(text: &str) -> Vec<String> {
    plain_lines(text).iter().map(|line| escape(line)).collect()
}

/// A number as people write it, exact.
pub(super) fn decimal(value: f64) -> String {
    if value.abs() < 1e15 && value.fract() == 0.0 {
        format!("{value}")
    } else {
        format!("{value:?}")
    }
}

/// As [`plain_lines`], for a block comment in C: nothing in it opens or ends one, and
/// no two question marks meet (trigraphs).
pub(super) fn c_comment_lines(text: &str) -> Vec<String> {
    let mut lines = plain_lines(text);
    for line in &mut lines {
        for (pair, apart) in [("*/", "* /"), ("/*", "/ *"), ("??", "? ?"), ("??", "? ?")] {
            *line = line.replace(pair, apart);
        }
    }
    lines
}

fn visible(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    for c in line.chars() {
        let hidden = c.is_control()
            || matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
        if c == '\t' {
            out.push(' ');
        } else if hidden {
            out.push_str(&c.escape_unicode().to_string());
        } else {
            out.push(c);
        }
    }
    out
}

/// Backticks stay where they pair up within the line; outside of them, what begins
/// a link, a tag or a fence is escaped.
fn escape(line: &str) -> String {
    let fence = line.starts_with("```") || line.starts_with("~~~");
    let paired = !fence && line.matches('`').count().is_multiple_of(2) && !line.contains("``");
    let mut out = String::with_capacity(line.len());
    let mut in_code = false;
    for (index, c) in line.chars().enumerate() {
        let special = match c {
            '`' if paired => {
                in_code = !in_code;
                false
            }
            '`' | '[' | ']' | '<' | '>' | '\\' => !in_code,
            '~' | '#' => index == 0,
            _ => false,
        };
        if special {
            out.push('\\');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_ends_the_line_or_turns_it_around() {
        assert_eq!(
            plain_lines("a\r\nb\u{2028}c\0\u{202e}"),
            ["a", "", "b", "c\\u{0}\\u{202e}"]
        );
        assert_eq!(one_line("\n a\nb \n"), "a b");
    }

    #[test]
    fn no_block_comment_ends_early() {
        for text in ["*/", "/*/", "**//", "*\u{0}/", "???/", "*\\\n/"] {
            for line in c_comment_lines(text) {
                let bad = ["*/", "/*", "??"].iter().any(|pair| line.contains(pair));
                assert!(!bad, "{text:?} gives {line:?}");
            }
        }
    }

    #[test]
    fn no_code_block_no_link_no_tag() {
        assert_eq!(
            markdown_lines("```\nlet `x` = [y](z) <b>;\n~~~\n    indented"),
            [
                "\\`\\`\\`",
                "let `x` = \\[y\\](z) \\<b\\>;",
                "\\~~~",
                "indented"
            ]
        );
        assert_eq!(markdown_lines("keeps `a[1] < b`"), ["keeps `a[1] < b`"]);
    }
}
