//! Parameters that become the numbers the model states.
//!
//! They turn into constants before any expression is built, so that everything behind
//! simplifies with them: a zero inertia disappears together with the terms it stands in.

use super::Model;
use super::builder::Builder;
use crate::diagnostic::{Diagnostic, nearest};
use std::collections::{BTreeMap, BTreeSet};

/// Which parameters of a model stay variable. The others are folded in.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Variables {
    /// Every parameter.
    #[default]
    All,
    /// The parameters of these names; a name that is no parameter's does nothing here and
    /// is found by [`Variables::unknown`].
    Only(BTreeSet<String>),
    /// Every parameter but these, which take the values given instead of those that the
    /// model states.
    Except(BTreeMap<String, f64>),
}

impl Variables {
    /// Only these.
    pub fn only<I: IntoIterator<Item: Into<String>>>(names: I) -> Self {
        Self::Only(names.into_iter().map(Into::into).collect())
    }

    fn contains(&self, name: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(names) => names.contains(name),
            Self::Except(values) => !values.contains_key(name),
        }
    }

    /// What to fold a parameter in as that is `nominal` in the model; `None` if it stays
    /// variable.
    fn folded(&self, name: &str, nominal: f64) -> Option<f64> {
        match self {
            Self::Except(values) => values.get(name).copied(),
            _ => (!self.contains(name)).then_some(nominal),
        }
    }

    fn names(&self) -> Vec<&String> {
        match self {
            Self::All => Vec::new(),
            Self::Only(names) => names.iter().collect(),
            Self::Except(values) => values.keys().collect(),
        }
    }

    /// The names that no parameter of `model` has, each with what to do about it.
    pub fn unknown(&self, model: &Model) -> Vec<(String, String)> {
        let known: Vec<&str> = model
            .parameters
            .iter()
            .chain(&model.fixed)
            .map(|parameter| parameter.name.as_str())
            .collect();
        let names = self.names().into_iter();
        let unknown = names.filter(|name| !known.contains(&name.as_str()));
        let with_help = unknown.map(|name| {
            let help = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None if known.is_empty() => "the model has no parameters".to_string(),
                None => format!("the model's parameters are: {}", known.join(", ")),
            };
            (name.clone(), help)
        });
        with_help.collect()
    }
}

impl Builder<'_> {
    /// Turns the parameters declared so far into constants, apart from those that stay
    /// variable. Their values are final, and nothing has been built from them yet.
    pub(super) fn fold(&mut self) {
        for index in 0..self.model.parameters.len() {
            self.fold_parameter(index);
        }
    }

    /// As [`fold`](Self::fold), for one of them.
    pub(super) fn fold_parameter(&mut self, index: usize) {
        let parameter = &self.model.parameters[index];
        let (name, nominal) = (&parameter.name, parameter.nominal);
        if let Some(value) = self.variables.folded(name, nominal) {
            self.model.graph.fix(parameter.symbol, value);
        }
    }

    /// An error about a value, which may be that of a parameter folded in.
    pub(super) fn with_folding_in_mind(&self, error: Diagnostic) -> Diagnostic {
        match self.variables {
            Variables::All => error,
            Variables::Only(_) | Variables::Except(_) => error.help(
                "parameters that are not kept variable count with the values stated: change the value, or keep the parameter",
            ),
        }
    }
}

impl Model {
    /// Moves the parameters that were folded in out of the way.
    pub(super) fn set_folded_aside(&mut self, variables: &Variables) {
        let mut places = Vec::new();
        let mut kept = Vec::new();
        for parameter in std::mem::take(&mut self.parameters) {
            if variables.contains(&parameter.name) {
                places.push(Some(kept.len()));
                kept.push(parameter);
            } else {
                places.push(None);
                self.fixed.push(parameter);
            }
        }
        self.parameters = kept;
        for effect in &mut self.effects {
            let own = effect.parameters.iter().filter_map(|&index| places[index]);
            effect.parameters = own.collect();
        }
    }
}
