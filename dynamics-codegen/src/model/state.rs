//! First-order states: `state z: m = 0;` with `dot(z) == …;`.
//!
//! What a machine remembers beside positions and velocities: the bristles of a
//! friction law, a drive's lag, the play of a gear.

use super::Model;
use super::builder::Builder;
use super::names::Binding;
use super::quantity::{Measure, Quantity};
use super::unit::unit_text;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::graph::{ExprId, SymbolId};
use crate::source::Span;
use crate::syntax::{Expr, Name, Unit};
use std::collections::HashMap;

/// A first-order state.
#[derive(Debug, Clone)]
pub struct State {
    /// Its name. A state of an effect is `<effect>_<places>_<state>`.
    pub name: String,
    /// Its dimension, if the model declares one.
    pub dimension: Option<Dimension>,
    /// The unit as written.
    pub unit: String,
    /// Its variable `z`.
    pub symbol: SymbolId,
    /// Its value when a log or a simulation begins: a function of `t, q, v, u` and
    /// parameters.
    pub initial: ExprId,
    /// `dz/dt`, a function of `t, q, v, u, z` and parameters.
    pub rate: ExprId,
    /// Which of the model's effects it belongs to, if any.
    pub effect: Option<usize>,
    /// What the model says about it.
    pub doc: String,
}

/// What is known of a state beside the model while it is being built.
#[derive(Debug, Clone)]
pub(super) struct StateNotes {
    /// Where it is declared.
    span: Span,
    /// Where its rate is stated.
    rate: Option<Span>,
}

impl Model {
    /// The states that `expr` contains, directly or through the rates of others.
    pub fn states_in(&self, expr: ExprId) -> Vec<usize> {
        let mut found = vec![false; self.states.len()];
        let mut open = vec![expr];
        while let Some(expr) = open.pop() {
            let symbols = self.graph.symbols_in(&[expr]);
            for (index, state) in self.states.iter().enumerate() {
                if !found[index] && symbols.contains(&state.symbol) {
                    found[index] = true;
                    open.push(state.rate);
                }
            }
        }
        (0..found.len()).filter(|&index| found[index]).collect()
    }
}

