//! What the model may lack, all of it at once.

use crate::regression::Hold;

/// Candidates of the dictionary that are taken to be there, and what inputs do between samples.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Hypothesis {
    /// Ascending.
    candidates: Vec<usize>,
    /// What inputs do between samples.
    pub hold: Hold,
}

impl Hypothesis {
    /// The model as given.
    pub fn nothing(hold: Hold) -> Self {
        Self {
            candidates: Vec::new(),
            hold,
        }
    }

    /// Which candidates are there, ascending.
    pub fn candidates(&self) -> &[usize] {
        &self.candidates
    }

    /// Whether a candidate is there.
    pub fn contains(&self, candidate: usize) -> bool {
        self.candidates.binary_search(&candidate).is_ok()
    }

    /// Some terms in place of others.
    #[must_use]
    pub fn exchange(&self, out: &[usize], more: &[usize]) -> Self {
        let kept = self.candidates.iter().filter(|c| !out.contains(c));
        let mut candidates: Vec<usize> = kept.chain(more).copied().collect();
        candidates.sort_unstable();
        candidates.dedup();
        Self {
            candidates,
            hold: self.hold,
        }
    }

    /// The same terms with another assumption about inputs.
    #[must_use]
    pub fn held_otherwise(&self) -> Self {
        Self {
            hold: match self.hold {
                Hold::Linear => Hold::Previous,
                Hold::Previous => Hold::Linear,
            },
            ..self.clone()
        }
    }

    /// The one term that is here and not in `other`, and the one that is there in its place.
    pub fn differs_by_one(&self, other: &Self) -> Option<(usize, usize)> {
        let only = |a: &Self, b: &Self| -> Option<usize> {
            let mut own = a.candidates.iter().filter(|c| !b.contains(**c));
            own.next().copied().filter(|_| own.next().is_none())
        };
        let is_swap = self.candidates.len() == other.candidates.len() && self.hold == other.hold;
        is_swap.then(|| only(self, other).zip(only(other, self)))?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_a_set() {
        let nothing = Hypothesis::nothing(Hold::Linear);
        let one = nothing.exchange(&[], &[7]).exchange(&[], &[3]);
        assert_eq!(one, nothing.exchange(&[], &[3, 7, 3]));
        assert_eq!(one.exchange(&[7], &[9]).candidates(), [3, 9]);
        assert!(one.contains(3) && !one.contains(9));
    }

    #[test]
    fn a_swap_exchanges_one_term_for_one() {
        let given = Hypothesis::nothing(Hold::Linear).exchange(&[], &[1, 4]);
        let other = given.exchange(&[4], &[2]);
        assert_eq!(given.differs_by_one(&other), Some((4, 2)));
        assert_eq!(given.differs_by_one(&given), None);
        assert_eq!(given.differs_by_one(&given.exchange(&[4], &[])), None);
        assert_eq!(given.differs_by_one(&other.held_otherwise()), None);
        assert_eq!(
            given.differs_by_one(&given.exchange(&[1, 4], &[2, 3])),
            None
        );
    }
}
