//! Statements. A fault in one does not hide the faults in the next.

use super::ast::{Expr, File, Heading, Name, Port, PortKind, Prior, Statement, StatementKind};
use super::body::{self, triple};
use super::contact;
use super::expression::{bounds, expression, unit};
use super::part;
use super::sensor;
use super::stream::{Parsed, Stream};
use super::table;
use crate::diagnostic::{Diagnostic, nearest};
use crate::robot::Format;

/// The words that begin a statement.
const KEYWORDS: [&str; 27] = [
    "coordinate",
    "input",
    "state",
    "measured",
    "mounted",
    "parameter",
    "constant",
    "let",
    "kinetic",
    "potential",
    "dissipation",
    "force",
    "constraint",
    "contact",
    "output",
    "sensor",
    "effect",
    "urdf",
    "mjcf",
    "frame",
    "body",
    "gravity",
    "torque",
    "term",
    "part",
    "use",
    "table",
];

/// The whole file.
pub(super) fn file(stream: &mut Stream<'_>) -> (Option<File>, Vec<Diagnostic>) {
    let mut found = Vec::new();
    let opening = heading(stream);
    let (doc, heading) = match opening {
        Ok((doc, heading)) => (doc, Some(heading)),
        Err(diagnostic) => {
            found.push(*diagnostic);
            recover(stream);
            (String::new(), None)
        }
    };
    let (statements, unreadable) = statements(stream, &mut found);
    (
        heading.map(|heading| File {
            heading,
            doc,
            statements,
            unreadable,
        }),
        found,
    )
}

/// All statements up to the end of the file or of the part, and what those that could not be read
/// were going to define.
pub(super) fn statements(
    stream: &mut Stream<'_>,
    found: &mut Vec<Diagnostic>,
) -> (Vec<Statement>, Vec<Name>) {
    let (mut statements, mut unreadable) = (Vec::new(), Vec::new());
    while !stream.input.is_empty() {
        let (start, defined) = (stream.here(), stream.second_word());
        match statement(stream, found) {
            Ok(statement) => statements.push(statement),
            Err(diagnostic) => {
                found.push(*diagnostic);
                unreadable.extend(defined);
                if stream.here() == start {
                    stream.skip();
                }
                recover(stream);
            }
        }
    }
    (statements, unreadable)
}

/// Goes on behind the next `;`, or in front of the next word that begins a statement.
fn recover(stream: &mut Stream<'_>) {
    while !stream.input.is_empty() && !stream.eat(';') {
        // `input(x)` and `coordinate(x)` may stand in an expression.
        let call = stream.at_call("input") || stream.at_call("coordinate");
        if !call && KEYWORDS.iter().any(|word| stream.at_word(word)) {
            return;
        }
        stream.skip();
    }
}

fn heading(stream: &mut Stream<'_>) -> Parsed<(String, Heading)> {
    let doc = stream.doc()?;
    let heading = if stream.eat_word("model") {
        Heading::Model(stream.name("the model's name")?)
    } else if stream.eat_word("effect") {
        let name = stream.name("the effect's name")?;
        Heading::Effect {
            name,
            ports: ports(stream)?,
        }
    } else {
        let error = Diagnostic::error(stream.here(), "a file begins with `model name;`")
            .help("or, for an effect template, with `effect name(joint);`");
        return Err(Box::new(error));
    };
    stream.expect(';', "the heading")?;
    Ok((doc, heading))
}

/// What a port can stand for.
const KINDS: &str = "`coordinate`, `coordinates`, `input`, `drive`, `body`, `constraint`, \
    `reading`, `sensor` or `frame`";

fn ports(stream: &mut Stream<'_>) -> Parsed<Vec<Port>> {
    let mut ports = Vec::new();
    in_brackets(stream, |inner| {
        let name = inner.name("the name of a port")?;
        let mut each = false;
        let kind = if inner.eat(':') {
            let mut kind = inner.name(KINDS)?;
            each = kind.text == "each";
            if each {
                kind = inner.name(KINDS)?;
            }
            match kind.text.as_str() {
                "coordinate" => PortKind::Coordinate,
                "input" => PortKind::Input,
                "drive" => PortKind::Drive,
                "body" => PortKind::Body,
                "coordinates" => PortKind::Coordinates,
                "constraint" => PortKind::Constraint,
                "reading" => PortKind::Reading,
                "sensor" => PortKind::Sensor,
                "frame" => PortKind::Frame,
                _ => {
                    return Err(Box::new(
                        Diagnostic::error(kind.span, format!("expected {KINDS}"))
                            .label("no such kind of port"),
                    ));
                }
            }
        } else {
            PortKind::Coordinate
        };
        ports.push(Port { name, kind, each });
        Ok(())
    })?;
    Ok(ports)
}

