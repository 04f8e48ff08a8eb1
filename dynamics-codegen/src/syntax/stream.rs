//! A token stream that knows its place.

use super::ast::Name;
use super::lexical::LONGEST_WORD;
use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, Span};
use syn::ext::IdentExt;
use syn::parse::{ParseBuffer, ParseStream};
use syn::spanned::Spanned;

/// What stands for a choice between cases.
pub(crate) const CASES: &str = "cases are written with `step(x)`, 1 where x is positive and 0 elsewhere, or with `min`, `max`, `abs` and `sign`; a constraint may come and go: `constraint c when x: …`";

/// What the parsing functions return; `Err` holds the first thing that is
/// wrong with the statement at hand.
pub(super) type Parsed<T> = Result<T, Box<Diagnostic>>;

/// `syn`'s tokens plus the end of the token before, which is where a missing
/// `;` belongs.
pub(super) struct Stream<'a> {
    pub input: ParseStream<'a>,
    pub source: SourceId,
    previous: Span,
}

/// The place that `syn` means.
pub(super) fn span_of(span: proc_macro2::Span, source: SourceId) -> Span {
    let range = span.byte_range();
    Span {
        source,
        start: range.start,
        end: range.end,
    }
}

/// `syn`'s own errors, for what the grammar leaves to it.
pub(super) fn from_syn(error: &syn::Error, source: SourceId) -> Diagnostic {
    Diagnostic::error(span_of(error.span(), source), error.to_string())
}

impl<'a> Stream<'a> {
    pub fn new(input: ParseStream<'a>, source: SourceId) -> Self {
        Self {
            input,
            source,
            previous: Span {
                source,
                start: 0,
                end: 0,
            },
        }
    }

    /// A stream over the inside of brackets.
    pub fn inside<'b>(&self, content: &'b ParseBuffer<'b>) -> Stream<'b> {
        Stream {
            input: content,
            source: self.source,
            previous: self.previous,
        }
    }

    /// The place of the next token, or the end of the previous one.
    pub fn here(&self) -> Span {
        if self.input.is_empty() {
            self.after()
        } else {
            span_of(self.input.span(), self.source)
        }
    }

    /// The place of the token before.
    pub fn previous(&self) -> Span {
        self.previous
    }

    /// Just behind the token before.
    pub fn after(&self) -> Span {
        let end = self.previous.end;
        Span {
            source: self.source,
            start: end.saturating_sub(1),
            end,
        }
    }

    /// Marks what was just read.
    pub fn passed(&mut self, span: proc_macro2::Span) -> Span {
        self.previous = span_of(span, self.source);
        self.previous
    }

    /// Whether the next token is this word.
    pub fn at_word(&self, word: &str) -> bool {
        self.input
            .cursor()
            .ident()
            .is_some_and(|(ident, _)| ident == word)
    }

    /// Whether the next token is this word, and brackets follow.
    pub fn at_call(&self, word: &str) -> bool {
        let next = self.input.cursor().ident();
        next.is_some_and(|(ident, rest)| {
            let brackets = rest.group(proc_macro2::Delimiter::Parenthesis);
            ident == word && brackets.is_some()
        })
    }

    /// The word behind the next one: what a statement is about to define.
    pub fn second_word(&self) -> Option<Name> {
        let (_, rest) = self.input.cursor().ident()?;
        let (ident, _) = rest.ident()?;
        Some(Name {
            text: ident.unraw().to_string(),
            span: span_of(ident.span(), self.source),
        })
    }

    /// Whether the next character is this punctuation.
    pub fn at(&self, punctuation: char) -> bool {
        self.input
            .cursor()
            .punct()
            .is_some_and(|(p, _)| p.as_char() == punctuation)
    }

    /// Whether the next two characters are this punctuation, unseparated.
    pub fn at_pair(&self, first: char, second: char) -> bool {
        let Some((p, rest)) = self.input.cursor().punct() else {
            return false;
        };
        p.as_char() == first
            && p.spacing() == proc_macro2::Spacing::Joint
            && rest.punct().is_some_and(|(p, _)| p.as_char() == second)
    }

    /// Reads one punctuation character if it is next.
    pub fn eat(&mut self, punctuation: char) -> bool {
        if !self.at(punctuation) {
            return false;
        }
        self.skip();
        true
    }

    /// Reads this word if it is next.
    pub fn eat_word(&mut self, word: &str) -> bool {
        if !self.at_word(word) {
            return false;
        }
        self.skip();
        true
    }

    /// Reads any one token.
    pub fn skip(&mut self) {
        if let Ok(token) = self.input.parse::<proc_macro2::TokenTree>() {
            self.passed(token.span());
        }
    }

    /// Reads one punctuation character or says what was expected.
    pub fn expect(&mut self, punctuation: char, after_what: &str) -> Parsed<()> {
        if self.eat(punctuation) {
            return Ok(());
        }
        let span = if punctuation == ';' {
            self.after()
        } else {
            self.here()
        };
        let error = Diagnostic::error(span, format!("expected `{punctuation}` after {after_what}"))
            .label(format!("expected `{punctuation}`"));
        Err(Box::new(if punctuation == ';' && self.compares() {
            error.help("what must be equal is a constraint: `constraint name: left == right;`")
        } else {
            error
        }))
    }

