//! A model's equations, ready to be evaluated: a tape per term, made when it is first asked for.

use crate::machine_code::MachineCode;
use cli::model::Loaded;
use dynamics_codegen::derive::{Expansion, Item, ItemError, Term, Variable};
use dynamics_codegen::graph::ExprId;
use dynamics_codegen::tree::{Frame, Pose};
use dynamics_codegen::{Column, System, Tape, Workspace};
use identify::machine::{Machine, Memory, SensitivityTape, States};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A model and what was made of it so far.
pub struct Equations {
    /// The model as it was read.
    pub loaded: Loaded,
    /// Names of the positions: the coordinates, but of a body that floats by its twist its pose.
    pub positions: Vec<String>,
    /// Names of the coordinates, the inputs and the internal states.
    pub coordinates: Vec<String>,
    pub inputs: Vec<String>,
    pub states: Vec<String>,
    machine: OnceLock<Machine>,
    derivatives: OnceLock<SensitivityTape>,
    expansion: Mutex<Option<Expansion>>,
    ready: Mutex<HashMap<Wanted, Arc<Ready>>>,
}

/// What a tape computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wanted {
    /// A term of the equations.
    Term(Term),
    /// Where a frame is, 4×4; its index among the tree's bodies.
    Pose(usize),
    /// How a frame moves, 6×n.
    Jacobian(usize),
}

/// One of them.
pub struct Ready {
    wanted: Wanted,
    tape: Tape,
    /// Its shape at one state.
    pub shape: Vec<usize>,
    /// Workspaces that nobody uses at the moment.
    idle: Mutex<Vec<Workspace>>,
}

/// States in rows, as they come from Python: `None` stands for zeros, of `z` for the beginning.
/// What has a single row, `t` a single number, holds for all.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    pub t: Entries<'a>,
    pub q: Entries<'a>,
    pub v: Entries<'a>,
    pub u: Entries<'a>,
    pub a: Entries<'a>,
    pub z: Entries<'a>,
    pub parameters: &'a [f64],
}

/// Rows of numbers.
#[derive(Debug, Clone, Copy)]
pub enum Entries<'a> {
    /// Nothing was given.
    None,
    /// The same row for all states.
    Same(&'a [f64]),
    /// A row per state.
    Each(&'a [f64]),
}

impl<'a> Entries<'a> {
    /// Entry `index` of `width` in a row, from a state on.
    fn column(self, index: usize, width: usize, start: usize) -> Column<'a> {
        match self {
            Self::None => Column::Same(0.0),
            Self::Same(row) => Column::Same(row[index]),
            Self::Each(rows) => Column::Every(&rows[index..], width).from(start),
        }
    }

    /// The entries of some states, by columns.
    fn columns(self, width: usize, range: &Range<usize>) -> Vec<Vec<f64>> {
        let column = |index: usize| match self {
            Self::None => vec![0.0; range.len()],
            Self::Same(row) => vec![row[index]; range.len()],
            Self::Each(rows) => range.clone().map(|k| rows[k * width + index]).collect(),
        };
        (0..width).map(column).collect()
    }
}

impl Equations {
    /// Of a model; nothing is derived yet.
    pub fn new(loaded: Loaded) -> Self {
        let model = &loaded.compiled.model;
        Self {
            positions: model.positions().into_iter().map(|p| p.name).collect(),
            coordinates: model.coordinates.iter().map(|c| c.name.clone()).collect(),
            inputs: model.inputs.iter().map(|u| u.name.clone()).collect(),
            states: model.states.iter().map(|z| z.name.clone()).collect(),
            loaded,
            machine: OnceLock::new(),
            derivatives: OnceLock::new(),
            expansion: Mutex::new(None),
            ready: Mutex::new(HashMap::new()),
        }
    }

    /// The model with these values of its parameters.
    pub fn with_values(&self, values: &[f64]) -> Loaded {
        Loaded {
            parameters: values.to_vec(),
            ..self.loaded.clone()
        }
    }

    /// Whether neither a constraint nor a contact has a part in the motion.
    pub fn is_free(&self) -> bool {
        let model = &self.loaded.compiled.model;
        model.constraints.is_empty() && !model.uses_multipliers()
    }

    /// What solves the equation of motion.
    pub fn machine(&self) -> &Machine {
        self.machine
            .get_or_init(|| Machine::new(self.loaded.compiled.clone()))
    }

    /// What differentiates it: by `q`, `v`, `u`, the parameters and `t`, in this order.
    pub fn derivatives(&self) -> &SensitivityTape {
        self.derivatives.get_or_init(|| {
            let mut variables = Vec::new();
            variables.extend((0..self.coordinates.len()).map(Variable::Position));
            variables.extend((0..self.coordinates.len()).map(Variable::Velocity));
            variables.extend((0..self.inputs.len()).map(Variable::Input));
            let parameters = 0..self.loaded.compiled.model.parameters.len();
            variables.extend(parameters.map(Variable::Parameter));
            variables.push(Variable::Time);
            self.machine().clone().sensitivity(&variables)
        })
    }

