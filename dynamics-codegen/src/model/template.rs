//! What an effect template says about itself.

use super::Library;
use super::builder::Builder;
use crate::diagnostic::Diagnostic;
use crate::source::Sources;
use crate::syntax::{self, BodyStatement, Expr, ExprKind, Heading, Port, PortKind};
use crate::syntax::{Statement, StatementKind, UnitBase};

/// What a template offers, for whoever wants to try it on a model.
#[derive(Debug, Clone)]
pub struct Template {
    /// Its name.
    pub name: String,
    /// Its description.
    pub doc: String,
    /// What it acts on, in order.
    pub ports: Vec<PortKind>,
    /// How it is applied to several at once, of each of which it then says the same, if it is.
    pub each: Option<Each>,
    /// Its parameters.
    pub parameters: Vec<TemplateParameter>,
    /// The term of a fit that it is part of; `None`: a fit does not try it.
    pub term: Option<FitTerm>,
    /// Its parameters as those of a point mass, if it is nothing but that.
    pub point_mass: Option<PointMass>,
}

/// A template whose only port may be several places, `effect input_delay(drive: each input);`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Each {
    /// Whether these have to be of one unit, which the unit of a parameter follows from.
    pub of_one_unit: bool,
}

/// A parameter of a template.
#[derive(Debug, Clone)]
pub struct TemplateParameter {
    /// Its name inside the template.
    pub name: String,
    /// Its description.
    pub doc: String,
}

/// `term name between neighbours;`: what a fit of measured forces takes in at once. Effects of one
/// term come and go together, place by place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FitTerm {
    /// What it is called.
    pub name: String,
    /// Whether it acts between two coordinates of joints of which one carries the other, with
    /// none between.
    pub neighbours: bool,
}

/// A template that puts a point mass on a body, `body p { frame: on * translate(x, y, z); mass: m; }`,
/// and does nothing else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PointMass {
    /// Which parameter is its mass.
    pub mass: usize,
    /// Which parameters are its place in the body's frame.
    pub place: [usize; 3],
}

impl Library {
    /// What the template `name` offers; `None` if there is no such template or
    /// its file is faulty.
    pub fn describe(&self, name: &str) -> Option<Template> {
        let text = self.get(name)?;
        let mut sources = Sources::new();
        let id = sources.add(text.origin.clone(), text.text.clone());
        let (file, faults) = syntax::parse(&sources, id);
        let file = file.filter(|_| faults.is_empty())?;
        let Heading::Effect { ports, .. } = &file.heading else {
            return None;
        };
        let statements = &file.statements;
        let parameters = statements.iter().filter_map(|statement| {
            let name = parameter_name(statement)?;
            Some(TemplateParameter {
                name: name.to_string(),
                doc: statement.doc.clone(),
            })
        });
        Some(Template {
            name: name.to_string(),
            doc: file.doc.clone(),
            ports: ports.iter().map(|port| port.kind).collect(),
            each: each(ports, statements),
            parameters: parameters.collect(),
            term: statements.iter().find_map(stated_term),
            point_mass: point_mass(ports, statements),
        })
    }
}

fn each(ports: &[Port], statements: &[Statement]) -> Option<Each> {
    let [Port { each: true, .. }] = ports else {
        return None;
    };
    Some(Each {
        of_one_unit: statements.iter().any(follows_port),
    })
}

/// Whether a statement is a parameter whose unit follows from a port.
pub(super) fn follows_port(statement: &Statement) -> bool {
    let StatementKind::Parameter {
        unit: Some(unit), ..
    } = &statement.kind
    else {
        return false;
    };
    let mut bases = unit.factors.iter().map(|factor| &factor.base);
    bases.any(|base| matches!(base, UnitBase::OfPort { .. }))
}

fn parameter_name(statement: &Statement) -> Option<&str> {
    match &statement.kind {
        StatementKind::Parameter { name, .. } => Some(&name.text),
        _ => None,
    }
}

fn stated_term(statement: &Statement) -> Option<FitTerm> {
    match &statement.kind {
        StatementKind::Term { name, neighbours } => Some(FitTerm {
            name: name.text.clone(),
            neighbours: neighbours.is_some(),
        }),
        _ => None,
    }
}

