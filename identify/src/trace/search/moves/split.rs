//! Two simple terms in the place of a rich one.
//!
//! Applies to a term with more parameters than two others of its place have together: Coulomb and
//! viscous friction, not Stribeck's.

use super::Move;
use crate::trace::search::explored::Explored;
use crate::trace::search::neighbourhood::Neighbourhood;
use crate::trace::search::proposal::Proposal;
use crate::trace::settings::EXCHANGED;

/// Two simple terms in the place of a rich one.
pub struct Split;

impl Move for Split {
    fn propose(&self, at: &Neighbourhood<'_>, _: &Explored) -> Vec<Proposal> {
        let of_term = |&term: &usize| at.splits(term).into_iter().take(EXCHANGED);
        let all = at.terms().iter().flat_map(of_term);
        all.map(|one| at.proposal(one)).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::trace::search::fit::fit;
    use crate::trace::search::hypothesis::Hypothesis;
    use crate::trace::search::neighbourhood::Neighbourhood;
    use crate::trace::wheel::{WHEEL, begun, named, turned};

    /// A wheel turned quickly, with viscous friction that hides its dry friction of 0.02 N·m but for narrow
    /// steps: alone in the place of both, dry friction would have to be as wide as all the motion.
    fn log() -> String {
        turned([(0.9, 3.0), (0.5, 7.0)], (3, 1e-4), |[_, v, a]| {
            0.02 * a + 0.1 * v + 0.02 * (v / 0.02).tanh()
        })
    }

    #[test]
    fn dry_friction_keeps_its_step_beside_viscous_friction() {
        let (dictionary, mut start) = begun(WHEEL, &log(), ["angle", "motor"]);
        let rich = named(&dictionary, "stribeck(angle)");
        // As a search would come to it: with some friction of each kind.
        for &strength in &dictionary.candidates[rich].strengths {
            start.values[strength] = 0.05;
        }
        let alone = Hypothesis::nothing(start.observed.hold).exchange(&[], &[rich]);
        let fitted = fit(&dictionary, &alone, start).unwrap();
        let at = Neighbourhood::new(&dictionary, &fitted, &[], false).unwrap();
        let splits = at.splits(rich);
        let best = splits.first().map(|split| split.instead.clone());
        let simple = ["coulomb(angle)", "viscous(angle)"].map(|name| named(&dictionary, name));
        assert_eq!(best, Some(simple.to_vec()));
    }
}
