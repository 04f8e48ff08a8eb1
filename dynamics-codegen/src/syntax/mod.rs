//! From text to a syntax tree that keeps its places.

mod ast;
mod body;
mod contact;
mod expression;
mod lexical;
mod part;
mod sensor;
mod statement;
mod stream;
mod table;

pub use ast::*;
pub(crate) use lexical::LONGEST_WORD;
pub(crate) use stream::CASES;

use crate::diagnostic::Diagnostic;
use crate::file::Limit;
use crate::source::{SourceId, Sources};
use stream::Stream;

/// How large the file of a model may be.
pub const LIMIT: Limit = Limit {
    what: "a model",
    bytes: lexical::MAX_BYTES as u64,
};

/// A name as it is written in a model: as a word if it is one, else in quotes.
///
/// ```
/// use dynamics_codegen::syntax::written_name;
///
/// assert_eq!(written_name("joint_1"), "joint_1");
/// assert_eq!(written_name("joint 1"), "\"joint 1\"");
/// ```
pub fn written_name(name: &str) -> String {
    let starts = |c: char| c.is_ascii_alphabetic() || c == '_';
    let word = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.starts_with(starts)
        && name != "_";
    if word {
        name.to_string()
    } else {
        format!("{name:?}")
    }
}

/// What the parameters of an effect begin with: those of `viscous(j2)` are called `viscous_j2_…`.
/// `called` says what a place is called; `None` if the statement is no effect.
pub fn effect_prefix(kind: &StatementKind, called: impl Fn(&str) -> String) -> Option<String> {
    let StatementKind::Effect { template, on, .. } = kind else {
        return None;
    };
    let places = on.iter().map(|place| called(&place.text));
    let words = std::iter::once(template.text.clone()).chain(places);
    Some(words.map(|word| word + "_").collect())
}

/// Parses one file: a model or an effect template.
///
/// Never fails as a whole: what could not be read is in the diagnostics, and
/// what could be read is in the tree (`None` if not even the heading was found).
pub fn parse(sources: &Sources, id: SourceId) -> (Option<File>, Vec<Diagnostic>) {
    let _places = Places::own();
    let text = &sources.get(id).text;
    let faults = lexical::check(text, id);
    if !faults.is_empty() {
        return (None, faults);
    }
    let (mut file, mut diagnostics) = (None, Vec::new());
    let parser = |input: syn::parse::ParseStream| {
        let (parsed, found) = statement::file(&mut Stream::new(input, id));
        (file, diagnostics) = (parsed, found);
        Ok(())
    };
    if let Err(error) = syn::parse::Parser::parse_str(parser, text)
        && diagnostics.is_empty()
    {
        let place = stream::from_syn(&error, id).primary.span;
        diagnostics.push(Diagnostic::error(
            place,
            "this cannot be read as part of a model",
        ));
    }
    (file, diagnostics)
}

/// While this lives, tokens know the bytes they come from.
///
/// Inside a procedural macro `proc_macro2` hands the work to rustc, whose tokens do not
/// tell their place on a stable compiler. Its own tokens do, there as everywhere.
struct Places;

impl Places {
    fn own() -> Self {
        proc_macro2::fallback::force();
        Self
    }
}

impl Drop for Places {
    fn drop(&mut self) {
        proc_macro2::fallback::unforce();
    }
}
