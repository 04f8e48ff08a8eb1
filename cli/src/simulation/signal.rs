//! What the inputs do over time: a file's straight lines, and commands that are held.

use crate::inputs::Inputs;
use std::collections::VecDeque;

/// Times closer to one another than this share of an interval are one.
pub(super) const INSTANT: f64 = 1e-7;

/// Inputs as functions of time. Commands jump when they arrive; all else is continuous.
#[derive(Debug)]
pub struct Signal {
    open: Inputs,
    /// Which input each delayed one is of, and its delay, s.
    delays: Vec<(usize, f64)>,
    /// Which inputs are commanded.
    commanded: Vec<usize>,
    /// Commands with the times of their arrival, oldest first; as far back as a delay reaches.
    held: VecDeque<(f64, Vec<f64>)>,
    /// Times closer to one another than this are one, s.
    instant: f64,
}

/// On which side of a jump.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// As it was.
    Before,
    /// As it goes on.
    After,
}

impl Signal {
    /// Inputs that nobody commands; `delays` say of which input each delayed one is.
    pub fn open(open: Inputs, delays: Vec<(usize, f64)>) -> Self {
        Self {
            open,
            delays,
            commanded: Vec::new(),
            held: VecDeque::new(),
            instant: 0.0,
        }
    }

    /// With commands to these inputs, `interval` seconds apart.
    #[must_use]
    pub fn commanded(mut self, inputs: Vec<usize>, interval: f64) -> Self {
        (self.commanded, self.instant) = (inputs, INSTANT * interval);
        self
    }

    /// What the file says of an input, whoever else commands it.
    pub fn stated(&self, t: f64, input: usize) -> f64 {
        self.open.at(t)[input]
    }

    /// A command arrives, one value per commanded input.
    pub fn command(&mut self, t: f64, values: Vec<f64>) {
        self.held.push_back((t, values));
        let longest = self.delays.iter().fold(0.0_f64, |most, d| most.max(d.1));
        let needed = t - longest - 2.0 * self.instant;
        while self
            .held
            .get(1)
            .is_some_and(|(arrival, _)| *arrival < needed)
        {
            self.held.pop_front();
        }
    }

    /// The inputs at a time.
    pub fn inputs(&self, t: f64, side: Side) -> Vec<f64> {
        let mut values = self.open.at(t);
        let arrived = |arrival: f64| match side {
            Side::After => arrival <= t + self.instant,
            Side::Before => arrival < t - self.instant,
        };
        let last = self
            .held
            .iter()
            .rev()
            .find(|(arrival, _)| arrived(*arrival));
        if let Some((_, command)) = last {
            for (&input, value) in self.commanded.iter().zip(command) {
                values[input] = *value;
            }
        }
        values
    }

    /// The delayed inputs at a time.
    pub fn delayed(&self, t: f64, side: Side) -> Vec<f64> {
        let delays = self.delays.iter();
        delays
            .map(|&(input, tau)| self.inputs(t - tau, side)[input])
            .collect()
    }

    /// The inputs, then the delayed ones.
    pub fn all(&self, t: f64, side: Side) -> Vec<f64> {
        [self.inputs(t, side), self.delayed(t, side)].concat()
    }

    /// The first time behind `t` at which an input, delayed or not, may jump or change direction.
    pub fn next_corner(&self, t: f64) -> f64 {
        // Rounding must not find the same corner again.
        let behind = t + (1e-12 * (1.0 + t.abs())).max(2.0 * self.instant);
        let delays = self.delays.iter().map(|&(_, tau)| tau).chain([0.0]);
        let corner = |tau: f64| {
            let stated = self.open.next_corner(behind - tau);
            let arrivals = self.held.iter().map(|(arrival, _)| *arrival);
            let arrival = arrivals.into_iter().find(|arrival| arrival + tau > behind);
            let both = stated.into_iter().chain(arrival);
            both.fold(f64::INFINITY, f64::min) + tau
        };
        delays.map(corner).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_held_and_arrive_late() {
        let stated = Inputs::constant(vec![1.0, 2.0]);
        let mut signal = Signal::open(stated, vec![(1, 0.25)]).commanded(vec![1], 0.1);
        assert_eq!(signal.all(0.0, Side::After), [1.0, 2.0, 2.0]);
        signal.command(0.0, vec![5.0]);
        signal.command(0.1, vec![7.0]);
        assert_eq!(signal.all(0.1, Side::Before), [1.0, 5.0, 2.0]);
        assert_eq!(signal.all(0.1, Side::After), [1.0, 7.0, 2.0]);
        assert_eq!(signal.all(0.1 + 0.25, Side::Before), [1.0, 7.0, 5.0]);
        assert_eq!(signal.all(0.1 + 0.25, Side::After), [1.0, 7.0, 7.0]);
        assert_eq!(signal.next_corner(0.1), 0.25);
        assert!((signal.next_corner(0.25) - 0.35).abs() < 1e-15);
        assert_eq!(signal.next_corner(0.35), f64::INFINITY);
        signal.command(1.0, vec![0.0]);
        assert_eq!(signal.held.len(), 2, "what no delay reaches is forgotten");
    }
}