/// `( item, item, … )`
pub(super) fn in_brackets(
    stream: &mut Stream<'_>,
    mut item: impl FnMut(&mut Stream<'_>) -> Parsed<()>,
) -> Parsed<()> {
    if !stream.input.peek(syn::token::Paren) {
        return stream.unexpected("`(`");
    }
    let (content, paren) = stream.parentheses()?;
    let mut inner = stream.inside(&content);
    while !inner.input.is_empty() {
        item(&mut inner)?;
        if !inner.input.is_empty() {
            inner.expect(',', "this entry")?;
        }
    }
    stream.passed(paren.span.close());
    Ok(())
}

/// One statement. What is wrong inside a part goes to `found`: the part is there all the same.
fn statement(stream: &mut Stream<'_>, found: &mut Vec<Diagnostic>) -> Parsed<Statement> {
    let doc = stream.doc()?;
    let start = stream.here();
    let keyword = stream.name("a statement")?;
    // Behind a closing brace the `;` may be left out.
    let mut braced = false;
    let kind = match keyword.text.as_str() {
        "coordinate" => {
            let name = stream.name("the coordinate's name")?;
            StatementKind::Coordinate {
                name,
                unit: unit_behind_colon(stream)?,
            }
        }
        "input" => input(stream)?,
        "state" => state(stream)?,
        "measured" => {
            let name = stream.place("the coordinate or sensor that is measured")?;
            StatementKind::Measured {
                name,
                value: value(stream)?,
            }
        }
        "mounted" => {
            let name = stream.place("the frame whose sensors are mounted")?;
            StatementKind::Mounted {
                name,
                value: value(stream)?,
            }
        }
        "dot" => rate(stream)?,
        "parameter" => parameter(stream)?,
        "constant" => constant(stream)?,
        "let" => {
            let name = stream.name("a name")?;
            StatementKind::Let {
                name,
                value: value(stream)?,
            }
        }
        "output" => {
            let name = stream.name("the output's name")?;
            StatementKind::Output {
                name,
                value: value(stream)?,
            }
        }
        "sensor" => {
            let (kind, ends_in_brace) = sensor::sensor(stream)?;
            braced = ends_in_brace;
            kind
        }
        "contact" => {
            let (kind, ends_in_brace) = contact::contact(stream)?;
            braced = ends_in_brace;
            kind
        }
        "kinetic" => StatementKind::Kinetic(expression(stream)?),
        "potential" => StatementKind::Potential(expression(stream)?),
        "dissipation" => StatementKind::Dissipation(expression(stream)?),
        "force" if stream.at_call("at") => body::point_force(stream, false)?,
        "torque" => body::point_force(stream, true)?,
        word @ ("urdf" | "mjcf") => {
            let mut formats = Format::ALL.into_iter();
            let format = formats.find(|format| format.word() == word);
            let (kind, ends_in_brace) = body::robot(stream, format.unwrap_or(Format::Urdf))?;
            braced = ends_in_brace;
            kind
        }
        "frame" => body::frame(stream)?,
        "body" => {
            braced = true;
            body::body(stream)?
        }
        "gravity" => StatementKind::Gravity(Box::new(triple(stream)?)),
        "force" => {
            let on = stream.place("the coordinate that the force acts on")?;
            StatementKind::Force {
                on,
                value: value(stream)?,
            }
        }
        "constraint" => constraint(stream)?,
        "term" => term(stream)?,
        "table" => {
            let (kind, ends_in_brace) = table::table(stream)?;
            braced = ends_in_brace;
            kind
        }
        "part" => {
            braced = true;
            part::part(stream, found)?
        }
        "use" => {
            let (kind, ends_in_brace) = part::used(stream)?;
            braced = ends_in_brace;
            kind
        }
        "effect" => return effect(stream, doc, start),
        unknown => return Err(Box::new(unknown_statement(&keyword, unknown))),
    };
    if !stream.eat(';') && !braced {
        stream.expect(';', "this statement")?;
    }
    Ok(Statement {
        doc,
        span: start.to(stream.previous()),
        kind,
    })
}

fn unknown_statement(keyword: &Name, word: &str) -> Diagnostic {
    let error = Diagnostic::error(keyword.span, format!("`{word}` does not begin a statement"));
    match nearest(word, KEYWORDS) {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None => error.help(format!(
            "a statement begins with one of: {}",
            KEYWORDS.join(", ")
        )),
    }
}

fn unit_behind_colon(stream: &mut Stream<'_>) -> Parsed<Option<super::ast::Unit>> {
    stream.eat(':').then(|| unit(stream)).transpose()
}

fn value(stream: &mut Stream<'_>) -> Parsed<Expr> {
    stream.expect('=', "the name")?;
    expression(stream)
}

fn input(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let name = stream.place("the input's name")?;
    if stream.eat('=') {
        return Ok(StatementKind::Channel {
            name,
            value: expression(stream)?,
        });
    }
    Ok(StatementKind::Input {
        name,
        unit: unit_behind_colon(stream)?,
    })
}

fn state(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let name = stream.name("the state's name")?;
    let unit = unit_behind_colon(stream)?;
    let initial = stream.eat('=').then(|| expression(stream)).transpose()?;
    Ok(StatementKind::State {
        name,
        unit,
        initial,
    })
}

/// `dot(z) == expression`, behind the `dot`.
fn rate(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let start = stream.here();
    let mut names = Vec::new();
    in_brackets(stream, |inner| {
        names.push(inner.place("the name of a state")?);
        Ok(())
    })?;
    let brackets = start.to(stream.previous());
    let Ok([name]) = <[Name; 1]>::try_from(names) else {
        let error = Diagnostic::error(brackets, "`dot(…)` takes the name of one state");
        return Err(Box::new(error));
    };
    if !stream.at_pair('=', '=') {
        let error = Diagnostic::error(stream.here(), "a rate is an equation, `dot(z) == …`")
            .label("expected `==`");
        return Err(Box::new(error));
    }
    stream.skip();
    stream.skip();
    Ok(StatementKind::Rate {
        name,
        value: expression(stream)?,
    })
}

fn parameter(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let name = stream.name("the parameter's name")?;
    let unit = unit_behind_colon(stream)?;
    let nominal = stream.eat('=').then(|| expression(stream)).transpose()?;
    let bounds = stream.eat_word("in").then(|| bounds(stream)).transpose()?;
    let prior = stream
        .eat_word("prior")
        .then(|| prior(stream).map(Box::new))
        .transpose()?;
    let tries = stream
        .eat_word("try")
        .then(|| expression(stream))
        .transpose()?;
    Ok(StatementKind::Parameter {
        name,
        unit,
        nominal,
        bounds,
        prior,
        tries,
    })
}

fn prior(stream: &mut Stream<'_>) -> Parsed<Prior> {
    let name = stream.name("`normal(mean, sd)`")?;
    let mut values = Vec::new();
    in_brackets(stream, |inner| {
        values.push(expression(inner)?);
        Ok(())
    })?;
    let count = values.len();
    match (name.text.as_str(), <[Expr; 2]>::try_from(values)) {
        ("normal", Ok([mean, sd])) => Ok(Prior { mean, sd }),
        _ => Err(Box::new(
            Diagnostic::error(name.span, "a prior is `normal(mean, sd)`")
                .label(format!("`{}` with {count} values", name.text)),
        )),
    }
}

fn constant(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let name = stream.name("the constant's name")?;
    let unit = unit_behind_colon(stream)?;
    Ok(StatementKind::Constant {
        name,
        unit,
        value: value(stream)?,
    })
}

fn constraint(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let name = stream.name("the constraint's name")?;
    let when = stream
        .eat_word("when")
        .then(|| expression(stream))
        .transpose()?;
    let before = match when {
        Some(_) => "the condition",
        None => "the constraint's name",
    };
    stream.expect(':', before)?;
    let left = expression(stream)?;
    if !stream.at_pair('=', '=') {
        let error = Diagnostic::error(
            stream.here(),
            "a constraint is an equation, `left == right`",
        )
        .label("expected `==`");
        return Err(Box::new(error));
    }
    stream.skip();
    stream.skip();
    Ok(StatementKind::Constraint {
        name,
        when,
        left,
        right: expression(stream)?,
    })
}

/// `term name between neighbours`, behind the `term`.
fn term(stream: &mut Stream<'_>) -> Parsed<StatementKind> {
    let name = stream.name("the term's name")?;
    let start = stream.here();
    let mut neighbours = None;
    if stream.eat_word("between") {
        if !stream.eat_word("neighbours") {
            return stream.unexpected("`neighbours`");
        }
        neighbours = Some(start.to(stream.previous()));
    }
    Ok(StatementKind::Term { name, neighbours })
}

/// `effect name(places) { parameter = value, … }`; the braces and the `;` may be left out.
fn effect(stream: &mut Stream<'_>, doc: String, start: crate::source::Span) -> Parsed<Statement> {
    let template = stream.name("the effect's name")?;
    let mut on = Vec::new();
    in_brackets(stream, |inner| {
        on.push(inner.place("the name of a coordinate, input, body, sensor or frame")?);
        Ok(())
    })?;
    let (values, braced) = values(stream, "a parameter of the effect")?;
    if !stream.eat(';') && !braced {
        stream.expect(';', "this statement")?;
    }
    let kind = StatementKind::Effect {
        template,
        on,
        values,
    };
    Ok(Statement {
        doc,
        span: start.to(stream.previous()),
        kind,
    })
}

/// `{ parameter = value, … }`, which may be left out. Also: whether it was there.
pub(super) fn values(stream: &mut Stream<'_>, what: &str) -> Parsed<(Vec<(Name, Expr)>, bool)> {
    let mut values = Vec::new();
    let braced = stream.input.peek(syn::token::Brace);
    if braced {
        let (content, brace) = stream.braces()?;
        let mut inner = stream.inside(&content);
        while !inner.input.is_empty() {
            let name = inner.place(what)?;
            inner.expect('=', "the parameter's name")?;
            values.push((name, expression(&mut inner)?));
            if !inner.input.is_empty() && !inner.eat(';') {
                inner.expect(',', "this value")?;
            }
        }
        stream.passed(brace.span.close());
    }
    Ok((values, braced))
}