    /// A tape.
    ///
    /// # Errors
    /// If the model cannot have it.
    pub fn tape(&self, wanted: Wanted) -> Result<Arc<Ready>, String> {
        let mut ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = ready.get(&wanted) {
            return Ok(Arc::clone(known));
        }
        let mut expansion = self
            .expansion
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let expansion = expansion.get_or_insert_with(|| Expansion::new(&self.loaded.compiled));
        let entries = entries(expansion, wanted)?;
        let mut arguments = System::arguments(&expansion.model);
        arguments.extend(&expansion.acceleration);
        arguments.extend(expansion.model.multiplier_symbols());
        let made = Arc::new(Ready {
            wanted,
            tape: Tape::new(&expansion.model.graph, &entries, &arguments),
            shape: self.shape(wanted),
            idle: Mutex::new(Vec::new()),
        });
        ready.insert(wanted, Arc::clone(&made));
        Ok(made)
    }

    /// The shape of what a tape computes, at one state.
    pub fn shape(&self, wanted: Wanted) -> Vec<usize> {
        let model = &self.loaded.compiled.model;
        let (n, m) = (model.coordinates.len(), model.constraints.len());
        let term = match wanted {
            Wanted::Pose(_) => return vec![4, 4],
            Wanted::Jacobian(_) => return vec![6, n],
            Wanted::Term(term) => term,
        };
        match term {
            Term::MassMatrix => vec![n, n],
            Term::InputMatrix => vec![n, model.inputs.len() + model.delays.len()],
            Term::ConstraintJacobian => vec![m, n],
            Term::ConstraintBias | Term::ConstraintResidual | Term::ConstraintRate => vec![m],
            Term::PositionRate => vec![model.positions().len()],
            Term::StateRate => vec![model.states.len()],
            Term::Outputs => vec![model.outputs.len()],
            _ => vec![n],
        }
    }

    /// Fills rows with what a tape computes at a range of the states, by machine code if there is
    /// some.
    pub fn evaluate(
        &self,
        ready: &Ready,
        code: Option<&MachineCode>,
        given: &Given<'_>,
        range: Range<usize>,
        rows: &mut [f64],
    ) {
        if let (Some(code), Wanted::Term(term)) = (code, ready.wanted)
            && code.evaluate(term, given, &range, rows)
        {
            return;
        }
        let memory = self.memory(given, &range);
        let (n, k, start) = (self.coordinates.len(), self.inputs.len(), range.start);
        let m = self.loaded.compiled.model.constraints.len();
        let positions = self.positions.len();
        let groups = [
            (given.t, 1),
            (given.q, positions),
            (given.v, n),
            (given.u, k),
        ];
        let mut columns = Vec::with_capacity(ready.tape.input_count());
        for (of, width) in groups {
            columns.extend((0..width).map(|index| of.column(index, width, start)));
        }
        let remembered = memory.delayed.iter().chain(&memory.z);
        columns.extend(remembered.map(|column| Column::Each(column)));
        columns.extend(given.parameters.iter().map(|&value| Column::Same(value)));
        columns.extend((0..n).map(|index| given.a.column(index, n, start)));
        columns.extend(std::iter::repeat_n(Column::Same(0.0), m));
        let mut workspace = ready.borrow();
        ready
            .tape
            .evaluate_rows(&columns, range.len(), &mut workspace, rows);
        ready.give_back(workspace);
    }

    /// What the machine remembers at some states.
    fn memory(&self, given: &Given<'_>, range: &Range<usize>) -> Memory {
        let model = &self.loaded.compiled.model;
        match model.states.is_empty() && model.delays.is_empty() {
            true => Memory::default(),
            false => self.states(given, range).memory,
        }
    }

    /// Some of the states in columns, with what the machine remembers: inputs have always been what
    /// they are, internal states are those that were given or as at the beginning.
    pub fn states(&self, given: &Given<'_>, range: &Range<usize>) -> States {
        let (n, k) = (self.coordinates.len(), self.inputs.len());
        let t = given.t.columns(1, range).pop().unwrap_or_default();
        let mut states = States {
            t,
            q: given.q.columns(self.positions.len(), range),
            v: given.v.columns(n, range),
            u: given.u.columns(k, range),
            ..States::default()
        };
        if self.machine().remembers() {
            states = self.machine().at_rest(&states, given.parameters);
            if !matches!(given.z, Entries::None) {
                states.memory.z = given.z.columns(self.states.len(), range);
            }
        }
        states
    }
}

/// The entries of a tape, row by row; none where the model has none.
fn entries(expansion: &mut Expansion, wanted: Wanted) -> Result<Vec<ExprId>, String> {
    let body = match wanted {
        Wanted::Term(term) => {
            return match expansion.entries(Item::of(term)) {
                Err(ItemError::Empty { .. }) => Ok(Vec::new()),
                entries => entries.map_err(|error| error.to_string()),
            };
        }
        Wanted::Pose(body) | Wanted::Jacobian(body) => body,
    };
    let mechanism = expansion.model.posed().map_err(|error| error.to_string())?;
    let graph = &mut expansion.model.graph;
    let frame = Frame::of_body(graph, body);
    if let Wanted::Jacobian(_) = wanted {
        return Ok(mechanism.jacobian(graph, &frame).concat());
    }
    let Pose { rotation, position } = mechanism.pose(graph, &frame);
    let (zero, one) = (graph.zero(), graph.one());
    let rows = rotation.into_iter().zip(position);
    let upper = rows.flat_map(|([x, y, z], p)| [x, y, z, p]);
    Ok(upper.chain([zero, zero, zero, one]).collect())
}

impl Ready {
    fn borrow(&self) -> Workspace {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.pop().unwrap_or_else(|| self.tape.workspace())
    }

    fn give_back(&self, workspace: Workspace) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(workspace);
    }
}
