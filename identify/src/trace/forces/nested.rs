//! Laws that are special cases of others: a joint has one law of each kind.

use crate::regression::Gram;
use crate::trace::dictionary::Dictionary;
use crate::trace::screen::ShapedCandidate;
use std::collections::BTreeSet;

/// Squared multiple correlation from which a law is in another.
const CONTAINED: f64 = 0.999;

/// Candidates of one place, in pairs, that are one law in two shapes: one does in some shape what the
/// other does, or both do what a third does. Friction that differs by direction is Coulomb's where it
/// does not differ, and so is Stribeck's where breaking away takes no more than sliding.
pub(super) fn nested(
    dictionary: &Dictionary,
    options: &[ShapedCandidate],
    (gram, visible): (&Gram, &[bool]),
) -> BTreeSet<(usize, usize)> {
    let columns = |option: &ShapedCandidate| -> Vec<usize> {
        let own = option.columns.iter().copied();
        own.filter(|&column| visible[column]).collect()
    };
    let on = |option: &ShapedCandidate| dictionary.candidates[option.candidate].subject.on();
    let mut contained = BTreeSet::new();
    for special in options.iter().filter(|option| option.shape == 0) {
        let place = on(special);
        let own = columns(special);
        let others = options
            .iter()
            .filter(|other| other.candidate != special.candidate && on(other) == place);
        for other in others {
            let theirs = columns(other);
            let pair = (special.candidate, other.candidate);
            if own.is_empty() || theirs.len() < own.len() || contained.contains(&pair) {
                continue;
            }
            let part = gram.part(&[&theirs[..], &own].concat());
            let base: Vec<usize> = (0..theirs.len()).collect();
            let is_in = |i: usize| part.explained_by(theirs.len() + i, &base) > CONTAINED;
            if (0..own.len()).all(is_in) {
                contained.insert(pair);
            }
        }
    }
    let ordered = |(a, b): (usize, usize)| (a.min(b), a.max(b));
    let siblings = contained.iter().flat_map(|&(special, a)| {
        let others = contained.range((special, a + 1)..(special + 1, 0));
        others.map(move |&(_, b)| (a, b))
    });
    let nested = contained.iter().copied();
    nested.chain(siblings).map(ordered).collect()
}

#[cfg(test)]
mod tests {
    use crate::trace::forces::balance::Balance;
    use crate::trace::forces::equations::Equations;
    use crate::trace::forces::{columns, force_options, nested::nested};
    use crate::trace::wheel::{WHEEL, begun, named, rectangular};
    use std::fmt::Write;

    #[test]
    fn a_joint_has_one_law_of_dry_friction() {
        let mut text = String::from("t,q_angle,u_motor\n");
        let mut noise = rectangular(6);
        for k in 0..1500 {
            let t = 0.005 * f64::from(k);
            let (q, a) = ((3.0 * t).sin(), -9.0 * (3.0 * t).sin());
            writeln!(text, "{t},{},{}", q + 1e-5 * noise(), 0.02 * a).unwrap();
        }
        let (dictionary, start) = begun(WHEEL, &text, ["angle", "motor"]);
        let observed = &start.observed;
        let balance = Balance::new(&observed.record, observed.hold).unwrap();
        let machine = &dictionary.machine;
        let missing = balance.missing(machine, &dictionary.defaults).unwrap();
        let columns = columns(&dictionary, &balance).unwrap();
        let equations = Equations::new(&missing, &columns);
        let options = force_options(&dictionary);
        let known = (&equations.gram(), &equations.visible()[..]);
        let pairs = nested(&dictionary, &options, known);
        let is_one = |a: &str, b: &str| {
            let [a, b] = [a, b].map(|name| named(&dictionary, &format!("{name}(angle)")));
            pairs.contains(&(a.min(b), a.max(b)))
        };
        assert!(is_one("coulomb", "asymmetric_coulomb") && is_one("viscous", "stribeck"));
        // Neither is the other, but both are Coulomb's.
        assert!(is_one("stribeck", "asymmetric_coulomb"));
        assert!(!is_one("coulomb", "viscous") && !is_one("viscous", "spring"));
    }
}
