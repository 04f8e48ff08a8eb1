//! Names of a model as identifiers of generated code.
//!
//! [`identifier`] is injective: two names that differ become two identifiers that
//! differ, and no name becomes anything but an identifier.
//!
//! | in the name | in the identifier |
//! |---|---|
//! | ASCII letter, digit | itself |
//! | `_`, not in front of `_` or of a character of the next line | itself |
//! | any other character; a digit in front | `__` its code point in hexadecimal `_` |
//! | the whole is a reserved word of Rust, C or C++, `_`, or empty | the name, then `__` |
//!
//! So `theta_1` stays, `θ` becomes `__3b8_`, `x; unsafe { }` becomes
//! `x__3b___20_unsafe__20___7b___20___7d_`, `type` becomes `type__`.
//!
//! Temporaries need not say exactly which name they come from: [`Locals`] turns a
//! wish into a free identifier in snake case.

use super::words::{greek, hides_a_function, is_c_macro, is_reserved};
use std::collections::BTreeSet;

/// The identifier of a name; see the table above.
///
/// ```
/// use dynamics_codegen::emit::identifier;
///
/// assert_eq!(identifier("I_G"), "I_G");
/// assert_eq!(identifier("self"), "self__");
/// assert_eq!(identifier("*/"), "__2a___2f_");
/// ```
pub fn identifier(name: &str) -> String {
    if name.is_empty() || is_reserved(name) {
        return format!("{name}__");
    }
    let mut out = String::with_capacity(name.len());
    let mut characters = name.chars().peekable();
    while let Some(c) = characters.next() {
        let follows_plainly = characters.peek().is_none_or(char::is_ascii_alphanumeric);
        let plain = match c {
            '_' => follows_plainly,
            '0'..='9' => !out.is_empty(),
            _ => c.is_ascii_alphabetic(),
        };
        if plain {
            out.push(c);
        } else {
            out.push_str(&escaped(c));
        }
    }
    out
}

/// The member of a C struct that holds the parameter of this name: its [`identifier`],
/// with `_` behind it if it holds a capital letter or is, up to the `_` behind it, a word
/// that C's headers define as a macro. A `_` in front, where compilers have names of their
/// own, is written as its code point.
///
/// So no macro of a standard header hits it, whichever are included: these hold a capital
/// letter, stand in a closed list or begin with `_`, and of the former none ends in `_`.
/// Two names that differ stay different: what gets a `_` behind it holds a capital letter,
/// or leads to a word of the list without the `_` behind it, before and after.
///
/// ```
/// use dynamics_codegen::emit::c_member;
///
/// assert_eq!(c_member("length"), "length");
/// assert_eq!(c_member("I"), "I_");
/// assert_eq!(c_member("stdin"), "stdin_");
/// assert_eq!(c_member("_x"), "__5f_x");
/// ```
pub fn c_member(name: &str) -> String {
    let mut member = identifier(name);
    if member.starts_with('_') && !member.starts_with("__") {
        member.replace_range(..1, &escaped('_'));
    }
    let capital = member.contains(|c: char| c.is_ascii_uppercase());
    if capital || is_c_macro(member.trim_end_matches('_')) {
        member.push('_');
    }
    member
}

/// A character by its code point.
fn escaped(c: char) -> String {
    format!("__{:x}_", u32::from(c))
}

/// Whether rustc finds an identifier fit for a variable, field or module.
pub(super) fn is_snake_case(identifier: &str) -> bool {
    let inner = identifier.trim_matches('_');
    !inner.contains("__") && !inner.chars().any(|c| c.is_ascii_uppercase())
}

/// A type's name: the words of `name`, each with a capital; `taken` gets `Model`
/// behind it.
pub(super) fn type_name(name: &str, taken: &[&str]) -> String {
    let identifier = identifier(name);
    let words = identifier.split('_').filter(|word| !word.is_empty());
    let mut out = String::new();
    for word in words {
        // Two digits that meet would read as one number.
        let digits_meet = out.ends_with(|c: char| c.is_ascii_digit())
            && word.starts_with(|c: char| c.is_ascii_digit());
        if digits_meet {
            out.push('X');
        }
        let mut letters = word.chars();
        out.extend(letters.next().map(|c| c.to_ascii_uppercase()));
        out.push_str(letters.as_str());
    }
    if out.is_empty() || out.starts_with(|c: char| c.is_ascii_digit()) {
        out.insert_str(0, "Model");
    }
    if taken.contains(&out.as_str()) || is_reserved(&out) {
        out.push_str("Model");
    }
    out
}

/// A wish for a temporary's name as lower-case words joined by `_`; may be empty.
pub(super) fn snake(wish: &str) -> String {
    let mut out = String::new();
    for c in wish.chars() {
        if c.is_ascii_alphanumeric() {
            out.push(c.to_ascii_lowercase());
        } else if let Some(word) = greek(c) {
            out.push_str(word);
        } else if !out.is_empty() && !out.ends_with('_') {
            out.push('_');
        }
    }
    while out.ends_with('_') {
        out.pop();
    }
    out
}

/// The names used in one function.
#[derive(Debug, Clone, Default)]
pub(super) struct Locals {
    taken: BTreeSet<String>,
    numbered: usize,
}