impl Builder<'_> {
    pub(super) fn declare_state(&mut self, name: &Name, unit: Option<&Unit>, doc: &str) {
        let dimension = unit.and_then(|unit| self.dimension(unit));
        let binding = Binding::State(self.model.states.len());
        if !self.bind(name, binding) {
            return;
        }
        let full_name = format!("{}{}{}", self.prefix, self.member, name.text);
        let unit = match (unit, dimension) {
            (Some(_), dimension) if self.effect.is_some() => {
                dimension.map_or_else(String::new, |d| d.to_string())
            }
            (Some(unit), _) => unit_text(unit),
            (None, _) => String::new(),
        };
        let graph = &mut self.model.graph;
        let zero = graph.zero();
        let symbol = graph.symbol(format!("z_{full_name}"));
        self.model.states.push(State {
            name: full_name,
            dimension,
            unit,
            symbol,
            initial: zero,
            rate: zero,
            effect: self.effect,
            doc: doc.to_string(),
        });
        self.state_notes.push(StateNotes {
            span: name.span,
            rate: None,
        });
    }

    pub(super) fn state_symbol(&self, index: usize) -> Option<Quantity> {
        let state = &self.model.states[index];
        Some(Quantity {
            expr: self.model.graph.var(state.symbol),
            measure: Measure::of(state.dimension),
        })
    }

    /// `state z = value`: what it is at the beginning.
    pub(super) fn lower_initial(&mut self, name: &Name, initial: Option<&Expr>) -> Option<()> {
        // A name that is taken has been reported.
        let bound = self.scope.names.get(&name.text).map(|d| d.what.clone());
        let (Some(Binding::State(index)), Some(initial)) = (bound, initial) else {
            return None;
        };
        let quantity = self.lower(initial)?;
        if let Some(dimension) = self.model.states[index].dimension {
            let role = format!("the initial value of `{}`", name.text);
            self.expect_dimension(quantity, dimension, initial.span, &role)?;
        }
        if !self.model.states_in(quantity.expr).is_empty() {
            return self.report(Diagnostic::error(
                initial.span,
                "an initial value cannot depend on a state",
            ));
        }
        self.refuse_momentary(quantity.expr, initial.span, "an initial value")?;
        self.model.states[index].initial = self.as_it_arrives(quantity.expr);
        Some(())
    }

    /// `dot(z) == value`. An input in it is what arrives from the statements in front.
    pub(super) fn lower_rate(&mut self, name: &Name, value: &Expr) -> Option<()> {
        let index = self.state_of(name)?;
        let quantity = self.lower(value)?;
        if let Some(dimension) = self.model.states[index].dimension {
            let role = format!("the rate of `{}`", name.text);
            self.expect_dimension(quantity, dimension.rate(), value.span, &role)?;
        }
        let span = name.span.to(value.span);
        if let Some(first) = self.state_notes[index].rate.replace(span) {
            return self.report(
                Diagnostic::error(span, format!("the rate of `{}` is stated twice", name.text))
                    .label("again here")
                    .also(first, "first here"),
            );
        }
        self.refuse_momentary(quantity.expr, value.span, "a rate")?;
        self.model.states[index].rate = self.as_it_arrives(quantity.expr);
        Some(())
    }

    fn state_of(&mut self, name: &Name) -> Option<usize> {
        let bound = self.scope.names.get(&name.text);
        if let Some(Binding::State(index)) = bound.map(|declared| &declared.what) {
            return Some(*index);
        }
        let known: Vec<String> = self
            .scope
            .names
            .iter()
            .filter(|(_, declared)| matches!(declared.what, Binding::State(_)))
            .map(|(name, _)| name.clone())
            .collect();
        self.unknown_place(name, "state", &known)
    }

    /// An expression with every input replaced by what arrives so far.
    fn as_it_arrives(&mut self, expr: ExprId) -> ExprId {
        let inputs = self.model.inputs.iter().zip(&self.channels);
        let so_far: HashMap<SymbolId, ExprId> = inputs
            .map(|(input, &channel)| (input.symbol, channel))
            .collect();
        self.model.graph.substitute(&[expr], &so_far)[0]
    }

    /// Energies and constraints hold neither states nor delayed inputs, and neither has a
    /// rate that could be taken.
    pub(super) fn refuse_memory(&mut self, expr: ExprId, span: Span, role: &str) -> Option<()> {
        self.refuse_momentary(expr, span, role)?;
        let graph = &self.model.graph;
        let mut states = self.model.states.iter();
        if let Some(state) = states.find(|z| graph.depends_on(&[expr], z.symbol)) {
            let message = format!("{role} contains the state `{}`", state.name);
            return self.report(
                Diagnostic::error(span, message)
                    .help("a state acts through `force` and `input … = …`"),
            );
        }
        let mut delays = self.model.delays.iter();
        if let Some(delay) = delays.find(|d| graph.depends_on(&[expr], d.symbol)) {
            let name = &self.model.inputs[delay.input].name;
            let message = format!("{role} contains the input `{name}`, delayed");
            return self
                .report(Diagnostic::error(span, message).help("an input acts through `force`"));
        }
        Some(())
    }

    /// Multipliers and loads are known only when all forces are.
    pub(super) fn refuse_momentary(&mut self, expr: ExprId, span: Span, role: &str) -> Option<()> {
        let graph = &self.model.graph;
        let mut constraints = self.model.constraints.iter();
        if let Some(found) = constraints.find(|c| graph.depends_on(&[expr], c.multiplier)) {
            let message = format!("{role} contains the multiplier of `{}`", found.name);
            return self.report(
                Diagnostic::error(span, message).help("a multiplier stands in `force` only"),
            );
        }
        let mut loads = self.loads.iter();
        if loads.any(|load| graph.depends_on(&[expr], load.symbol)) {
            let message = format!("{role} contains a load");
            return self
                .report(Diagnostic::error(span, message).help("a load stands in `force` only"));
        }
        Some(())
    }

    /// A state without a rate would stand still: a slip, not a wish.
    pub(super) fn refuse_states_without_rate(&mut self) {
        // A faulty rate is no missing one.
        if self.failed() {
            return;
        }
        for index in 0..self.state_notes.len() {
            let StateNotes { span, rate: None } = self.state_notes[index] else {
                continue;
            };
            let state = &self.model.states[index];
            let effect = state.effect.is_some();
            let name = match (effect, state.name.rsplit_once('_')) {
                (true, Some((_, name))) => name.to_string(),
                _ => state.name.clone(),
            };
            let message = format!("the rate of the state `{name}` is not stated");
            let help = format!("add `dot({name}) == …;`");
            self.report::<()>(Diagnostic::error(span, message).help(help));
        }
    }
}
