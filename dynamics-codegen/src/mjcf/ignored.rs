//! What a description says that is not read.

use crate::diagnostic::Diagnostic;
use crate::source::Span;
use std::collections::BTreeMap;

/// How many kinds of things are named in one message.
const SHOWN: usize = 16;

/// Elements and attributes that are ignored, counted by what they are.
#[derive(Debug, Default)]
pub(super) struct Ignored {
    counts: BTreeMap<String, usize>,
    first: Option<Span>,
}

impl Ignored {
    /// One more of a kind, or several.
    pub fn add(&mut self, what: String, count: usize, at: Span) {
        *self.counts.entry(what).or_default() += count;
        self.first.get_or_insert(at);
    }

    /// One warning about all.
    pub fn report(&self) -> Option<Diagnostic> {
        let first = self.first?;
        let kind = |(what, count): (&String, &usize)| match count {
            1 => what.clone(),
            _ => format!("{what} ({count})"),
        };
        let mut kinds: Vec<String> = self.counts.iter().take(SHOWN).map(kind).collect();
        if self.counts.len() > SHOWN {
            kinds.push(format!("{} more", self.counts.len() - SHOWN));
        }
        let message = format!("ignored in this MJCF: {}", kinds.join(", "));
        Some(
            Diagnostic::warning(first, message)
                .label("the first")
                .help("read are bodies, joints, inertias, gravity and the gears of actuators; what else acts on them is written in a model: `mjcf \"…\";` and statements"),
        )
    }
}