    /// Reads a text in quotes.
    pub fn text(&mut self, what: &str) -> Parsed<Name> {
        if !self.input.peek(syn::LitStr) {
            let error = Diagnostic::error(self.here(), format!("expected {what}")).label("here");
            return Err(Box::new(error));
        }
        let literal: syn::LitStr = (self.input.parse())
            .map_err(|error: syn::Error| Box::new(from_syn(&error, self.source)))?;
        let span = self.passed(literal.span());
        Ok(Name {
            text: literal.value(),
            span,
        })
    }

    /// Whether a member such as `.x` comes next.
    pub fn at_member(&self) -> bool {
        let next = self.input.cursor().punct();
        next.is_some_and(|(p, rest)| p.as_char() == '.' && rest.ident().is_some())
    }

    /// Reads a word that is to be a name; a name that is no word stands in quotes.
    pub fn name(&mut self, what: &str) -> Parsed<Name> {
        if self.input.peek(syn::LitStr) {
            return short(self.text(what)?);
        }
        let unexpected = |stream: &Self| {
            Box::new(Diagnostic::error(stream.here(), format!("expected {what}")).label(what))
        };
        if !self.input.peek(syn::Ident::peek_any) {
            return Err(unexpected(self));
        }
        let ident = self
            .input
            .call(syn::Ident::parse_any)
            .map_err(|_| unexpected(self))?;
        let span = self.passed(ident.span());
        Ok(Name {
            text: ident.unraw().to_string(),
            span,
        })
    }

    /// Reads the name of something that is there already; inside the use of a part it is reached
    /// by its path, `left.tip`.
    pub fn place(&mut self, what: &str) -> Parsed<Name> {
        let mut place = self.name(what)?;
        while self.at_member() {
            self.skip();
            let inner = self.name("a name")?;
            place.text.push('.');
            place.text.push_str(&inner.text);
            place.span = place.span.to(inner.span);
            place = short(place)?;
        }
        Ok(place)
    }

    /// Opens `(…)`: the inside and the brackets.
    pub fn parentheses(&self) -> Parsed<(ParseBuffer<'a>, syn::token::Paren)> {
        let open = |input: ParseStream<'a>| {
            let content;
            let brackets = syn::parenthesized!(content in input);
            Ok((content, brackets))
        };
        open(self.input).map_err(|e: syn::Error| Box::new(from_syn(&e, self.source)))
    }

    /// Opens `{…}`: the inside and the brackets.
    pub fn braces(&self) -> Parsed<(ParseBuffer<'a>, syn::token::Brace)> {
        let open = |input: ParseStream<'a>| {
            let content;
            let brackets = syn::braced!(content in input);
            Ok((content, brackets))
        };
        open(self.input).map_err(|e: syn::Error| Box::new(from_syn(&e, self.source)))
    }

    /// An error at the next token.
    pub fn unexpected<T>(&self, expected: &str) -> Parsed<T> {
        Err(Box::new(
            Diagnostic::error(self.here(), format!("expected {expected}")).label("found this"),
        ))
    }

    /// The error that an expression goes on with something else than an operator or what was expected.
    pub fn no_operator<T>(&self, expected: &str) -> Parsed<T> {
        let found = self.unexpected(&format!("an operator{expected}"));
        match self.compares() {
            true => found.map_err(|error| Box::new(error.help(CASES))),
            false => found,
        }
    }

    /// Whether a comparison comes next.
    fn compares(&self) -> bool {
        ['<', '>', '='].into_iter().any(|sign| self.at(sign))
    }

    /// Text of the doc comments that come next.
    pub fn doc(&mut self) -> Parsed<String> {
        if self.at('#') && self.input.peek2(syn::Token![!]) {
            let error = Diagnostic::error(self.here(), "`//!` has no meaning in a model");
            return Err(Box::new(error.help(
                "write `///` for a description, in front of what it describes, or `//` for a remark",
            )));
        }
        let attributes = self
            .input
            .call(syn::Attribute::parse_outer)
            .map_err(|e| Box::new(from_syn(&e, self.source)))?;
        let mut lines = Vec::new();
        for attribute in attributes {
            self.passed(attribute.span());
            if let syn::Meta::NameValue(meta) = &attribute.meta
                && let syn::Expr::Lit(syn::ExprLit {
                    lit: syn::Lit::Str(text),
                    ..
                }) = &meta.value
            {
                lines.push(text.value().trim().to_string());
            }
        }
        Ok(lines.join("\n"))
    }
}

/// A name that is not so long that all that repeats it is out of proportion.
fn short(name: Name) -> Parsed<Name> {
    if name.text.len() <= LONGEST_WORD {
        return Ok(name);
    }
    let message = format!("a name has at most {LONGEST_WORD} bytes");
    Err(Box::new(Diagnostic::error(name.span, message)))
}
