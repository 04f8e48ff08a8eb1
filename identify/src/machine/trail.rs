//! What a machine remembers at samples and along the intervals between them.

/// Delayed inputs and states at some samples, in columns. Empty columns stand for a
/// machine at rest: inputs as they have always been, states as at the beginning.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Memory {
    /// `u(t − τ)`, one column per delay.
    pub delayed: Vec<Vec<f64>>,
    /// `u̇(t − τ)`, one column per delay.
    pub delay_rate: Vec<Vec<f64>>,
    /// `z`, one column per state.
    pub z: Vec<Vec<f64>>,
    /// `∂z/∂p`, one column per slope of the derivatives' tape it was made for.
    pub slopes: Vec<Vec<f64>>,
}

impl Memory {
    /// The samples in `range`.
    #[must_use]
    pub fn slice(&self, range: std::ops::Range<usize>) -> Self {
        let cut =
            |columns: &[Vec<f64>]| columns.iter().map(|c| c[range.clone()].to_vec()).collect();
        Self {
            delayed: cut(&self.delayed),
            delay_rate: cut(&self.delay_rate),
            z: cut(&self.z),
            slopes: cut(&self.slopes),
        }
    }

    /// All there is, in groups of columns.
    pub fn columns(&self) -> [&Vec<Vec<f64>>; 4] {
        [&self.delayed, &self.delay_rate, &self.z, &self.slopes]
    }

    /// Some of the samples.
    fn pick(&self, samples: &[usize]) -> Self {
        let column = |c: &Vec<f64>| samples.iter().map(|&k| c[k]).collect();
        let pick = |columns: &[Vec<f64>]| columns.iter().map(column).collect();
        Self {
            delayed: pick(&self.delayed),
            delay_rate: pick(&self.delay_rate),
            z: pick(&self.z),
            slopes: pick(&self.slopes),
        }
    }
}

/// Memory at the start, the middle and the end of every interval of a curve, and at its samples.
#[derive(Debug, Clone, Default)]
pub struct Trail {
    /// Per node, in this order.
    pub nodes: [Memory; 3],
    /// Delayed inputs at the samples.
    pub(super) momentary: Memory,
}

impl Trail {
    /// Over the intervals between some samples of the curve. Between two that are not neighbours
    /// nobody asks for the middle.
    pub(super) fn at(&self, samples: &[usize]) -> Self {
        let pairs = || samples.windows(2).map(|pair| (pair[0], pair[1] - 1));
        let starts: Vec<usize> = pairs().map(|(first, _)| first).collect();
        let ends: Vec<usize> = pairs().map(|(_, last)| last).collect();
        let [start, middle, end] = &self.nodes;
        Self {
            nodes: [start.pick(&starts), middle.pick(&starts), end.pick(&ends)],
            momentary: self.momentary.pick(samples),
        }
    }

    /// Memory at the samples: of a late input that stays at its values the mean over the interval behind.
    pub fn samples(&self) -> Memory {
        let [start, _, end] = &self.nodes;
        let extended = |columns: &[Vec<f64>], ends: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let pairs = columns.iter().zip(ends);
            let with_last = |(column, end): (&Vec<f64>, &Vec<f64>)| {
                column.iter().copied().chain(end.last().copied()).collect()
            };
            pairs.map(with_last).collect()
        };
        Memory {
            delayed: extended(&start.delayed, &end.delayed),
            delay_rate: extended(&start.delay_rate, &end.delay_rate),
            z: extended(&start.z, &end.z),
            slopes: extended(&start.slopes, &end.slopes),
        }
    }

    /// The same as what is read at the samples feels it: of a late input that stays at its values the
    /// present one.
    pub fn felt(&self) -> Memory {
        Memory {
            delayed: self.momentary.delayed.clone(),
            delay_rate: self.momentary.delay_rate.clone(),
            ..self.samples()
        }
    }

    /// Memory some shares of the way into intervals, straight from node to node.
    pub fn within(&self, intervals: &[usize], shares: &[f64]) -> Memory {
        let [start, middle, end] = &self.nodes;
        let mix = |of: fn(&Memory) -> &Vec<Vec<f64>>| {
            let nodes = of(start).iter().zip(of(middle)).zip(of(end));
            let column = |((a, b), c): ((&Vec<f64>, &Vec<f64>), &Vec<f64>)| {
                let at = |(&k, &share): (&usize, &f64)| match 2.0 * share {
                    early if early < 1.0 => a[k] + early * (b[k] - a[k]),
                    late => b[k] + (late - 1.0) * (c[k] - b[k]),
                };
                intervals.iter().zip(shares).map(at).collect()
            };
            nodes.map(column).collect()
        };
        Memory {
            delayed: mix(|m| &m.delayed),
            delay_rate: mix(|m| &m.delay_rate),
            z: mix(|m| &m.z),
            slopes: mix(|m| &m.slopes),
        }
    }
}
