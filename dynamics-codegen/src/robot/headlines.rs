//! What the tests of both readers look at of a report.

use crate::diagnostic::{Diagnostic, Report, Severity};

/// The severities and first lines of what was found in a text, in its order.
pub fn headlines(report: Report) -> Vec<String> {
    let mut found = report.diagnostics;
    found.sort_by_key(|d| d.primary.span.start);
    let line = |d: &Diagnostic| match d.severity {
        Severity::Error => format!("error: {}", d.message),
        Severity::Warning => format!("warning: {}", d.message),
    };
    found.iter().map(line).collect()
}
