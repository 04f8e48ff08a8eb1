//! Whether a body with these masses and inertias can exist.

use super::records::{LinkRecord, child};
use super::tree::Place;
use crate::diagnostic::Diagnostic;
use crate::robot::text::shown;
use crate::robot::xml::Places;
use crate::robot::{Format, Impossible, Inertia, Robot, merge_fixed};

/// The tree, as far as this check needs it.
pub(super) struct Tree {
    /// Index of the root link in the file.
    pub root: usize,
    /// For each link of the file the whole body that fixed joints make of it.
    pub wholes: Vec<Inertia>,
}

/// Checks the inertia of every link. A link that no body can have is an error,
/// unless fixed joints weld it to others and the whole is a possible body: only
/// the whole enters the equations. The root may be a mere frame, or have the mass
/// 0 that says in Bullet that it stands still: neither is worth a word.
pub(super) fn check_links(
    places: Places,
    links: &[LinkRecord],
    inertias: &[Inertia],
    tree: Option<&Tree>,
    findings: &mut Vec<Diagnostic>,
) {
    let root = tree.map(|tree| tree.root);
    if let Some(root) = root {
        report_massless(links, root, findings);
    }
    for (index, (link, inertia)) in links.iter().zip(inertias).enumerate() {
        let Some(element) = link
            .inertial
            .and_then(|inertial| child(inertial, "inertia"))
        else {
            continue;
        };
        let at = places.tag(element);
        let name = shown(link.name);
        if inertia.mass == 0.0 && !inertia.is_zero() && root != Some(index) {
            findings.push(
                Diagnostic::warning(
                    at,
                    format!("link `{name}` has rotational inertia but no mass"),
                )
                .label("no body is like that; the figures are used as they stand"),
            );
        }
        let Some(impossible) = Impossible::of(&inertia.tensor) else {
            continue;
        };
        let possible = |whole: &&Inertia| {
            Impossible::of(&whole.tensor).is_none_or(|found| found.rounding().is_some())
        };
        let whole = tree
            .map(|tree| &tree.wholes[index])
            .filter(|whole| *whole != inertia)
            .filter(possible);
        findings.push(impossible.finding(at, Format::Urdf, &name, whole.is_some()));
    }
}

/// One warning about all links without `<inertial>` but the root.
fn report_massless(links: &[LinkRecord], root: usize, findings: &mut Vec<Diagnostic>) {
    let massless: Vec<&LinkRecord> = links
        .iter()
        .enumerate()
        .filter(|(index, link)| link.inertial.is_none() && root != *index)
        .map(|(_, link)| link)
        .collect();
    let [first, rest @ ..] = &massless[..] else {
        return;
    };
    let message = match rest.len() {
        0 => format!(
            "link `{}` has no <inertial>: it counts as massless",
            shown(first.name)
        ),
        more => format!(
            "{} links have no <inertial>: they count as massless",
            more + 1
        ),
    };
    let mut warning = Diagnostic::warning(first.span, message);
    for link in rest.iter().take(4) {
        warning = warning.also(link.span, "");
    }
    if rest.len() > 4 {
        warning = warning.help(format!("{} more are not shown", rest.len() - 4));
    }
    findings.push(warning);
}

/// What [`check_links`] needs of the tree. `order` gives the links of the file in
/// the order of the robot's bodies.
pub(super) fn tree(robot: &Robot, order: &[Place]) -> Option<Tree> {
    let merged = merge_fixed(robot);
    let mut wholes = vec![Inertia::ZERO; order.len()];
    for (place, frame) in order.iter().zip(&merged.frames) {
        wholes[place.link] = merged.bodies[frame.body].inertia;
    }
    let root = order.first()?.link;
    Some(Tree { root, wholes })
}