/// The term that a template states, which is reported where it cannot be meant.
pub(super) fn term(
    builder: &mut Builder<'_>,
    ports: &[Port],
    statements: &[&Statement],
) -> Option<FitTerm> {
    let is_term = |s: &&&Statement| matches!(s.kind, StatementKind::Term { .. });
    let mut stated = statements.iter().filter(is_term);
    let first = stated.next()?;
    if let Some(second) = stated.next() {
        let message = "an effect is part of one term";
        let twice = Diagnostic::error(second.span, message).also(first.span, "stated here already");
        return builder.report(twice);
    }
    if let StatementKind::Term {
        neighbours: Some(words),
        ..
    } = &first.kind
        && ports
            .iter()
            .map(|port| port.kind)
            .ne([PortKind::Coordinate; 2])
    {
        let message = "neighbours are two coordinates, and this effect does not act on two";
        let help = "leave out `between neighbours`, or give the effect two ports for coordinates";
        return builder.report(Diagnostic::error(*words, message).help(help));
    }
    stated_term(first)
}

/// The parameters of a template whose only statement that acts is a body without extent on its
/// only port.
fn point_mass(ports: &[Port], statements: &[Statement]) -> Option<PointMass> {
    let says_nothing = |s: &&Statement| {
        matches!(
            s.kind,
            StatementKind::Parameter { .. } | StatementKind::Term { .. }
        )
    };
    let mut acting = statements.iter().filter(|s| !says_nothing(s));
    let (Some(only), None, [port]) = (acting.next(), acting.next(), ports) else {
        return None;
    };
    let StatementKind::Body(body) = &only.kind else {
        return None;
    };
    let BodyStatement {
        mass: Some(mass),
        center: None,
        inertia: None,
        frame,
        ..
    } = &**body
    else {
        return None;
    };
    let names: Vec<&str> = statements.iter().filter_map(parameter_name).collect();
    let index = |expr: &Expr| names.iter().position(|name| is_name(expr, name));
    let ExprKind::Product(on, factors) = &frame.kind else {
        return None;
    };
    let [(false, moved)] = &factors[..] else {
        return None;
    };
    match &moved.kind {
        ExprKind::Call(function, place) if function.text == "translate" => {
            let [x, y, z] = &place[..] else { return None };
            is_name(on, &port.name.text).then_some(PointMass {
                mass: index(mass)?,
                place: [index(x)?, index(y)?, index(z)?],
            })
        }
        _ => None,
    }
}

fn is_name(expr: &Expr, name: &str) -> bool {
    matches!(&expr.kind, ExprKind::Name(found) if found == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(text: &str) -> Template {
        let mut library = Library::empty();
        library.add("own", "own.model", text);
        library.describe("own").unwrap()
    }

    /// Whatever its parameters are called and in whatever order they stand.
    #[test]
    fn a_point_mass_is_told_by_what_the_template_does() {
        let parameters = "parameter c: m; parameter a: m; parameter w: kg; parameter b: m;";
        let of = |heading: &str, body: &str| {
            let text = format!("effect own({heading}); {parameters} body p {{ {body} }}");
            described(&text).point_mass
        };
        let place = "frame: k * translate(a, b, c); mass: w;";
        let load = PointMass {
            mass: 2,
            place: [1, 3, 0],
        };
        assert_eq!(of("k: body", place), Some(load));
        let others = [
            "frame: k * translate(a, b, 2*c); mass: w;",
            "frame: k * translate(a, b, c); mass: -w;",
            "frame: k * translate(a, b, c); mass: w; inertia: diag(w, w, w);",
            "frame: k * translate(a, b, c); mass: w; center: (a, b, c);",
            "frame: k * rotate_x(a) * translate(a, b, c); mass: w;",
        ];
        for other in others {
            assert_eq!(of("k: body", other), None, "{other}");
        }
        let library = Library::builtin();
        let mut names = library.names();
        let offset = names.find(|name| library.describe(name).unwrap().point_mass.is_some());
        assert!(
            offset.is_some()
                && names.all(|name| library.describe(name).unwrap().point_mass.is_none())
        );
    }

    #[test]
    fn a_template_says_its_term() {
        let text = "effect own(a, b); term drive between neighbours; force a = 0;";
        let term = FitTerm {
            name: "drive".to_string(),
            neighbours: true,
        };
        assert_eq!(described(text).term, Some(term));
        assert_eq!(described("effect own(a); force a = 0;").term, None);
    }
}
