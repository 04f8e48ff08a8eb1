//! Robot descriptions: what the formats have in common.
//!
//! ```text
//! URDF ──urdf──┐
//!              ├──▶ Robot ──lock, merge──▶ bodies of a model
//! MJCF ──mjcf──┘
//! ```
//!
//! A [`Robot`] is a tree of bodies and joints in plain numbers, with the places that messages
//! point at. The readers [`urdf`](crate::urdf) and [`mjcf`](crate::mjcf) make one of a text;
//! what follows (joints that stand still, welds, whether a body can exist and whether a joint
//! moves anything) is the same for both. The readers share `xml` and `value`, too: the text
//! as elements within bounds, and attributes as numbers.

mod body;
mod format;
#[cfg(test)]
pub(crate) mod headlines;
mod impossible;
mod lock;
mod merge;
mod mobility;
mod snap;
pub(crate) mod spatial;
pub(crate) mod text;
pub(crate) mod value;
pub(crate) mod xml;

pub use body::{
    Actuator, Body, Closure, ClosureKind, Frame, Joint, JointKind, Limits, Losses, Mimic, Robot,
    Spring, plane_basis,
};
pub use format::Format;
pub(crate) use impossible::{Impossible, MEND, excuse};
pub use lock::Lock;
pub(crate) use lock::lock;
pub use merge::merge_fixed;
pub(crate) use mobility::check_mobility;
pub use snap::Snapped;
pub use spatial::{IDENTITY, Inertia, Matrix3, Placement, Vector3};

use crate::diagnostic::Diagnostic;
use crate::file::Limit;

/// How large the file of a robot description may be.
pub const LIMIT: Limit = Limit {
    what: "a robot description",
    bytes: xml::MAX_BYTES as u64,
};

/// How many findings about one file are reported; of more, the first errors.
pub(crate) const MAX_FINDINGS: usize = 100;

/// How a robot description is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options<'a> {
    /// Entries of rotations and axes that are this near to 0 or ±1 are rounded
    /// to it; `None` leaves them as they are. At 1e-9, the default, an angle
    /// such as `1.57079632679` becomes a quarter turn; files with six or seven
    /// digits (`1.570796`) need 1e-6.
    pub snap: Option<f64>,
    /// Joints that stand still, welded at a position; those that mimic them stand still, too.
    pub locked: &'a [Lock],
    /// Whether an inertia that no body can have is a warning, and used as it stands.
    pub impossible: bool,
    /// Whether equalities beside the tree are read.
    pub equalities: bool,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            snap: Some(1e-9),
            locked: &[],
            impossible: false,
            equalities: false,
        }
    }
}

/// So many findings as anyone reads, errors before warnings.
pub(crate) fn shorten(mut findings: Vec<Diagnostic>) -> Vec<Diagnostic> {
    if findings.len() <= MAX_FINDINGS {
        return findings;
    }
    findings.sort_by_key(|f| (std::cmp::Reverse(f.severity), f.primary.span.start));
    let left_out = findings.len() - MAX_FINDINGS;
    findings.truncate(MAX_FINDINGS);
    if let Some(last) = findings.last_mut() {
        last.help.push(format!(
            "{left_out} more findings in this file are not shown"
        ));
    }
    findings
}
