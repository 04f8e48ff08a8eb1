//! `delay(u, tau)`: an input as it was some time ago.
//!
//! On the graph it is a variable of its own, `u(t − τ)`, with a second one for the rate
//! `u̇(t − τ)` that derivatives by `τ` need. Whoever evaluates the model has the input's
//! past and gives both their values.

use super::Model;
use super::builder::{Builder, MAX_SIZE};
use super::quantity::Quantity;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::{ExprId, SymbolId};
use crate::source::Span;
use crate::syntax::{Expr, ExprKind, Name};
use std::collections::HashMap;

/// An input as it was some time ago.
#[derive(Debug, Clone)]
pub struct Delay {
    /// A name for people and for generated code: `<input>_delayed`, numbered if there are
    /// several.
    pub name: String,
    /// Index of the input.
    pub input: usize,
    /// How long ago, s: a function of parameters, not negative.
    pub by: ExprId,
    /// `u(t − τ)`, as commanded.
    pub symbol: SymbolId,
    /// `u̇(t − τ)`: stands in derivatives by parameters only.
    pub rate: SymbolId,
}

impl Model {
    /// The inputs' variables, then those of the delayed inputs.
    pub fn input_symbols(&self) -> Vec<SymbolId> {
        let inputs = self.inputs.iter().map(|u| u.symbol);
        inputs.chain(self.delays.iter().map(|d| d.symbol)).collect()
    }

    /// What follows a parameter beside itself: `∂u(t − τ)/∂p = −u̇(t − τ)·∂τ/∂p`.
    pub fn parameter_seeds(&mut self, parameter: SymbolId) -> Vec<(SymbolId, ExprId)> {
        let mut seeds = vec![(parameter, self.graph.one())];
        for index in 0..self.delays.len() {
            let Delay {
                by, symbol, rate, ..
            } = self.delays[index];
            let slope = self.graph.derivatives(&[by], parameter)[0];
            if !self.graph.is_zero(slope) {
                let rate = self.graph.var(rate);
                let change = self.graph.mul(rate, slope);
                seeds.push((symbol, self.graph.neg(change)));
            }
        }
        seeds
    }
}

