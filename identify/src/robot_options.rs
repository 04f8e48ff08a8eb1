//! The options in the braces behind a model's robot description, written anew in its text.

use dynamics_codegen::source::Sources;
use dynamics_codegen::syntax::{RobotOption, Statement, StatementKind, parse};

/// The model with this behind an option of its description, whatever stands there.
pub(crate) fn with_choice(text: &str, option: &str, value: &str) -> String {
    let Some((statement, options)) = description(text) else {
        return text.to_string();
    };
    let given = options.iter().find(|given| given.name.text == option);
    let ends = given.and_then(|given| Some((given.values.first()?, given.values.last()?)));
    match ends {
        Some((first, last)) => {
            let (before, after) = (&text[..first.span.start], &text[last.span.end..]);
            format!("{before}{value}{after}")
        }
        None => with_option(text, &statement, option, value),
    }
}

/// The statement that names a robot description, and its options.
pub(crate) fn description(text: &str) -> Option<(Statement, Vec<RobotOption>)> {
    let mut sources = Sources::new();
    let id = sources.add("model", text);
    let (file, _) = parse(&sources, id);
    let mut statements = file?.statements.into_iter();
    statements.find_map(|statement| match &statement.kind {
        StatementKind::Robot { options, .. } => {
            let options = options.clone();
            Some((statement, options))
        }
        _ => None,
    })
}

/// The statement with one more option in its braces.
pub(crate) fn with_option(text: &str, statement: &Statement, option: &str, value: &str) -> String {
    let (before, rest) = text.split_at(statement.span.start);
    let (own, after) = rest.split_at(statement.span.end - statement.span.start);
    let own = own.trim_end().trim_end_matches(';').trim_end();
    let own = match own.strip_suffix('}') {
        Some(open) => {
            let open = open.trim_end();
            let end = if open.ends_with([';', '{']) { "" } else { ";" };
            format!("{open}{end} {option}: {value}; }}")
        }
        None => format!("{own} {{ {option}: {value}; }}"),
    };
    format!("{before}{own}{after}")
}
