//! Faults of a part, told with the use in which they show.

use super::in_text;
use crate::diagnostic::{Diagnostic, Label};
use crate::source::Span;
use std::collections::HashSet;

/// Which uses read the parts of a model.
#[derive(Debug, Default)]
pub(crate) struct Readings(Vec<(String, Span)>);

impl Readings {
    /// Takes up a use, by its name and the place of that; what its reading is called.
    pub fn add(&mut self, name: &str, place: Span) -> usize {
        self.0.push((name.to_string(), place));
        self.0.len()
    }

    /// The uses that a reading lies in, that in the model itself first; none of the text as it stands.
    pub fn path(&self, reading: usize) -> Vec<&str> {
        let found = reading.checked_sub(1).and_then(|at| self.0.get(at));
        let Some((name, place)) = found else {
            return Vec::new();
        };
        let mut path = self.path(place.source.reading());
        path.push(name);
        path
    }

    /// Says of findings inside parts in which use they were made, and lets all places be those of
    /// the text. What several uses have in common is said once.
    pub fn explain(&self, findings: &mut Vec<Diagnostic>) {
        if self.0.is_empty() {
            return;
        }
        let mut said = HashSet::new();
        findings.retain_mut(|finding| {
            let place = finding.primary.span;
            let mut reading = place.source.reading();
            let common = reading > 0 && !said.insert((finding.severity as u8, in_text(place)));
            while let Some((name, span)) = reading.checked_sub(1).and_then(|at| self.0.get(at)) {
                finding.secondary.push(Label {
                    span: *span,
                    text: format!("in the use `{name}`"),
                });
                reading = span.source.reading();
            }
            finding.primary.span = in_text(place);
            for label in &mut finding.secondary {
                label.span = in_text(label.span);
            }
            !common
        });
    }
}