impl Locals {
    pub fn new<'a>(taken: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            taken: taken.into_iter().map(str::to_string).collect(),
            numbered: 0,
        }
    }

    /// A free name as close to `wish` as can be, of at most 32 characters.
    pub fn claim(&mut self, wish: &str) -> String {
        let mut base = snake(wish);
        base.truncate(28);
        let base = snake(&base);
        let unfit = base.is_empty() || base.starts_with(|c: char| c.is_ascii_digit());
        if unfit {
            return self.number();
        }
        let taken = is_reserved(&base) || is_c_macro(&base) || hides_a_function(&base);
        let base = if taken { format!("{base}_value") } else { base };
        let mut candidate = base.clone();
        let mut count = 1;
        while !self.taken.insert(candidate.clone()) {
            count += 1;
            candidate = format!("{base}_{count}");
        }
        candidate
    }

    /// A name that says nothing: `w1`, `w2`, …
    pub fn number(&mut self) -> String {
        loop {
            self.numbered += 1;
            let candidate = format!("w{}", self.numbered);
            if self.taken.insert(candidate.clone()) {
                return candidate;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The inverse of [`identifier`]: that there is one proves it injective.
    fn name_of(identifier: &str) -> Option<String> {
        if let Some(word) = identifier.strip_suffix("__")
            && (word.is_empty() || is_reserved(word))
        {
            return Some(word.to_string());
        }
        let mut out = String::new();
        let mut rest = identifier;
        while let Some(c) = rest.chars().next() {
            if let Some(escape) = rest.strip_prefix("__") {
                let (hex, behind) = escape.split_once('_')?;
                out.push(char::from_u32(u32::from_str_radix(hex, 16).ok()?)?);
                rest = behind;
            } else {
                out.push(c);
                rest = &rest[c.len_utf8()..];
            }
        }
        Some(out)
    }

    /// The inverse of [`c_member`].
    fn name_of_member(member: &str) -> Option<String> {
        let capital = member.contains(|c: char| c.is_ascii_uppercase());
        let changed = capital || is_c_macro(member.trim_end_matches('_'));
        name_of(if changed {
            member.strip_suffix('_')?
        } else {
            member
        })
    }

    fn is_identifier(text: &str) -> bool {
        syn::parse_str::<syn::Ident>(text).is_ok() && text.is_ascii()
    }

    fn check(name: &str) {
        let word = identifier(name);
        assert!(is_identifier(&word), "{name:?} -> {word:?}");
        assert!(!is_reserved(&word), "{name:?} -> {word:?}");
        assert_eq!(name_of(&word).as_deref(), Some(name), "{word:?}");
        let member = c_member(name);
        assert!(
            is_identifier(&member) && !is_reserved(&member),
            "{member:?}"
        );
        assert!(!is_c_macro(&member), "{name:?} -> {member:?}");
        assert_eq!(name_of_member(&member).as_deref(), Some(name), "{member:?}");
        assert!(is_identifier(&type_name(name, &[])), "{name:?}");
        assert!(is_identifier(&Locals::default().claim(name)), "{name:?}");
    }

    #[test]
    fn hostile_names() {
        let names = [
            "",
            "_",
            "__",
            "___",
            "a__b",
            "a_",
            "_a",
            "3dof",
            "type",
            "type_",
            "type__",
            "self",
            "Self",
            "crate",
            "gen",
            "x; unsafe { }",
            "*/",
            "../../etc/passwd",
            "θ",
            "_θ",
            "θ_θ",
            "\"",
            "a\nb",
            "r#type",
            "é\u{202e}",
            "__3b8_",
            "_u",
            "5f",
            "_5f_",
            "int",
            "\0",
            "I",
            "I_",
            "I__",
            "_I",
            "_SIZE_T",
            "EOF",
            "stdin",
            "stdin_",
            "stdin__",
            "errno",
            "complex",
        ];
        for name in names {
            check(name);
        }
        assert_eq!(
            identifier("x; unsafe { }"),
            "x__3b___20_unsafe__20___7b___20___7d_"
        );
    }

    proptest! {
        #[test]
        fn any_name_comes_back(name in ".{0,12}") {
            check(&name);
        }

        #[test]
        fn any_name_of_few_letters_comes_back(name in "[_a5θ/]{0,12}") {
            check(&name);
        }

        #[test]
        fn any_macro_with_its_like_comes_back(name in "_?(I|unix|true|EOF)[_I]{0,4}") {
            check(&name);
        }
    }

    #[test]
    fn temporaries_do_not_meet() {
        let mut locals = Locals::new(["p", "x"]);
        assert_eq!(locals.claim("I_G"), "i_g");
        assert_eq!(locals.claim("i_g"), "i_g_2");
        assert_eq!(locals.claim("x"), "x_2");
        assert_eq!(locals.claim("self"), "self_value");
        assert_eq!(locals.claim("θ_1"), "theta_1");
        assert_eq!(locals.claim("长"), "w1");
        assert_eq!(locals.claim("w2"), "w2");
        assert_eq!(locals.number(), "w3");
    }

    #[test]
    fn types_are_written_in_camel_case() {
        assert_eq!(type_name("surface_particle", &[]), "SurfaceParticle");
        assert_eq!(type_name("unicycle2d", &[]), "Unicycle2d");
        assert_eq!(type_name("parameters", &["Parameters"]), "ParametersModel");
    }
}
