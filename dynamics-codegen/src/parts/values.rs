//! Values that a use gives the parameters of its part.

use super::rename::Scope;
use super::{Expansion, expand};
use crate::diagnostic::{Diagnostic, nearest};
use crate::source::Sources;
use crate::syntax::{Expr, File, Name, Statement, StatementKind, UseStatement, effect_prefix};

impl Expansion<'_, '_> {
    /// Puts the values of a use into the statements that it has become, those behind `first`.
    pub(super) fn set_values(
        &mut self,
        first: usize,
        used: &UseStatement,
        name: &str,
        outer: &Scope,
    ) {
        for (position, (key, value)) in used.values.iter().enumerate() {
            // `knee.l`: what the part inside has.
            let (of, own) = match key.text.rsplit_once('.') {
                Some((inner, own)) => (format!("{name}_{}", inner.replace('.', "_")), own),
                None => (name.to_string(), key.text.as_str()),
            };
            let earlier = &used.values[..position];
            if let Some((twice, _)) = earlier.iter().find(|(known, _)| known.text == key.text) {
                let message = format!("`{}` is given twice", key.text);
                let error = Diagnostic::error(outer.span(key.span), message);
                self.report(error.also(outer.span(twice.span), "first here"));
                continue;
            }
            let value = outer.expr(value);
            let mut statements = self.statements[first..].iter_mut();
            let own = Name {
                text: own.to_string(),
                span: outer.span(key.span),
            };
            if !statements.any(|statement| set(statement, &own, &value, &of)) {
                self.refuse_value(first, key, &own, &of);
            }
        }
    }

    fn refuse_value(&mut self, first: usize, written: &Name, own: &Name, of: &str) {
        let parameters = self.statements[first..]
            .iter()
            .filter_map(|s| match &s.kind {
                StatementKind::Parameter { name: full, .. } => own_name(&full.text, of),
                _ => None,
            });
        let known: Vec<&str> = parameters.collect();
        let error = Diagnostic::error(
            own.span,
            format!("the part has no parameter `{}`", written.text),
        );
        let error = match nearest(&own.text, known.iter().copied()) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None if known.is_empty() => error.help("it has no parameters of its own"),
            None => error.help(format!("its own parameters are: {}", known.join(", "))),
        };
        self.report(error);
    }
}

/// Where the value of a parameter belongs that a use of a part has brought into the model: the
/// name of the use, and what the parameter is called in its braces. `None` if none has.
///
/// ```
/// use dynamics_codegen::{parts::value_in_use, source::Sources, syntax::parse};
///
/// let text = "model m; part leg() { parameter l: m = 1; } use left = leg();";
/// let mut sources = Sources::new();
/// let id = sources.add("m", text);
/// let file = parse(&sources, id).0.expect("a model");
/// let place = value_in_use(file, &sources, "left_l");
/// assert_eq!(place, Some(("left".to_string(), "l".to_string())));
/// ```
pub fn value_in_use(file: File, sources: &Sources, parameter: &str) -> Option<(String, String)> {
    // What is wrong with the model is for who compiles it.
    let expanded = expand(file, sources, &mut Vec::new());
    expanded.file.statements.iter().find_map(|statement| {
        let reading = statement.span.source.reading();
        let path = expanded.readings.path(reading);
        let (used, inner) = path.split_first()?;
        let full = path.join("_");
        let own = |name: &str| own_name(name, &full).unwrap_or(name).to_string();
        let key = match &statement.kind {
            StatementKind::Parameter { name, .. } if name.text == parameter => own(parameter),
            kind => {
                let prefix = effect_prefix(kind, str::to_string)?;
                let rest = parameter.strip_prefix(&prefix)?;
                effect_prefix(kind, own)? + rest
            }
        };
        let inner: String = inner.iter().map(|name| format!("{name}.")).collect();
        Some((used.to_string(), inner + &key))
    })
}

/// Gives a statement the value if the parameter is its own.
fn set(statement: &mut Statement, key: &Name, value: &Expr, of: &str) -> bool {
    if let StatementKind::Parameter { name, nominal, .. } = &mut statement.kind {
        let same = own_name(&name.text, of) == Some(&key.text);
        if same {
            *nominal = Some(value.clone());
        }
        return same;
    }
    let own = |place: &str| own_name(place, of).unwrap_or(place).to_string();
    let prefix = effect_prefix(&statement.kind, own);
    let StatementKind::Effect { values, .. } = &mut statement.kind else {
        return false;
    };
    let Some(parameter) = prefix.and_then(|prefix| key.text.strip_prefix(&prefix)) else {
        return false;
    };
    values.retain(|(known, _)| known.text != parameter);
    let parameter = Name {
        text: parameter.to_string(),
        span: key.span,
    };
    values.push((parameter, value.clone()));
    true
}

/// What the part itself calls what the model calls `full`.
fn own_name<'n>(full: &'n str, of: &str) -> Option<&'n str> {
    full.strip_prefix(of)?.strip_prefix('_')
}
