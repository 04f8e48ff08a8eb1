//! Names of bodies, joints and actuators: MJCF leaves them out where nothing refers to them.

use crate::diagnostic::Diagnostic;
use crate::robot::text::shown;
use crate::source::Span;
use std::collections::BTreeMap;

/// Names of one kind of things, all different.
pub(super) struct Names {
    /// What the things are, all of them.
    kind: &'static str,
    taken: BTreeMap<String, Span>,
    /// For a name that was wished for the number to try next.
    next: BTreeMap<String, usize>,
}

impl Names {
    pub fn new(kind: &'static str) -> Self {
        Self {
            kind,
            taken: BTreeMap::new(),
            next: BTreeMap::new(),
        }
    }

    /// Notes a name that is stated. One that is doubled is reported.
    pub fn state(&mut self, name: &str, at: Span, findings: &mut Vec<Diagnostic>) {
        if let Some(&first) = self.taken.get(name) {
            let message = format!("two {} are called `{}`", self.kind, shown(name));
            let error = Diagnostic::error(at, message).label("the second");
            findings.push(error.also(first, "the first").help("rename one of them"));
            return;
        }
        self.taken.insert(name.to_string(), at);
    }

    pub fn is_taken(&self, name: &str) -> bool {
        self.taken.contains_key(name)
    }

    /// All that were stated or invented.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        self.taken.keys().map(String::as_str)
    }

    /// A name like `wish` that is not taken yet.
    pub fn invent(&mut self, wish: &str, at: Span) -> String {
        let next = self.next.entry(wish.to_string()).or_insert(1);
        let name = loop {
            let name = match *next {
                1 => wish.to_string(),
                number => format!("{wish}_{number}"),
            };
            *next += 1;
            if !self.taken.contains_key(&name) {
                break name;
            }
        };
        self.taken.insert(name.clone(), at);
        name
    }
}
