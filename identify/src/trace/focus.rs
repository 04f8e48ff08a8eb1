//! The model with some candidates and nothing else.
//!
//! The dictionary holds every effect at every place: its equations are many times those of
//! the machine. What is fitted are a few of its candidates; all others do nothing, so a
//! model that never heard of them moves in the same way at a fraction of the cost.

use super::dictionary::{Dictionary, Source};
use super::estimate::Observed;
use super::subject::Subject;
use crate::machine::{Instruments, Machine, SensitivityTape, Sensors};
use crate::regression::{Columns, Mover};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::syntax::written_name;
use dynamics_codegen::{Compiled, Library, Report, Variables, compile_keeping};
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;
use std::sync::{Arc, Mutex, PoisonError};

/// A model with some of the dictionary's candidates; all else is folded in at its default.
#[derive(Debug)]
pub struct Focus {
    /// The model.
    pub machine: Machine,
    /// Derivatives by positions and velocities.
    pub slopes: SensitivityTape,
    /// Derivatives by the candidates' parameters, in the candidates' order.
    pub by_parameter: SensitivityTape,
    /// What sensors read, with derivatives by the same.
    pub sensors: Sensors,
    /// What the model's own sensors show, with derivatives by positions and velocities, and by the
    /// candidates' parameters.
    instruments: [Instruments; 2],
    /// What changes with how internal states began; `None` if there are none.
    beginnings: Option<Beginnings>,
    /// Per parameter of the model: which one of the dictionary's it is.
    places: Vec<usize>,
}

/// Derivatives by what each internal state is when a log begins.
#[derive(Debug)]
struct Beginnings {
    slopes: SensitivityTape,
    instruments: Instruments,
}

impl Focus {
    /// The model's parameters out of all the dictionary's.
    pub fn values(&self, all: &[f64]) -> Vec<f64> {
        self.places.iter().map(|&place| all[place]).collect()
    }

    /// The machine along a log, with these values of its own parameters.
    pub fn mover<'a>(&'a self, observed: &Observed, parameters: &'a [f64]) -> Mover<'a> {
        let [by_state, _] = &self.instruments;
        Mover {
            machine: &self.machine,
            slopes: &self.slopes,
            instruments: observed.record.sensed.as_ref().map(|_| by_state),
            parameters,
        }
    }

    /// What its candidates add along a log, in the order of their parameters.
    pub fn columns<'a>(&'a self, observed: &Observed, parameters: &'a [f64]) -> Columns<'a> {
        let [_, by_parameter] = &self.instruments;
        Columns {
            machine: &self.machine,
            tape: &self.by_parameter,
            sensors: Some(&self.sensors),
            instruments: observed.record.sensed.as_ref().map(|_| by_parameter),
            parameters,
        }
    }

    /// What internal states add along a log that begin beside what the model states, in the model's
    /// order; `None` if there are none.
    pub fn beginnings<'a>(
        &'a self,
        observed: &Observed,
        parameters: &'a [f64],
    ) -> Option<Columns<'a>> {
        let beginnings = self.beginnings.as_ref()?;
        let sensed = observed.record.sensed.as_ref();
        Some(Columns {
            machine: &self.machine,
            tape: &beginnings.slopes,
            sensors: None,
            instruments: sensed.map(|_| &beginnings.instruments),
            parameters,
        })
    }

    /// The internal states, in the model's order.
    pub fn internal_states(&self) -> impl Iterator<Item = &str> {
        let states = self.machine.compiled.model.states.iter();
        states.map(|state| state.name.as_str())
    }

    fn new(dictionary: &Dictionary, candidates: &[usize], compiled: Compiled) -> Option<Self> {
        let parameters = &compiled.model.parameters;
        let all = &dictionary.machine.compiled.model.parameters;
        let place = |name: &str| all.iter().position(|p| p.name == name);
        let places: Option<Vec<usize>> = parameters.iter().map(|p| place(&p.name)).collect();
        let places = places?;
        let variables: Option<Vec<Variable>> = dictionary
            .parameters_of(candidates)
            .iter()
            .map(|wanted| places.iter().position(|place| place == wanted))
            .map(|index| index.map(Variable::Parameter))
            .collect();
        Some(Self::of(Machine::new(compiled), &variables?, places))
    }

    fn of(mut machine: Machine, variables: &[Variable], places: Vec<usize>) -> Self {
        let n = machine.coordinate_count();
        let state: Vec<Variable> = (0..n)
            .map(Variable::Position)
            .chain((0..n).map(Variable::Velocity))
            .collect();
        let internal: Vec<Variable> = (0..machine.state_count())
            .map(Variable::Beginning)
            .collect();
        Self {
            beginnings: (!internal.is_empty()).then(|| Beginnings {
                slopes: machine.sensitivity(&internal),
                instruments: machine.instruments(&internal),
            }),
            slopes: machine.sensitivity(&state),
            by_parameter: machine.sensitivity(variables),
            sensors: machine.sensors(variables),
            instruments: [machine.instruments(&state), machine.instruments(variables)],
            machine,
            places,
        }
    }
}

