//! What a machine remembers: inputs that arrive late and first-order states, along a
//! curve that is known.
//!
//! Along a measured curve `(q̂, v̂, u)` a state `z` follows from its own equation
//! `dz/dt = f(t, q̂, v̂, u, z)` alone, and so does `w = ∂z/∂p` for every parameter:
//! `dw/dt = ∂f/∂z·w + ∂f/∂p`. Both are integrated here, in half steps of the log, by an
//! exponential integrator of the second order. Where `f` is affine in `z` and free of the
//! other states, all samples are evaluated at once; the other states are taken from node
//! to node.

use super::exponential::step;
use super::hold::{Hold, Signal};
use super::trail::{Memory, Trail};
use super::{Machine, SensitivityTape, SolveError, States};
use crate::log::longest_step;
use dynamics_codegen::derive::Sensitivity;
use dynamics_codegen::graph::SymbolId;
use dynamics_codegen::{Column, Compiled, Model, Stepper, System, Tape};

/// The equations of a machine's memory.
#[derive(Debug, Clone)]
pub(super) struct Tapes {
    /// `f` of every state, then `∂fᵢ/∂zᵢ`.
    pub rates: Tape,
    /// `z` at the beginning.
    initial: Tape,
    /// `τ` of every delay, from parameters.
    delays: Tape,
    /// Which input each delay is of.
    inputs: Vec<usize>,
    /// Number of states.
    pub states: usize,
    /// States whose `f` is affine in themselves and free of the others.
    affine: Vec<usize>,
    /// The other states, and their `f` and `∂fᵢ/∂zᵢ`.
    marched: Vec<usize>,
    march: Tape,
}

/// The equations of `∂z/∂p`.
#[derive(Debug, Clone)]
pub(super) struct SlopeTapes {
    /// Which state each slope is of.
    pub states: Vec<usize>,
    /// `∂f/∂p`, with what other states owe.
    pub drives: Tape,
    /// `∂z/∂p` at the beginning.
    pub initial: Tape,
    /// Whether no state drives another's slope.
    pub uncoupled: bool,
}

impl SlopeTapes {
    /// `past`: the tape's arguments, with `u̇(t − τ)` and `∂z/∂p` at the end.
    pub fn new(model: &Model, sensitivity: &Sensitivity, past: &[SymbolId]) -> Self {
        let slopes = &sensitivity.memory;
        let drives: Vec<_> = slopes.iter().map(|slope| slope.drive).collect();
        let initial: Vec<_> = slopes.iter().map(|slope| slope.initial).collect();
        let driving = model.graph.symbols_in(&drives);
        Self {
            states: slopes.iter().map(|slope| slope.state).collect(),
            uncoupled: !slopes.iter().any(|slope| driving.contains(&slope.symbol)),
            drives: Tape::new(&model.graph, &drives, past),
            initial: Tape::new(&model.graph, &initial, past),
        }
    }
}

/// Repetitions at most where slopes drive each other, and the change that counts as
/// standing still.
const REPETITIONS: usize = 60;
const STILL: f64 = 1e-11;

impl Tapes {
    /// `None` if the model remembers nothing.
    pub fn new(compiled: &mut Compiled) -> Option<Self> {
        let model = &mut compiled.model;
        if model.states.is_empty() && model.delays.is_empty() {
            return None;
        }
        let arguments = System::arguments(model);
        let mut outputs = compiled.system.state_rates.clone();
        let (mut affine, mut marched) = (Vec::new(), Vec::new());
        for index in 0..model.states.len() {
            let (rate, own) = (
                compiled.system.state_rates[index],
                model.states[index].symbol,
            );
            let slope = model.graph.derivatives(&[rate], own)[0];
            let bent = model.graph.depends_on(&[slope], own);
            let mut others = model.states.iter().filter(|z| z.symbol != own);
            if bent || others.any(|z| model.graph.depends_on(&[rate], z.symbol)) {
                marched.push(index);
            } else {
                affine.push(index);
            }
            outputs.push(slope);
        }
        let count = model.states.len();
        let mut of_marched: Vec<_> = marched.iter().map(|&z| outputs[z]).collect();
        of_marched.extend(marched.iter().map(|&z| outputs[count + z]));
        let by: Vec<_> = model.delays.iter().map(|d| d.by).collect();
        let parameters: Vec<_> = model.parameters.iter().map(|p| p.symbol).collect();
        Some(Self {
            rates: Tape::new(&model.graph, &outputs, &arguments),
            initial: Tape::new(&model.graph, &compiled.system.initial_states, &arguments),
            delays: Tape::new(&model.graph, &by, &parameters),
            inputs: model.delays.iter().map(|d| d.input).collect(),
            states: count,
            affine,
            march: Tape::new(&model.graph, &of_marched, &arguments),
            marched,
        })
    }
}

