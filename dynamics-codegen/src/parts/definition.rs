//! What is wrong with a part, whoever uses it.

use super::Expansion;
use super::rename::declared;
use crate::diagnostic::Diagnostic;
use crate::model::RESERVED;
use crate::syntax::{Name, PartStatement, Statement, StatementKind};

impl<'a> Expansion<'a, '_> {
    /// Takes up the parts of the model.
    pub(super) fn define(&mut self, statements: &'a [Statement]) {
        for statement in statements {
            let StatementKind::Part(part) = &statement.kind else {
                continue;
            };
            let first = self.parts.get(part.name.text.as_str());
            if let Some(first) = first.map(|first| first.name.span) {
                let message = format!("there are two parts named `{}`", part.name.text);
                let error = Diagnostic::error(part.name.span, message);
                self.report(error.also(first, "first here"));
                continue;
            }
            self.check_ports(part);
            self.parts.insert(&part.name.text, part);
        }
    }

    /// A port has one meaning, and hides nothing.
    fn check_ports(&mut self, part: &'a PartStatement) {
        let mut known: Vec<&Name> = Vec::new();
        for port in &part.ports {
            if let Some(first) = known.iter().find(|first| first.text == port.text) {
                let message = format!("`{}` is listed twice", port.text);
                let error = Diagnostic::error(port.span, message);
                self.report(error.also(first.span, "first here"));
            }
            known.push(port);
        }
        for statement in &part.statements {
            let Some(name) = declared(&statement.kind) else {
                continue;
            };
            if let Some(port) = known.iter().find(|port| port.text == name.text) {
                let message = format!("`{}` is given by the use of the part", name.text);
                let error = Diagnostic::error(name.span, message).label("and defined here");
                self.report(error.also(port.span, "given here"));
            }
            known.extend(RESERVED.contains(&name.text.as_str()).then_some(name));
        }
        for name in known {
            if RESERVED.contains(&name.text.as_str()) {
                let message = format!("`{}` has a meaning of its own", name.text);
                let help = "give it another name";
                self.report(Diagnostic::error(name.span, message).help(help));
            }
        }
    }

    /// What nothing uses is not looked at: that should be known.
    pub(super) fn warn_of_unused(&mut self) {
        let parts = self.parts.values();
        let unused = parts.filter(|part| !self.used.contains(part.name.text.as_str()));
        let warnings: Vec<Diagnostic> = unused
            .map(|part| {
                let name = &part.name;
                let message = format!("nothing uses the part `{}`", name.text);
                Diagnostic::warning(name.span, message)
                    .help(format!("use it: `use name = {}(…);`", name.text))
            })
            .collect();
        self.findings.extend(warnings);
    }
}
