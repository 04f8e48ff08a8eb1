//! What all emitted text must be, whatever a model's names are.

/// Whether a character changes how text looks without being seen.
fn is_invisible(c: char) -> bool {
    c.is_control() && c != '\n' || ('\u{202a}'..='\u{202e}').contains(&c)
}

/// Asserts that nothing in a text is invisible.
///
/// # Panics
/// If something is.
pub fn check_visible(text: &str) {
    assert!(!text.contains(is_invisible), "{text}");
}

/// Asserts that a Rust module parses; returns its items.
///
/// # Panics
/// If it does not, or something in it is invisible.
pub fn check_rust(text: &str) -> syn::File {
    check_visible(text);
    syn::parse_str(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Asserts that a C file is plain ASCII outside of its comments, and that every comment ends.
///
/// # Panics
/// If it is not so.
pub fn check_c(text: &str) {
    let mut rest = text;
    while let Some((code, comment)) = rest.split_once("/*") {
        assert!(code.is_ascii() && !code.contains("*/"), "{code}");
        let (inside, behind) = comment.split_once("*/").expect("the comment ends");
        assert!(!inside.contains("/*"), "{inside}");
        rest = behind;
    }
    assert!(rest.is_ascii() && !rest.contains("*/"), "{rest}");
}
