//! One simulation, from its start to the last row of its log.

use super::gauges::{Gauges, Looks};
use super::mover::Mover;
use super::readings::Readings;
use super::signal::{INSTANT, Side};
use super::{Controller, Signal};
use crate::noise::Channel;
use crate::state::State;
use identify::machine::{Impact, Machine, Simulated};
use std::collections::VecDeque;

/// What moves, how it is driven, and how it is seen.
pub struct Run<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Its parameters.
    pub parameters: &'a [f64],
    /// Its inputs over time.
    pub signal: Signal,
    /// Who commands some of them, if anybody does.
    pub controller: Option<Controller>,
    /// Noise of the log's columns; a controller reads with the same.
    pub noise: Vec<Channel>,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Rows per second.
    pub rate: f64,
    /// The largest integration step, s.
    pub max_step: f64,
    /// Whether rows show the contacts' impulses.
    pub impulses: bool,
    /// Whether impacts are looked for at their instants.
    pub exact_impacts: bool,
}

impl Run<'_> {
    /// Simulates from `state` on and hands over `rows` rows: the time, then positions and velocities
    /// as their sensors read them, accelerations, inputs, what the `sensor` statements show and, if
    /// asked for, the impulses of the contacts since the row before; and the impacts since then, if they are exact.
    ///
    /// # Errors
    /// If the motion ends on the way, or a row is refused.
    pub fn rows(
        mut self,
        state: &State,
        rows: usize,
        mut seen: impl FnMut(f64, &[f64], &[Impact]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let mut mover = Mover::new(
            self.machine,
            self.parameters,
            self.max_step,
            self.exact_impacts,
        );
        let readings = Readings::new(self.machine, self.parameters);
        let column = |values: &[f64]| values.iter().map(|&value| vec![value]).collect();
        let mut simulated = Simulated {
            q: column(&state.q),
            v: column(&state.v),
            z: state.z.as_deref().map_or_else(Vec::new, column),
        };
        let model = &self.machine.compiled.model;
        let asking = self
            .controller
            .as_ref()
            .map(|control| 1.0 / control.interval);
        let looks = Looks {
            start: state.t,
            rates: std::iter::once(self.rate).chain(asking).collect(),
            leads: readings.leads(),
        };
        let mut gauges = Gauges::new(model, self.seed, &looks);
        if self.controller.is_some() {
            gauges.refuse_early(model)?;
        }
        let shortest = self
            .controller
            .as_ref()
            .map_or(f64::INFINITY, |c| c.interval);
        let shortest = shortest
            .min(gauges.shortest_interval())
            .min(1.0 / self.rate);
        // Rows, samples and readings closer than this are at one time.
        let instant = INSTANT * shortest;
        let (mut t, mut row, mut tick) = (state.t, 0, 0_u64);
        // Rows whose last reading is still to come.
        let mut waiting: VecDeque<(f64, Vec<f64>, Vec<Impact>)> = VecDeque::new();
        let patience = gauges.patience();
        while row < rows || !waiting.is_empty() {
            let next_row = match row < rows {
                true => state.t + row as f64 / self.rate,
                false => f64::INFINITY,
            };
            let interval = self.controller.as_ref().map(|control| control.interval);
            let next_tick = interval.map_or(f64::INFINITY, |h| state.t + tick as f64 * h);
            let next = next_row.min(next_tick).min(gauges.next());
            let (is_row, is_tick) = (next_row <= next + instant, next_tick <= next + instant);
            let next = if is_row { next_row } else { next };
            mover.advance(&mut simulated, &self.signal, t, next)?;
            t = next;
            // What a controller and the log see at one time has the same noise.
            let noise: Vec<f64> = match is_row || is_tick {
                true => self.noise.iter_mut().map(Channel::draw).collect(),
                false => Vec::new(),
            };
            let side = if is_tick { Side::Before } else { Side::After };
            let mut values = readings.at(&simulated, t, &self.signal, side)?;
            let first = values.len() - gauges.shown().count();
            gauges.read(t, instant, &values[first..]);
            if is_tick {
                values.truncate(first);
                let seen: Vec<f64> = noisy(values, &noise).chain(gauges.shown()).collect();
                self.sample(t, &seen);
                tick += 1;
                values = readings.at(&simulated, t, &self.signal, Side::After)?;
            }
            if is_row {
                values.truncate(noise.len());
                let shown = noisy(values, &noise).chain(gauges.shown());
                let impulses = mover.take_impulses().into_iter();
                let shown: Vec<f64> = match self.impulses {
                    true => shown.chain(impulses).collect(),
                    false => shown.collect(),
                };
                waiting.push_back((t, shown, mover.take_impacts()));
                row += 1;
            }
            while let Some((then, ..)) = waiting.front()
                && then + patience <= t + instant
                && let Some((then, mut shown, impacts)) = waiting.pop_front()
            {
                gauges.read_early(then, instant, &mut shown[self.noise.len()..]);
                seen(then, &shown, &impacts)?;
            }
        }
        Ok(())
    }

    /// The controller reads, and a command may arrive.
    fn sample(&mut self, t: f64, readings: &[f64]) {
        let Some(controller) = &mut self.controller else {
            return;
        };
        let inputs = controller.inputs.iter();
        let stated: Vec<f64> = inputs.map(|&u| self.signal.stated(t, u)).collect();
        if let Some(command) = controller.sample(t, readings, &stated) {
            self.signal.command(t, command);
        }
    }
}

/// Values with noise on those that have some: the first ones.
fn noisy(values: Vec<f64>, noise: &[f64]) -> impl Iterator<Item = f64> {
    let noise = noise.iter().copied().chain(std::iter::repeat(0.0));
    values
        .into_iter()
        .zip(noise)
        .map(|(value, noise)| value + noise)
}