impl Machine {
    /// Number of states.
    pub fn state_count(&self) -> usize {
        self.memory.as_ref().map_or(0, |tapes| tapes.states)
    }

    /// Whether it has delayed inputs or states.
    pub fn remembers(&self) -> bool {
        self.memory.is_some()
    }

    /// The delayed inputs: which input each is of, and by how much, s.
    pub fn delays(&self, parameters: &[f64]) -> Vec<(usize, f64)> {
        let Some(tapes) = &self.memory else {
            return Vec::new();
        };
        let delays = tapes.delays.evaluate(parameters);
        let later = delays.into_iter().map(|tau| tau.max(0.0));
        tapes.inputs.iter().copied().zip(later).collect()
    }

    /// States at the beginning of a motion that begins at `states`.
    pub fn initial_states(&self, states: &States, parameters: &[f64]) -> Vec<Vec<f64>> {
        let Some(tapes) = &self.memory else {
            return Vec::new();
        };
        let mut at = states.clone();
        at.memory = self.past_at_rest(states);
        at.memory.z = vec![vec![0.0; states.len()]; tapes.states];
        tapes
            .initial
            .evaluate_all(&at.columns(parameters), at.len())
    }

    /// `dz/dt` of every state, then the derivative of each by itself.
    pub(super) fn state_rates(&self, states: &States, parameters: &[f64]) -> Vec<Vec<f64>> {
        match &self.memory {
            Some(tapes) if tapes.states > 0 => tapes
                .rates
                .evaluate_all(&states.columns(parameters), states.len()),
            _ => Vec::new(),
        }
    }

    fn past_at_rest(&self, states: &States) -> Memory {
        let inputs = self.memory.as_ref().map_or(&[][..], |tapes| &tapes.inputs);
        Memory {
            delayed: inputs
                .iter()
                .map(|&input| states.u[input].clone())
                .collect(),
            delay_rate: vec![vec![0.0; states.len()]; inputs.len()],
            ..Memory::default()
        }
    }

    /// The same states with what is not said about their past filled in: inputs as they
    /// have always been, the machine's states as at the beginning.
    #[must_use]
    pub fn at_rest(&self, states: &States, parameters: &[f64]) -> States {
        let completed = self.completed(states, parameters);
        completed.unwrap_or_else(|| states.clone())
    }

    /// [`at_rest`](Self::at_rest), or `None` where nothing is missing.
    pub(super) fn completed(&self, states: &States, parameters: &[f64]) -> Option<States> {
        let tapes = self.memory.as_ref()?;
        let memory = &states.memory;
        let (late, kept) = (tapes.inputs.len(), tapes.states);
        if memory.delayed.len() == late && memory.z.len() == kept {
            return None;
        }
        let mut all = states.clone();
        if memory.delayed.len() != late {
            let rest = self.past_at_rest(states);
            (all.memory.delayed, all.memory.delay_rate) = (rest.delayed, rest.delay_rate);
        }
        if memory.z.len() != kept {
            all.memory.z = self.initial_states(states, parameters);
        }
        Some(all)
    }

    /// The curve with what the machine remembers at every sample of it.
    ///
    /// # Errors
    /// If a state's equation has no solution along the curve.
    pub fn remember(
        &self,
        curve: &States,
        hold: Hold,
        parameters: &[f64],
    ) -> Result<States, SolveError> {
        let mut all = curve.clone();
        if !self.remembers() || curve.len() < 2 {
            return Ok(self.completed(curve, parameters).unwrap_or(all));
        }
        all.memory = self.trail(curve, hold, parameters, None)?.samples();
        Ok(all)
    }

