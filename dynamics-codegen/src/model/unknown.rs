//! What is said of a name or a function that there is not.

use super::builder::Builder;
use super::frames::WORLD;
use super::lower::Lowered;
use super::names::{FUNCTIONS, NO_FUNCTIONS, VECTORS};
use super::parameter::NUMBERS;
use super::sensor::MOMENTARY_VECTORS;
use crate::diagnostic::{Diagnostic, nearest};
use crate::source::Span;
use crate::syntax::{Expr, ExprKind, Name};

impl Builder<'_> {
    pub(super) fn unknown_name(&mut self, name: &str, span: Span) -> Lowered {
        if self.unreadable_base || self.scope.is_unreadable(name) {
            return None;
        }
        if let Some(component) = self.component_of_twist(name) {
            return Some(component);
        }
        if self.sees_sensor(name) {
            return self.refuse_reading(name, span);
        }
        if let Some(table) = self.table_named(name) {
            let arguments = self.model.tables[table].arguments.iter();
            let arguments: Vec<&str> = arguments.map(|(name, ..)| name.as_str()).collect();
            let help = format!("read it at a place: `{name}({})`", arguments.join(", "));
            let message = format!("`{name}` is a table, not a number");
            return self.report(Diagnostic::error(span, message).help(help));
        }
        // Tables, bounds and nominal values are read before all parameters are known.
        if self.scope.parameters.contains(name) {
            let message = format!("expected a number, and `{name}` is a parameter");
            let error = Diagnostic::error(span, message).label("this may vary");
            return self.report(error.help(NUMBERS));
        }
        let error =
            Diagnostic::error(span, format!("`{name}` is not defined")).label("not defined");
        let near = self.near(name, self.scope.all_names()).map(str::to_string);
        self.report(match near {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help(format!(
                "declare it, for example with `parameter {name}: … = …;` or `let {name} = …;`"
            )),
        })
    }

    /// The first name of a path such as `left.knee` that nothing has, and where it stands.
    pub(super) fn lost_use(&self, path: &Expr) -> Option<(String, Span)> {
        match &path.kind {
            ExprKind::Member(inner, _) => self.lost_use(inner),
            ExprKind::Name(name) => {
                let known = self.scope.has_name(name)
                    || self.scope.frames.names.contains_key(name)
                    || ["gravity", WORLD].contains(&name.as_str());
                let lost = !known && !self.model.uses.is_empty();
                lost.then(|| (name.clone(), path.span))
            }
            _ => None,
        }
    }

    /// The use of a part that may have been meant by `name`.
    pub(super) fn near_use(&self, name: &str) -> Option<&str> {
        self.near(name, self.model.uses.iter().map(|used| &*used.name))
    }

    /// A path whose first name is no use of a part.
    pub(super) fn unknown_use<T>(&mut self, name: &str, place: Span) -> Option<T> {
        if self.unreadable_base || self.scope.is_unreadable(name) {
            return None;
        }
        let help = match self.near_use(name) {
            Some(near) => format!("did you mean `{near}`?"),
            None => {
                let uses = self.model.uses.iter().map(|used| &*used.name);
                format!("the uses are: {}", uses.collect::<Vec<_>>().join(", "))
            }
        };
        let message = format!("no use of a part is named `{name}`");
        self.report(Diagnostic::error(place, message).help(help))
    }

    pub(super) fn unknown_function(&mut self, name: &Name) -> Lowered {
        let error = Diagnostic::error(name.span, format!("there is no function `{}`", name.text));
        if MOMENTARY_VECTORS.contains(&name.text.as_str()) {
            self.refuse_outside_sensors(name)?;
        }
        let vectors = [&VECTORS[..], &MOMENTARY_VECTORS].concat();
        if vectors.contains(&name.text.as_str()) {
            let message = format!("`{}(…)` is a vector, not a number", name.text);
            let help = format!("take a component: `{}(…).x`", name.text);
            return self.report(Diagnostic::error(name.span, message).help(help));
        }
        if self.scope.has_name(&name.text) {
            let help = format!("a product is written with `*`: `{}*(…)`", name.text);
            return self.report(error.help(help));
        }
        if let Some((_, instead)) = NO_FUNCTIONS.iter().find(|(word, _)| *word == name.text) {
            return self.report(error.help(*instead));
        }
        if self.scope.is_unreadable(&name.text) {
            return None;
        }
        let tables = self.model.tables.iter().map(|table| table.name.as_str());
        let near = self.near(&name.text, tables).map(str::to_string);
        if let Some(near) = near {
            return self.report(error.help(format!("did you mean `{near}`?")));
        }
        let known = FUNCTIONS.map(|(known, _)| known);
        self.report(match nearest(&name.text, known) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help(format!("the functions are {}", known.join(", "))),
        })
    }
}