impl Builder<'_> {
    /// `delay(u, tau)`.
    pub(super) fn lower_delay(&mut self, of: &Expr, by: &Expr) -> Option<Quantity> {
        let index = self.delayed_input(of)?;
        let quantity = self.lower(by)?;
        self.expect_dimension(quantity, Dimension::TIME, by.span, "a delay")?;
        let graph = &self.model.graph;
        if graph
            .as_constant(quantity.expr)
            .is_some_and(|tau| tau < 0.0)
        {
            return self.report(Diagnostic::error(by.span, "a delay is not negative"));
        }
        let parameters = self.model.parameters.iter().map(|p| p.symbol);
        let allowed: Vec<SymbolId> = parameters.collect();
        let mut nodes = graph.reachable(&[quantity.expr]).iter().collect::<Vec<_>>();
        nodes.retain(|&expr| match graph.node(expr) {
            crate::graph::Node::Symbol(symbol) => !allowed.contains(&symbol),
            _ => false,
        });
        if !nodes.is_empty() {
            return self.report(
                Diagnostic::error(by.span, "a delay depends on parameters only")
                    .label("this changes with time"),
            );
        }
        let mut result = self.input_symbol(index)?;
        if !self.model.graph.is_zero(quantity.expr) {
            let symbol = self.delay_symbol(index, quantity.expr, by.span)?;
            result.expr = self.model.graph.var(symbol);
        }
        Some(result)
    }

    fn delayed_input(&mut self, of: &Expr) -> Option<usize> {
        let name = match &of.kind {
            ExprKind::Name(name) => Some((name, of.span)),
            ExprKind::Call(function, arguments) if function.text == "input" => {
                match arguments.as_slice() {
                    [
                        Expr {
                            kind: ExprKind::Name(name),
                            span,
                        },
                    ] => Some((name, *span)),
                    _ => None,
                }
            }
            _ => None,
        };
        match name {
            Some((text, span)) => self.find_input(&Name {
                text: text.clone(),
                span,
            }),
            None => self.report(
                Diagnostic::error(of.span, "`delay` takes the name of one input first")
                    .help("delay inputs one by one: `delay(u, tau) - delay(w, tau)`"),
            ),
        }
    }

    /// The variable `u(t − by)`, made if it is new.
    fn delay_symbol(&mut self, input: usize, by: ExprId, span: Span) -> Option<SymbolId> {
        let mut delays = self.model.delays.iter();
        if let Some(known) = delays.find(|d| d.input == input && d.by == by) {
            return Some(known.symbol);
        }
        if self.model.delays.len() == MAX_SIZE {
            let message = format!("the model delays its inputs in more than {MAX_SIZE} ways");
            return self.report(Diagnostic::error(span, message));
        }
        let of = &self.model.inputs[input].name;
        let count = self
            .model
            .delays
            .iter()
            .filter(|d| d.input == input)
            .count();
        let name = match count {
            0 => format!("{of}_delayed"),
            n => format!("{of}_delayed_{}", n + 1),
        };
        let symbol = self.model.graph.symbol(format!("u_{name}"));
        let rate = self.model.graph.symbol(format!("du_{name}"));
        self.model.delays.push(Delay {
            name,
            input,
            by,
            symbol,
            rate,
        });
        Some(symbol)
    }

    /// What stands for the input and its delayed selves in a statement `input u = value`:
    /// what arrived so far, now and earlier.
    pub(super) fn what_arrives(
        &mut self,
        input: usize,
        value: ExprId,
        span: Span,
    ) -> Option<HashMap<SymbolId, ExprId>> {
        let symbol = self.model.inputs[input].symbol;
        let so_far = self.channels[input];
        let mut replacements = HashMap::from([(symbol, so_far)]);
        for index in 0..self.model.delays.len() {
            let delayed = self.model.delays[index].symbol;
            let here = self.model.delays[index].input == input;
            if !here || !self.model.graph.depends_on(&[value], delayed) {
                continue;
            }
            let map = self.shift(input, index, so_far, span)?;
            let remembered = self.model.states_in(so_far);
            if !remembered.is_empty() {
                // What remembers, remembers the delayed command: the two commute.
                if self.model.graph.depends_on(&[value], symbol) {
                    return self.report(self.delay_behind_memory(input, span));
                }
                for state in remembered {
                    let state = &mut self.model.states[state];
                    let moved = self
                        .model
                        .graph
                        .substitute(&[state.rate, state.initial], &map);
                    (state.rate, state.initial) = (moved[0], moved[1]);
                }
            }
            let earlier = self.model.graph.substitute(&[so_far], &map)[0];
            replacements.insert(delayed, earlier);
        }
        Some(replacements)
    }

    fn delay_behind_memory(&self, input: usize, span: Span) -> Diagnostic {
        let name = &self.model.inputs[input].name;
        let message = format!("`{name}` passes a state before it is delayed here");
        Diagnostic::error(span, message).help("put what delays it in front of what remembers it")
    }

    /// Every variable of the input in `so_far`, as it was `delays[index].by` earlier.
    fn shift(
        &mut self,
        input: usize,
        index: usize,
        so_far: ExprId,
        span: Span,
    ) -> Option<HashMap<SymbolId, ExprId>> {
        let delay = &self.model.delays[index];
        let (by, delayed) = (delay.by, self.model.graph.var(delay.symbol));
        let mut map = HashMap::from([(self.model.inputs[input].symbol, delayed)]);
        let states = self.model.states_in(so_far);
        let mut all: Vec<ExprId> = vec![so_far];
        all.extend(states.iter().map(|&z| self.model.states[z].rate));
        for other in 0..self.model.delays.len() {
            let earlier = self.model.delays[other].clone();
            if earlier.input == input && self.model.graph.depends_on(&all, earlier.symbol) {
                let total = self.model.graph.add(earlier.by, by);
                let symbol = self.delay_symbol(input, total, span)?;
                map.insert(earlier.symbol, self.model.graph.var(symbol));
            }
        }
        Some(map)
    }

    /// Every force sees what arrives in place of what was commanded.
    pub(super) fn put_channels_into_forces(&mut self, heading: Span) {
        let mut replacements = HashMap::new();
        let mut forces = self.model.forces.clone();
        forces.extend(self.model.point_forces.iter().flat_map(|f| f.value));
        for input in 0..self.model.inputs.len() {
            let (symbol, arrives) = (self.model.inputs[input].symbol, self.channels[input]);
            replacements.insert(symbol, arrives);
            if arrives == self.model.graph.var(symbol) {
                continue;
            }
            for index in 0..self.model.delays.len() {
                let delayed = self.model.delays[index].symbol;
                let here = self.model.delays[index].input == input;
                if !here || !self.model.graph.depends_on(&forces, delayed) {
                    continue;
                }
                if !self.model.states_in(arrives).is_empty() {
                    let error = self.delay_behind_memory(input, heading);
                    self.report::<()>(error);
                    continue;
                }
                let Some(map) = self.shift(input, index, arrives, heading) else {
                    continue;
                };
                let earlier = self.model.graph.substitute(&[arrives], &map)[0];
                replacements.insert(delayed, earlier);
            }
        }
        let mut seen = self.model.graph.substitute(&forces, &replacements);
        let mut of_points = seen.split_off(self.model.forces.len()).into_iter();
        for force in &mut self.model.point_forces {
            let parts = force.value.iter_mut().zip(of_points.by_ref());
            parts.for_each(|(entry, value)| *entry = value);
        }
        self.model.forces = seen;
    }

    /// Delays that composing has left without use.
    pub(super) fn drop_idle_delays(&mut self) {
        let mut used = self.model.forces.clone();
        used.extend(self.model.point_forces.iter().flat_map(|f| f.value));
        used.extend(self.model.states.iter().flat_map(|z| [z.rate, z.initial]));
        used.extend(self.model.outputs.iter().map(|y| y.value));
        used.extend(self.model.sensors.iter().map(|y| y.value));
        used.extend(self.model.inputs.iter().map(|u| u.arrives));
        let graph = &self.model.graph;
        let delays = &mut self.model.delays;
        delays.retain(|delay| graph.depends_on(&used, delay.symbol));
    }
}