    /// The same as accelerometers feel it: a late input that is held counts by what it is at the sample, not
    /// by its mean behind it.
    ///
    /// # Errors
    /// As there.
    pub fn felt(
        &self,
        curve: &States,
        hold: Hold,
        parameters: &[f64],
    ) -> Result<States, SolveError> {
        if !self.remembers() || curve.len() < 2 {
            return self.remember(curve, hold, parameters);
        }
        Ok(States {
            memory: self.trail(curve, hold, parameters, None)?.felt(),
            ..curve.clone()
        })
    }

    /// Inputs over the intervals of a log as [`Rollout::advance`](super::Rollout::advance)
    /// takes them, with the delayed ones: what is there at the start and at the end of
    /// each interval, one column per input.
    pub fn inputs_over(
        &self,
        t: &[f64],
        u: &[Vec<f64>],
        hold: Hold,
        parameters: &[f64],
    ) -> [Vec<Vec<f64>>; 2] {
        let intervals = t.len().saturating_sub(1);
        let shifted = |by: usize| -> Vec<Vec<f64>> {
            let cut = |u: &Vec<f64>| u[by..by + intervals].to_vec();
            u.iter().map(cut).collect()
        };
        let end = usize::from(hold == Hold::Linear);
        let (mut start, mut end) = (shifted(0), shifted(end));
        let [first, _, last] = self
            .late((t, u), t, hold, parameters)
            .map(|memory| memory.delayed);
        start.extend(first);
        end.extend(last);
        [start, end]
    }

    /// Delayed inputs over the intervals between the instants `along`; `t` and `u` say what
    /// the inputs were.
    fn late(
        &self,
        (t, u): (&[f64], &[Vec<f64>]),
        along: &[f64],
        hold: Hold,
        parameters: &[f64],
    ) -> [Memory; 3] {
        let mut nodes: [Memory; 3] = Default::default();
        for (input, tau) in self.delays(parameters) {
            let signal = Signal {
                t,
                u: &u[input],
                hold,
            };
            let values: Vec<[(f64, f64); 3]> = along
                .windows(2)
                .map(|ends| signal.delayed(ends[0], ends[1], tau))
                .collect();
            for (node, memory) in nodes.iter_mut().enumerate() {
                memory
                    .delayed
                    .push(values.iter().map(|v| v[node].0).collect());
                memory
                    .delay_rate
                    .push(values.iter().map(|v| v[node].1).collect());
            }
        }
        nodes
    }

    /// Delayed inputs at the instants `along`; `t` and `u` say what the inputs were.
    fn momentary(
        &self,
        (t, u): (&[f64], &[Vec<f64>]),
        along: &[f64],
        hold: Hold,
        parameters: &[f64],
    ) -> Memory {
        let mut momentary = Memory::default();
        for (input, tau) in self.delays(parameters) {
            let u = &u[input];
            let signal = Signal { t, u, hold };
            let (values, rates) = along.iter().map(|&at| signal.at(at - tau)).unzip();
            momentary.delayed.push(values);
            momentary.delay_rate.push(rates);
        }
        momentary
    }

    /// Memory along a curve, with the slopes that `tape` asks for.
    ///
    /// # Errors
    /// If a state's equation has no solution along the curve.
    pub fn trail(
        &self,
        curve: &States,
        hold: Hold,
        parameters: &[f64],
        tape: Option<&SensitivityTape>,
    ) -> Result<Trail, SolveError> {
        let Some(tapes) = &self.memory else {
            return Ok(Trail::default());
        };
        // A stretch of a log begins with what the machine remembers of the time before.
        if tapes.states > 0
            && let Some((whole, places)) = curve.led()
        {
            return Ok(self.trail(&whole, hold, parameters, tape)?.at(&places));
        }
        let (t, u) = match &curve.history {
            Some(history) => (&history.t, &history.u),
            None => (&curve.t, &curve.u),
        };
        let memories = self.late((t, u), &curve.t, hold, parameters);
        let intervals = 0..curve.len() - 1;
        let longest = longest_step(&curve.t);
        let shares = [0.0, 0.5, 1.0];
        let mut nodes = [0, 1, 2].map(|node| {
            let mut states = curve.between(intervals.clone(), shares[node], hold, longest);
            states.memory = memories[node].clone();
            states
        });
        let mut beginning = nodes[0].slice(0..1);
        beginning.memory.z.clear();
        let mut beginning = self.completed(&beginning, parameters).unwrap_or(beginning);
        for (z, state) in beginning
            .memory
            .z
            .iter_mut()
            .zip(&self.compiled.model.states)
        {
            z[0] += curve.begun.get(&state.name).copied().unwrap_or(0.0);
        }
        let path = Path {
            tapes,
            parameters,
            t: &curve.t,
        };
        path.integrate(&mut nodes, &beginning)?;
        if let Some(slopes) = tape.and_then(|tape| tape.slopes.as_ref()) {
            path.slopes(&mut nodes, &beginning, slopes)?;
        }
        Ok(Trail {
            nodes: nodes.map(|states| states.memory),
            momentary: self.momentary((t, u), &curve.t, hold, parameters),
        })
    }
}

