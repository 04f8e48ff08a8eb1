//! Effect templates and their application to a model.

use super::builder::Builder;
use super::each::{Places, bind_each, refuse_beside_others};
use super::names::{Binding, Scope};
use super::template::term;
use super::{Effect, Library};
use crate::diagnostic::{Diagnostic, nearest};
use crate::source::{SourceId, Sources, Span};
use crate::syntax::{self, Expr, File, Heading, Name, Port, PortKind, Statement, StatementKind};

/// Applies the model's `effect` statements.
pub(super) struct Templates<'a> {
    pub sources: &'a mut Sources,
    pub library: &'a Library,
}

/// One `effect` statement.
struct Application<'a> {
    template: &'a Name,
    on: &'a [Name],
    values: &'a [(Name, Expr)],
    span: Span,
    doc: &'a str,
}

impl Templates<'_> {
    pub fn apply_all(&mut self, builder: &mut Builder<'_>, statements: &[&Statement]) {
        for statement in statements {
            if let StatementKind::Effect {
                template,
                on,
                values,
            } = &statement.kind
            {
                self.apply(
                    builder,
                    &Application {
                        template,
                        on,
                        values,
                        span: statement.span,
                        doc: &statement.doc,
                    },
                );
            }
        }
    }

    fn apply(&mut self, builder: &mut Builder<'_>, application: &Application<'_>) -> Option<()> {
        let file = self.read(builder, application.template)?;
        let Heading::Effect { ports, .. } = &file.heading else {
            return builder.report(Diagnostic::error(
                application.template.span,
                format!("`{}` is not an effect template", application.template.text),
            ));
        };
        refuse_beside_others(builder, ports)?;
        let (places, scopes) = bind_ports(builder, ports, application)?;
        refuse_repetition(builder, application, &places)?;
        let values = evaluate_values(builder, application)?;
        let index = builder.model.effects.len();
        let mut scopes = scopes.into_iter();
        let outer = std::mem::replace(&mut builder.scope, scopes.next()?);
        let others: Vec<(&Name, Scope)> = application.on.iter().skip(1).zip(scopes).collect();
        let first_parameter = builder.model.parameters.len();
        let findings = builder.finding_count();
        builder.effect = Some(index);
        builder.prefix = prefix(application);
        if !others.is_empty() {
            builder.member = format!("{}_", application.on[0].text);
        }
        let statements: Vec<&Statement> = file.statements.iter().collect();
        refuse_foreign_statements(builder, &statements);
        let term = term(builder, ports, &statements);
        builder.declare(&statements, self.sources, self.library);
        set_values(builder, first_parameter, values);
        builder.lower_statements(&statements);
        builder.repeat(others, &statements, self.sources, self.library);
        builder.explain(findings, application.template.span);
        builder.effect = None;
        builder.prefix.clear();
        builder.member.clear();
        builder.scope = outer;
        builder.model.effects.push(Effect {
            template: application.template.text.clone(),
            on: places,
            parameters: (first_parameter..builder.model.parameters.len()).collect(),
            term,
            doc: file.doc,
            provenance: application.doc.to_string(),
        });
        Some(())
    }

    /// The template's syntax tree.
    fn read(&mut self, builder: &mut Builder<'_>, name: &Name) -> Option<File> {
        let Some(text) = self.library.get(&name.text) else {
            let error = Diagnostic::error(
                name.span,
                format!("there is no effect named `{}`", name.text),
            );
            let near = nearest(&name.text, self.library.names());
            let names: Vec<&str> = self.library.names().collect();
            let error = match near {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help(format!("the library has: {}", names.join(", "))),
            };
            return builder.report(error.help(format!(
                "an effect of your own is found by its folder: `--effects DIR`, where \
                 `DIR/{}.model` is",
                name.text
            )));
        };
        let id: SourceId = self.sources.add(text.origin.clone(), text.text.clone());
        let (file, faults) = syntax::parse(self.sources, id);
        let clean = faults.is_empty();
        for fault in faults {
            builder.report::<()>(fault.also(name.span, "needed here"));
        }
        file.filter(|_| clean)
    }
}

/// Parameters of `viscous(j2)` are called `viscous_j2_<name>`.
fn prefix(application: &Application<'_>) -> String {
    let places: String = application
        .on
        .iter()
        .map(|place| format!("{}_", place.text))
        .collect();
    format!("{}_{places}", application.template.text)
}