/// Models that were asked for before: a search returns to the same ones.
#[derive(Debug)]
pub(super) struct Focuses {
    name: String,
    text: String,
    library: Library,
    known: Mutex<HashMap<Vec<usize>, Arc<Focus>>>,
}

impl Focuses {
    /// For a model.
    pub fn new(source: &Source<'_>) -> Self {
        Self {
            name: source.name.to_string(),
            text: source.text.to_string(),
            library: source.library.clone(),
            known: Mutex::default(),
        }
    }

    fn compile(&self, dictionary: &Dictionary, candidates: &[usize]) -> Result<Compiled, Report> {
        let mut text = self.text.clone();
        let mut folded: BTreeMap<String, f64> = BTreeMap::new();
        for (index, candidate) in dictionary.candidates.iter().enumerate() {
            let wanted = candidates.contains(&index);
            match &candidate.subject {
                Subject::Effect { template, on } if wanted => {
                    let on: Vec<String> = on.iter().map(|name| written_name(name)).collect();
                    // Writing to a string cannot fail.
                    let _ = write!(text, "\neffect {template}({});", on.join(", "));
                }
                Subject::Parameter(name) if !wanted => {
                    let own = candidate.parameters.iter();
                    folded.extend(own.map(|&p| (name.clone(), dictionary.defaults[p])));
                }
                _ => {}
            }
        }
        let except = Variables::Except(folded);
        compile_keeping(&self.name, &text, &self.library, &except)
            // A value given instead of a nominal one may make an expression meaningless
            // where it stands alone.
            .or_else(|_| compile_keeping(&self.name, &text, &self.library, &Variables::All))
    }
}

impl Dictionary {
    /// The model with some candidates alone.
    pub fn focus(&self, candidates: &[usize]) -> Arc<Focus> {
        // A lock is only lost to a panic, which leaves the map whole.
        let known = || {
            let known = self.focuses.known.lock();
            known.unwrap_or_else(PoisonError::into_inner)
        };
        if let Some(focus) = known().get(candidates) {
            return Arc::clone(focus);
        }
        let compiled = self.focuses.compile(self, candidates).ok();
        let focus = compiled.and_then(|compiled| Focus::new(self, candidates, compiled));
        let focus = Arc::new(focus.unwrap_or_else(|| self.whole(candidates)));
        known().insert(candidates.to_vec(), Arc::clone(&focus));
        focus
    }

    /// The whole dictionary, should a part of it not compile by itself.
    fn whole(&self, candidates: &[usize]) -> Focus {
        let parameters = self.parameters_of(candidates).into_iter();
        let variables: Vec<Variable> = parameters.map(Variable::Parameter).collect();
        let places = (0..self.defaults.len()).collect();
        Focus::of(self.machine.clone(), &variables, places)
    }
}