/// A curve along which memory is integrated.
struct Path<'a> {
    tapes: &'a Tapes,
    parameters: &'a [f64],
    t: &'a [f64],
}

impl Path<'_> {
    /// Fills `z` in at the nodes.
    fn integrate(&self, nodes: &mut [States; 3], beginning: &States) -> Result<(), SolveError> {
        let start: Vec<f64> = beginning.memory.z.iter().map(|z| z[0]).collect();
        let intervals = self.t.len() - 1;
        for states in nodes.iter_mut() {
            states.memory.z = start.iter().map(|&z| vec![z; intervals]).collect();
        }
        if !self.tapes.affine.is_empty() {
            self.sweep(&start, nodes);
        }
        if !self.tapes.marched.is_empty() {
            self.march(start, nodes);
        }
        let finite = |states: &States| states.memory.z.iter().flatten().all(|z| z.is_finite());
        if nodes.iter().all(finite) {
            Ok(())
        } else {
            Err(SolveError::NotFinite { sample: 0 })
        }
    }

    /// Integrates the affine states, all at once: anywhere `f = c + J z`.
    fn sweep(&self, start: &[f64], nodes: &mut [States; 3]) {
        let count = start.len();
        let rates = [0, 1, 2].map(|node: usize| {
            let states = &nodes[node];
            let columns = states.columns(self.parameters);
            self.tapes.rates.evaluate_all(&columns, states.len())
        });
        for &state in &self.tapes.affine {
            let mut z = start[state];
            for k in 0..self.t.len() - 1 {
                let half = (self.t[k + 1] - self.t[k]) / 2.0;
                let line = |node: usize| {
                    let slope = rates[node][count + state][k];
                    (rates[node][state][k] - slope * start[state], slope)
                };
                let ends = [line(0), line(1), line(2)];
                let middle = between(z, ends[0], ends[1], half);
                let end = between(middle, ends[1], ends[2], half);
                for (states, new) in nodes.iter_mut().zip([z, middle, end]) {
                    states.memory.z[state][k] = new;
                }
                z = end;
            }
        }
    }

    /// Integrates the other states, from node to node. Each step is linearised where it
    /// begins, with the slope of that end at which the state decays faster: a corner of
    /// `f` inside the step does no harm.
    fn march(&self, mut z: Vec<f64>, nodes: &mut [States; 3]) {
        let marched = &self.tapes.marched;
        let count = marched.len();
        let mut stepper = Stepper::new(&self.tapes.march);
        let mut arguments = vec![0.0; self.tapes.march.input_count() - self.parameters.len()];
        arguments.extend(self.parameters);
        let [mut here, mut there] = [(); 2].map(|()| vec![0.0; 2 * count]);
        for k in 0..self.t.len() - 1 {
            let half = (self.t[k + 1] - self.t[k]) / 2.0;
            for node in 0..3 {
                if node > 0 {
                    self.arguments(&nodes[node - 1], k, &z, &mut arguments);
                    stepper.step(&arguments, &mut here);
                    self.arguments(&nodes[node], k, &z, &mut arguments);
                    stepper.step(&arguments, &mut there);
                    for (place, &state) in marched.iter().enumerate() {
                        let slope = here[count + place].min(there[count + place]);
                        let [first, last] =
                            [here[place], there[place]].map(|rate| rate - slope * z[state]);
                        z[state] = step(z[state], slope, first, last, half);
                    }
                }
                for &state in marched {
                    nodes[node].memory.z[state][k] = z[state];
                }
            }
        }
    }

    /// Writes a tape's inputs at one sample, before the parameters; the marched states are those in `z`.
    fn arguments(&self, states: &States, sample: usize, z: &[f64], arguments: &mut [f64]) {
        let memory = &states.memory;
        let groups = [&states.q, &states.v, &states.u, &memory.delayed, &memory.z];
        let values = groups.into_iter().flatten().map(|column| column[sample]);
        let values = std::iter::once(states.t[sample]).chain(values);
        for (place, value) in arguments.iter_mut().zip(values) {
            *place = value;
        }
        let first = arguments.len() - self.parameters.len() - z.len();
        for &state in &self.tapes.marched {
            arguments[first + state] = z[state];
        }
    }

    /// Fills `∂z/∂p` in at the nodes.
    fn slopes(
        &self,
        nodes: &mut [States; 3],
        beginning: &States,
        slopes: &SlopeTapes,
    ) -> Result<(), SolveError> {
        let count = slopes.states.len();
        let intervals = self.t.len() - 1;
        for states in nodes.iter_mut() {
            states.memory.slopes = vec![vec![0.0; intervals]; count];
        }
        if count == 0 {
            return Ok(());
        }
        let first = slopes
            .initial
            .evaluate_all(&columns_with_slopes(beginning, self.parameters, count), 1);
        let jacobians = [0, 1, 2].map(|node: usize| {
            let columns = nodes[node].columns(self.parameters);
            self.tapes.rates.evaluate_all(&columns, intervals)
        });
        let passes = if slopes.uncoupled { 1 } else { REPETITIONS };
        for _ in 0..passes {
            let drives = [0, 1, 2].map(|node: usize| {
                let columns = columns_with_slopes(&nodes[node], self.parameters, count);
                slopes.drives.evaluate_all(&columns, intervals)
            });
            let mut change = 0.0_f64;
            for slope in 0..count {
                let jacobian = self.tapes.states + slopes.states[slope];
                let mut w = first[slope][0];
                for k in 0..intervals {
                    let half = (self.t[k + 1] - self.t[k]) / 2.0;
                    let line = |node: usize| (drives[node][slope][k], jacobians[node][jacobian][k]);
                    let ends = [line(0), line(1), line(2)];
                    let middle = between(w, ends[0], ends[1], half);
                    let end = between(middle, ends[1], ends[2], half);
                    for (states, new) in nodes.iter_mut().zip([w, middle, end]) {
                        let old = &mut states.memory.slopes[slope][k];
                        change = worst(change, (new - *old).abs() / (1.0 + new.abs()));
                        *old = new;
                    }
                    w = end;
                }
            }
            if !change.is_finite() {
                return Err(SolveError::NotFinite { sample: 0 });
            }
            if slopes.uncoupled || change < STILL {
                return Ok(());
            }
        }
        Err(SolveError::Unsettled { sample: 0 })
    }
}

/// The larger one; what is no number stays none.
fn worst(a: f64, b: f64) -> f64 {
    if b.is_nan() { b } else { a.max(b) }
}

/// A tape's inputs where it also takes `u̇(t − τ)` and `∂z/∂p` (zero if not given).
pub(super) fn columns_with_slopes<'a>(
    states: &'a States,
    parameters: &'a [f64],
    count: usize,
) -> Vec<Column<'a>> {
    let mut columns = states.columns(parameters);
    let memory = &states.memory;
    columns.extend(memory.delay_rate.iter().map(|c| Column::Each(c.as_slice())));
    if memory.slopes.len() == count {
        columns.extend(memory.slopes.iter().map(|c| Column::Each(c.as_slice())));
    } else {
        columns.extend(std::iter::repeat_n(Column::Same(0.0), count));
    }
    columns
}

/// A step of `dz/dt = c + J z` between two places, each with its `(c, J)`.
fn between(z: f64, (c0, j0): (f64, f64), (c1, j1): (f64, f64), h: f64) -> f64 {
    let jacobian = (j0 + j1) / 2.0;
    step(
        z,
        jacobian,
        c0 + (j0 - jacobian) * z,
        c1 + (j1 - jacobian) * z,
        h,
    )
}
