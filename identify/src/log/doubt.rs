//! Samples of inputs of which the log alone does not say whether they are measurements.

use super::Warning;
use std::ops::Range;

/// A sample of an input that its neighbours contradict, at a moment at which the machine moves as if it
/// were hit: a blow, or a wild sample beside quick motion. Which of the two, a model can say that
/// foretells the motion with either.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Doubt {
    /// Which of the record's inputs.
    pub input: usize,
    /// Which sample.
    pub sample: usize,
    /// What the neighbours say.
    pub beside: f64,
    /// What is to be said if it is no measurement.
    pub warning: Warning,
}

impl Doubt {
    fn at(&self, sample: usize) -> Self {
        Self {
            sample,
            ..self.clone()
        }
    }
}

/// Those at every `stride`-th sample, from the first on.
pub(super) fn thinned(doubts: &[Doubt], stride: usize) -> Vec<Doubt> {
    let kept = doubts.iter().filter(|d| d.sample.is_multiple_of(stride));
    kept.map(|d| d.at(d.sample / stride)).collect()
}

/// Those at the samples of some ranges, one after the other.
pub(super) fn stretches(doubts: &[Doubt], ranges: &[Range<usize>]) -> Vec<Doubt> {
    let mut from = 0;
    let mut kept = Vec::new();
    for range in ranges {
        let own = doubts.iter().filter(|d| range.contains(&d.sample));
        kept.extend(own.map(|d| d.at(from + d.sample - range.start)));
        from += range.len();
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubts_go_with_their_samples() {
        let doubt = |sample| Doubt {
            input: 0,
            sample,
            beside: 0.5,
            warning: Warning::StrangeRate { step: 1.0 },
        };
        let samples = |doubts: Vec<Doubt>| doubts.iter().map(|d| d.sample).collect::<Vec<_>>();
        let doubts = [doubt(4), doubt(7), doubt(12)];
        assert_eq!(samples(thinned(&doubts, 4)), [1, 3]);
        assert_eq!(samples(stretches(&doubts, &[3..6, 10..13])), [1, 5]);
    }
}
