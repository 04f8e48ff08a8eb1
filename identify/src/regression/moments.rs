//! When sensors were read that are early or late.

use crate::log::segments;

/// When a coordinate's sensors were read, where that was not at the stamps: a reading shows the
/// motion next to another sample than the one it was logged with.
#[derive(Debug, Clone, Default)]
pub struct Moments {
    /// Per reading the sample next to which it was read; beyond either end of what is without a gap
    /// its last one.
    nearest: Vec<usize>,
    /// Seconds from that sample to the reading.
    after: Vec<f64>,
    /// The readings in order of these samples,
    order: Vec<usize>,
    /// and how many of them were read next to earlier samples than each, and than the end.
    begins: Vec<usize>,
    /// By how much what is read may be off, per reading, beside the sensor's noise; empty where that is known.
    doubt: Vec<f64>,
}

impl Moments {
    /// Of `n` readings that were made `ahead` seconds after their `n` stamps `t`, s, which increase.
    pub fn new(t: &[f64], ahead: &[f64]) -> Self {
        let mut moments = Self::default();
        for range in segments(t) {
            let stamps = &t[range.clone()];
            for k in range.clone() {
                let when = t[k] + ahead[k];
                let later = stamps.partition_point(|&stamp| stamp < when);
                let nearest = match (later.checked_sub(1), stamps.get(later)) {
                    (Some(earlier), Some(stamp)) if when - stamps[earlier] <= stamp - when => {
                        earlier
                    }
                    (Some(earlier), None) => earlier,
                    _ => later,
                };
                moments.nearest.push(range.start + nearest);
                moments.after.push(when - stamps[nearest]);
            }
        }
        moments.order = (0..t.len()).collect();
        moments
            .order
            .sort_by_key(|&reading| moments.nearest[reading]);
        let before = |sample| {
            let order = &moments.order;
            order.partition_point(|&reading| moments.nearest[reading] < sample)
        };
        moments.begins = (0..=t.len()).map(before).collect();
        moments
    }

    /// The readings that were made next to a sample.
    pub(super) fn at(&self, sample: usize) -> &[usize] {
        &self.order[self.begins[sample]..self.begins[sample + 1]]
    }

    /// The sample next to which each reading was made.
    pub fn nearest(&self) -> &[usize] {
        &self.nearest
    }

    /// The same where what is read may be off by so much, per reading.
    pub(super) fn with_doubt(self, doubt: Vec<f64>) -> Self {
        Self { doubt, ..self }
    }

    /// By how much what is read may be off, beside the sensor's noise.
    pub(super) fn doubt(&self, reading: usize) -> f64 {
        self.doubt.get(reading).copied().unwrap_or(0.0)
    }

    /// Seconds from there to a reading.
    pub(super) fn after(&self, reading: usize) -> f64 {
        self.after[reading]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reading_is_next_to_one_sample() {
        let t: Vec<f64> = (0..10).map(|k| 0.1 * f64::from(k)).collect();
        let late = Moments::new(&t, &[0.23; 10]);
        assert!(late.at(0).is_empty() && late.at(1).is_empty());
        assert_eq!(late.at(2), [0]);
        assert!((late.after(0) - 0.03).abs() < 1e-12);
        // What was read after the end counts there, so much later.
        assert_eq!(late.at(9), [7, 8, 9]);
        assert!((late.after(9) - 0.23).abs() < 1e-12);
        let early = Moments::new(&t, &[-0.23; 10]);
        assert_eq!(early.at(0), [0, 1, 2]);
        assert!((early.after(0) + 0.23).abs() < 1e-12);
        assert_eq!(early.nearest()[9], 7);
        // One that is drawn out has samples next to which nothing was read, and others.
        let ahead: Vec<f64> = t.iter().map(|t| 0.5 * t).collect();
        let drawn = Moments::new(&t, &ahead);
        let all: Vec<usize> = (0..10).flat_map(|k| drawn.at(k).to_vec()).collect();
        assert_eq!(all, (0..10).collect::<Vec<_>>());
    }

    #[test]
    fn no_reading_crosses_a_gap() {
        let t = [0.0, 0.1, 0.2, 0.3, 0.4, 9.0, 9.1, 9.2, 9.3, 9.4];
        let late = Moments::new(&t, &[0.2; 10]);
        assert_eq!(late.at(4), [2, 3, 4]);
        assert!(late.at(5).is_empty());
        assert_eq!(late.at(9), [7, 8, 9]);
    }
}