/// What the ports are bound to, and the scope of the template there; several scopes where it is applied to one
/// place after the other.
fn bind_ports(
    builder: &mut Builder<'_>,
    ports: &[Port],
    application: &Application<'_>,
) -> Option<(Places, Vec<Scope>)> {
    let several = ports
        .last()
        .is_some_and(|p| p.each || p.kind == PortKind::Coordinates);
    let fits = if several {
        application.on.len() >= ports.len()
    } else {
        application.on.len() == ports.len()
    };
    if !fits {
        let names: Vec<&str> = ports.iter().map(|port| port.name.text.as_str()).collect();
        return builder.report(Diagnostic::error(
            application.span,
            format!(
                "`{0}` is applied as `{0}({1})`, found {2} in the brackets",
                application.template.text,
                names.join(", "),
                application.on.len()
            ),
        ));
    }
    if let [port @ Port { each: true, .. }] = ports {
        return bind_each(builder, port, application.on);
    }
    let (mut places, mut scope) = (Vec::new(), Scope::default());
    for (position, (port, place)) in ports.iter().zip(application.on).enumerate() {
        if port.kind == PortKind::Coordinates {
            if position + 1 < ports.len() {
                let message = "a port for several coordinates is the last one";
                return builder.report(Diagnostic::error(port.name.span, message));
            }
            let rest = &application.on[position..];
            builder.bind_set(&port.name.text, rest)?;
            places.extend(
                rest[1..]
                    .iter()
                    .map(|place| (PortKind::Coordinate, place.text.clone())),
            );
        }
        let (kind, index) = builder.find_port(port.kind, place)?;
        scope.ports.insert(port.name.text.clone(), (kind, index));
        let kind = match kind {
            PortKind::Coordinates => PortKind::Coordinate,
            kind => kind,
        };
        places.insert(position, (kind, place.text.clone()));
    }
    scope.sets = std::mem::take(&mut builder.pending_sets);
    Some((places, vec![scope]))
}

/// The parameters of two equal effects would have one name, and only their sum would show.
fn refuse_repetition(
    builder: &mut Builder<'_>,
    application: &Application<'_>,
    places: &[(PortKind, String)],
) -> Option<()> {
    let name = &application.template.text;
    let mut effects = builder.model.effects.iter();
    if !effects.any(|effect| effect.template == *name && effect.on == places) {
        return Some(());
    }
    let on: Vec<&str> = places.iter().map(|(_, place)| place.as_str()).collect();
    let message = format!("`{name}({})` is applied twice", on.join(", "));
    builder.report(Diagnostic::error(application.span, message).help("keep one of them"))
}

fn evaluate_values(
    builder: &mut Builder<'_>,
    application: &Application<'_>,
) -> Option<Vec<(Name, f64)>> {
    let mut values = Vec::new();
    for (name, expr) in application.values {
        values.push((name.clone(), builder.number(expr)?));
    }
    Some(values)
}

/// Gives the template's parameters the values that the model states.
fn set_values(builder: &mut Builder<'_>, first: usize, values: Vec<(Name, f64)>) {
    for (name, value) in values {
        let bound = builder
            .scope
            .names
            .get(&name.text)
            .map(|declared| declared.what.clone());
        let Some(Binding::Parameter(index)) = bound else {
            let known: Vec<String> = builder.model.parameters[first..]
                .iter()
                .map(|p| p.name[builder.prefix.len()..].to_string())
                .collect();
            let message = format!("the effect has no parameter `{}`", name.text);
            let help = match builder.near(&name.text, known.iter().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None if known.is_empty() => "it has no parameters".to_string(),
                None => format!("its parameters are: {}", known.join(", ")),
            };
            builder.report::<()>(Diagnostic::error(name.span, message).help(help));
            continue;
        };
        let parameter = &mut builder.model.parameters[index];
        if (parameter.lower..=parameter.upper).contains(&value) {
            parameter.nominal = value;
        } else {
            let side = |bound: f64| {
                if bound.is_finite() {
                    bound.to_string()
                } else {
                    String::new()
                }
            };
            let bounds = format!("in {}..{}", side(parameter.lower), side(parameter.upper));
            let message = format!("the value {value} of `{}` is not in its bounds", name.text);
            builder.report::<()>(
                Diagnostic::error(name.span, message)
                    .help(format!("the effect's template says `{bounds}`")),
            );
        }
    }
}

/// A template adds to a model; it does not define what the model consists of.
fn refuse_foreign_statements(builder: &mut Builder<'_>, statements: &[&Statement]) {
    for statement in statements {
        let what = match &statement.kind {
            StatementKind::Coordinate { .. } => "a coordinate",
            StatementKind::Input { .. } => "an input",
            StatementKind::Constraint { .. } => "a constraint",
            StatementKind::Contact(_) => "a contact",
            StatementKind::Output { .. } => "an output",
            StatementKind::Sensor(_) => "a sensor",
            StatementKind::Effect { .. } => "another effect",
            StatementKind::Robot { .. } => "a robot description",
            StatementKind::Part(_) => "a part",
            StatementKind::Table(_) => "a table",
            StatementKind::Use(_) => "the use of a part",
            _ => continue,
        };
        builder.report::<()>(Diagnostic::error(
            statement.span,
            format!("an effect template cannot declare {what}"),
        ));
    }
}
