//! What an input does between its samples, and before the first one.

/// What the input does between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// Linear from one sample to the next.
    Linear,
    /// Stays at the earlier sample's value.
    Previous,
}

/// One input over a log. Before the log it is what it was at the beginning.
#[derive(Debug, Clone, Copy)]
pub struct Signal<'a> {
    /// Sampling instants, s, increasing.
    pub t: &'a [f64],
    /// The values there.
    pub u: &'a [f64],
    /// What happens in between.
    pub hold: Hold,
}

impl Signal<'_> {
    /// The sample at or in front of `t`; with `before`, strictly in front of it.
    fn sample(&self, t: f64, before: bool) -> Option<usize> {
        let count = if before {
            self.t.partition_point(|&x| x < t - self.slack())
        } else {
            self.t.partition_point(|&x| x <= t + self.slack())
        };
        count.checked_sub(1)
    }

    /// Times this close are the same: a difference of two of them is rounded.
    fn slack(&self) -> f64 {
        let last = self.t.last().copied().unwrap_or(0.0);
        1e-12 * (1.0 + last.abs())
    }

    /// Its value and its slope at `t`, coming from earlier or going on to later.
    fn linear(&self, t: f64, before: bool) -> (f64, f64) {
        let Some(k) = self.sample(t, before) else {
            return (self.u[0], 0.0);
        };
        if k + 1 == self.t.len() {
            return (self.u[k], 0.0);
        }
        let slope = (self.u[k + 1] - self.u[k]) / (self.t[k + 1] - self.t[k]);
        (self.u[k] + slope * (t - self.t[k]), slope)
    }

    /// Its value and its slope at `t`, where it jumps those after it: a value that stays has no slope.
    pub fn at(&self, t: f64) -> (f64, f64) {
        match self.hold {
            Hold::Linear => self.linear(t, false),
            Hold::Previous => (self.sample(t, false).map_or(self.u[0], |k| self.u[k]), 0.0),
        }
    }

    /// The value just in front of `t`.
    fn stays(&self, t: f64) -> f64 {
        self.sample(t, true).map_or(self.u[0], |k| self.u[k])
    }

    /// `∫ u` from the first sample to `t`, for a value that stays.
    fn integral(&self, from: f64, to: f64) -> f64 {
        let (mut sum, mut at) = (0.0, from);
        let mut next = self.t.partition_point(|&x| x <= from);
        while at < to {
            let end = self.t.get(next).map_or(to, |&x| x.min(to));
            let value = self.u[next.saturating_sub(1)];
            sum += value * (end - at);
            at = end;
            next += 1;
        }
        sum
    }

    /// `u(t − τ)` and `u̇(t − τ)` at the start, the middle and the end of the interval
    /// `from..to`.
    ///
    /// Of a value that stays, the mean over the interval: as a function of `τ` that has
    /// a slope, and the interval receives what it really receives.
    pub fn delayed(&self, from: f64, to: f64, tau: f64) -> [(f64, f64); 3] {
        match self.hold {
            Hold::Linear => [
                self.linear(from - tau, false),
                self.linear((from + to) / 2.0 - tau, false),
                self.linear(to - tau, true),
            ],
            Hold::Previous => {
                let mean = self.integral(from - tau, to - tau) / (to - from);
                let rate = (self.stays(to - tau) - self.stays(from - tau)) / (to - from);
                [(mean, rate); 3]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [f64; 4] = [0.0, 1.0, 2.0, 4.0];
    const U: [f64; 4] = [1.0, 3.0, -1.0, 0.0];

    #[test]
    fn a_linear_signal_is_interpolated_and_begins_at_rest() {
        let signal = Signal {
            t: &T,
            u: &U,
            hold: Hold::Linear,
        };
        let [start, middle, end] = signal.delayed(2.0, 4.0, 1.5);
        assert_eq!(start, (2.0, 2.0));
        assert_eq!(middle, (1.0, -4.0));
        assert!((end.0 + 0.75).abs() < 1e-15 && end.1 == 0.5);
        assert_eq!(signal.delayed(0.0, 1.0, 7.0), [(1.0, 0.0); 3]);
        // Without delay it is the signal itself, with the slope inside the interval.
        let [start, _, end] = signal.delayed(1.0, 2.0, 0.0);
        assert_eq!((start, end), ((3.0, -4.0), (-1.0, -4.0)));
    }

    #[test]
    fn a_value_that_stays_is_averaged_and_its_mean_has_a_slope() {
        let signal = Signal {
            t: &T,
            u: &U,
            hold: Hold::Previous,
        };
        let mean = |tau: f64| signal.delayed(1.0, 2.0, tau)[1].0;
        assert_eq!(mean(0.0), 3.0);
        assert!((mean(0.25) - (0.75 * 3.0 + 0.25)).abs() < 1e-15);
        let slope = |tau: f64| signal.delayed(1.0, 2.0, tau)[1].1;
        let difference = (mean(0.3) - mean(0.1)) / 0.2;
        assert!((slope(0.2) + difference).abs() < 1e-12);
        assert_eq!(slope(0.0), 2.0);
    }
}
