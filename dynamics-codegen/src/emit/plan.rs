//! What is emitted for a model: quantities, and the functions that compute them.

use super::axes::Axes;
use super::body::Body;
use super::counts::OperationCount;
use super::frames::Frames;
use super::functions::{FunctionError, Functions, TERMS, Wish};
use super::given::{Given, giver};
use super::meaning::{describe, variables};
use super::naming::snake;
use super::solved::{self, SLOPES, Solved};
use super::symbols::{Argument, Symbols};
use super::text::one_line;
use crate::compile::Compiled;
use crate::derive::{Expansion, Group, Item, ItemError, Term};
use crate::graph::{ExprId, Graph, SymbolId};
use crate::model::Model;

/// A row or column of a quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// The coordinate, input, constraint or output it belongs to.
    pub name: String,
    /// Its unit; empty if the model does not say.
    pub unit: String,
}

/// A vector, matrix or cube of the equation of motion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quantity {
    /// What it is; `None` for one that was [added](super::Emission::add).
    pub item: Option<Item>,
    /// The emitted function's name.
    pub name: String,
    /// What it is, with its symbol in the thesis.
    pub meaning: String,
    /// What each row, each column, … belongs to. An entry's unit is its row's over
    /// those of the other axes.
    pub axes: Vec<Vec<Entry>>,
    /// The entries; the last axis runs fastest. None where the function solves for them in
    /// loops.
    pub entries: Vec<ExprId>,
    /// How temporaries that hold an entry are called.
    prefix: String,
}

impl Quantity {
    fn new(item: Item, axes: &Axes, entries: Vec<ExprId>) -> Self {
        let (meaning, prefix) = describe(item.term);
        let mut own = axes.of(item.term);
        let (meaning, prefix) = match item.by {
            None => (meaning.to_string(), prefix.to_string()),
            Some(group) => {
                own.extend(axes.of_group(group));
                let by = variables(group);
                (
                    format!("Derivative by {by} of: {meaning}"),
                    format!("d_{prefix}"),
                )
            }
        };
        Self {
            item: Some(item),
            name: item.to_string(),
            meaning,
            axes: own,
            entries,
            prefix,
        }
    }

    /// One of your own: `entries` on the graph of the emission it is added to, the last
    /// axis fastest. `name` becomes the name of a function or field.
    ///
    /// # Panics
    /// If `entries` does not fill the axes.
    pub fn own(name: &str, meaning: &str, axes: Vec<Vec<Entry>>, entries: Vec<ExprId>) -> Self {
        let size: usize = axes.iter().map(Vec::len).product();
        assert_eq!(size, entries.len(), "as many entries as the axes have");
        Self {
            item: None,
            name: snake(name),
            meaning: one_line(meaning),
            axes,
            entries,
            prefix: snake(name),
        }
    }

    /// With another beginning of the names of its temporaries.
    pub(super) fn with_prefix(self, prefix: &str) -> Self {
        let prefix = prefix.to_string();
        Self { prefix, ..self }
    }

    /// The length of each axis.
    pub fn shape(&self) -> Vec<usize> {
        self.axes.iter().map(Vec::len).collect()
    }

    /// What the documentation says about it: a line per axis, and one about units.
    pub(super) fn notes(&self, list: impl Fn(&[Entry]) -> String) -> Vec<String> {
        let titles: &[&str] = match self.axes.len() {
            1 => &["Entries"],
            2 => &["Rows", "Columns"],
            _ => &["First index", "Second index", "Third index"],
        };
        let axes = titles.iter().zip(&self.axes);
        let mut notes: Vec<String> = axes
            .map(|(title, axis)| format!("{title}: {}.", list(axis)))
            .collect();
        let by_time = self.item.is_some_and(|item| item.by == Some(Group::Time));
        match (self.axes.len(), by_time) {
            (1, false) => {}
            (1, true) => notes.push("The unit of an entry is the stated one per second.".into()),
            (2, false) => notes.push("The unit of an entry is its row's over its column's.".into()),
            (2, true) => {
                notes.push(
                    "The unit of an entry is its row's over its column's, per second.".into(),
                );
            }
            _ => notes.push("The unit of an entry is its first index's over the others'.".into()),
        }
        notes
    }

    /// How many entries it has.
    pub(super) fn len(&self) -> usize {
        self.shape().iter().product()
    }

    /// `3×2`
    pub(super) fn size(&self) -> String {
        let lengths: Vec<String> = self.shape().iter().map(usize::to_string).collect();
        lengths.join("×")
    }

    /// A wish for the name of the temporary that holds entry `index`.
    fn entry_name(&self, index: usize) -> String {
        let mut rest = index;
        let mut names: Vec<&str> = Vec::new();
        for axis in self.axes.iter().rev() {
            names.push(&axis[rest % axis.len()].name);
            rest /= axis.len();
        }
        names.push(&self.prefix);
        names.reverse();
        names.join("_")
    }
}

/// The terms of a model that have any entry, in the order of emission.
pub fn quantities(compiled: &Compiled) -> Vec<Quantity> {
    let mut expansion = Expansion::new(compiled);
    terms(&mut expansion)
}

fn terms(expansion: &mut Expansion) -> Vec<Quantity> {
    let items = TERMS.map(Item::of);
    quantities_of(expansion, &items, Expansion::entries)
}

/// The quantities of these items that the model has.
fn quantities_of(
    expansion: &mut Expansion,
    items: &[Item],
    entries: fn(&mut Expansion, Item) -> Result<Vec<ExprId>, ItemError>,
) -> Vec<Quantity> {
    let axes = Axes::new(expansion);
    let mut quantities = Vec::new();
    for &item in items {
        // What a model lacks it has no function for.
        if let Ok(entries) = entries(expansion, item)
            && !entries.is_empty()
        {
            quantities.push(Quantity::new(item, &axes, entries));
        }
    }
    quantities
}

/// The name of the fused function of all terms.
pub(super) const EQUATION_OF_MOTION: &str = "equation_of_motion";

/// All functions on request together have at most so many operations written out, some 40 MB of
/// C. All functions of a chain of 60 joints have 0.3 million (13 MB): beyond this limit, no
/// compiler of what is emitted ends while one waits.
pub(super) const MOST_OPERATIONS: usize = 1_000_000;

/// What the fused function `equation_of_motion` computes.
const FUSED: [Term; 6] = [
    Term::MassMatrix,
    Term::Force,
    Term::ConstraintJacobian,
    Term::ConstraintBias,
    Term::ConstraintResidual,
    Term::ConstraintRate,
];

/// Everything that is emitted for a model.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// The model; its graph holds all that is emitted.
    pub model: Model,
    pub functions: Vec<Function>,
    /// As they were asked for.
    pub requested: Functions,
    /// For each coordinate the one that carries it, or itself.
    pub parents: Vec<usize>,
    expansion: Expansion,
}

/// One emitted function: a single quantity, or several that share their temporaries.
#[derive(Debug, Clone)]
pub(super) struct Function {
    pub name: String,
    pub meaning: String,
    pub quantities: Vec<Quantity>,
    /// Whether it returns a struct.
    pub fused: bool,
    /// How it is solved for in loops, if it is not written out.
    pub solved: Option<Solved>,
    /// What it begins with.
    pub given: Option<Given>,
}

impl Plan {
    /// One function per term, the equation of motion, then what is asked for.
    pub fn new(compiled: &Compiled, requested: &Functions) -> Result<Self, FunctionError> {
        let mut expansion = Expansion::new(compiled);
        let terms = terms(&mut expansion);
        let mut functions: Vec<Function> = terms.into_iter().map(Function::single).collect();
        let mut equation_by = |entries| Function {
            name: EQUATION_OF_MOTION.to_string(),
            meaning: "Everything that the equation of motion needs".to_string(),
            quantities: quantities_of(&mut expansion, &FUSED.map(Item::of), entries),
            fused: true,
            solved: None,
            given: None,
        };
        let ways = [
            equation_by(Expansion::entries_beside_mass),
            equation_by(Expansion::entries),
        ];
        let equation = shorter(&expansion.model.graph, &functions, ways);
        functions.push(equation);
        on_request(&mut expansion, requested, &mut functions)?;
        // At the end: what begins with another function contains that one's expressions.
        for function in &mut functions {
            function.settle_signs(&mut expansion.model.graph);
        }
        Ok(Self {
            model: expansion.model.clone(),
            functions,
            requested: requested.clone(),
            parents: solved::parents(&expansion.model.graph, expansion.system()),
            expansion,
        })
    }

    /// With the terms alone.
    pub fn terms(compiled: &Compiled) -> Self {
        // Only a wish can fail, and there is none.
        Self::new(compiled, &Functions::none()).unwrap_or_else(|error| unreachable!("{error}"))
    }

    /// The symbols that functions may read, in the order `t, q, v, u, z, parameters, a, λ`.
    pub fn arguments(&self) -> Vec<SymbolId> {
        let mut arguments = super::axes::arguments(&self.model);
        arguments.extend(&self.expansion.acceleration);
        arguments.extend(&self.expansion.multipliers);
        arguments
    }

    /// Names for the model's symbols; `taken` is what the language needs for itself,
    /// `field` what it calls the field of a parameter.
    pub fn symbols(&self, taken: &[&str], field: fn(&str) -> String) -> Symbols {
        let (a, lambda) = (&self.expansion.acceleration, &self.expansion.multipliers);
        Symbols::new(&self.model, (a, lambda), (taken, field))
    }
}

/// Adds the functions that are asked for, and those that they call.
fn on_request(
    expansion: &mut Expansion,
    requested: &Functions,
    functions: &mut Vec<Function>,
) -> Result<(), FunctionError> {
    let mut operations = 0;
    let mut wishes = requested.wishes().to_vec();
    let solves = |wish: &Wish| {
        let solved = solved_in_loops(expansion, wish);
        solved.is_some_and(|solved| !solved.groups.is_empty())
    };
    if wishes.iter().any(solves) && wishes.iter().all(|wish| wish.name != SLOPES) {
        wishes.push(Wish::bundle(SLOPES));
    }
    let mut frames = Frames::default();
    for wish in &wishes {
        let Some(function) = requested_function(expansion, &mut frames, wish)? else {
            continue;
        };
        if functions.iter().any(|known| known.name == function.name) {
            let name = function.name;
            return Err(FunctionError::Twice { name });
        }
        // Written as the functions of single terms are, it may begin with one of them. Its motion stays:
        // by itself that is a recursion which shares nothing with the mass matrix.
        let mut by_itself = function.clone();
        for quantity in &mut by_itself.quantities {
            let item = quantity
                .item
                .filter(|item| item.term != Term::ForwardDynamics);
            if let Some(item) = item.filter(|_| !quantity.entries.is_empty()) {
                quantity.entries = expansion.entries(item)?;
            }
        }
        let graph = &expansion.model.graph;
        let function = shorter(graph, functions, [function, by_itself]);
        operations += function.written(graph).total();
        if operations > MOST_OPERATIONS {
            let function = function.name;
            return Err(FunctionError::TooLarge { function });
        }
        functions.push(function);
    }
    Ok(())
}

/// The second way, if it begins with an earlier function where the first does not; the first if
/// both do, or none. Each with what it begins with.
fn shorter(graph: &Graph, earlier: &[Function], ways: [Function; 2]) -> Function {
    let [first, second] = ways.map(|mut function| {
        function.given = giver(graph, earlier, &function);
        function
    });
    match (&first.given, &second.given) {
        (None, Some(_)) => second,
        _ => first,
    }
}

/// How a wish is solved for in loops, if it is to be; nothing is beside a frame.
fn solved_in_loops(expansion: &Expansion, wish: &Wish) -> Option<Solved> {
    let forward = [Item::of(Term::ForwardDynamics)];
    let alone = wish.frames.is_empty();
    if wish.items == forward && expansion.moves_without_mass_matrix() {
        return None;
    }
    Solved::of(expansion.model.coordinates.len(), &wish.items).filter(|_| alone)
}

/// The function of a wish; none if the model lacks all of it and the wish is for
/// whatever there is.
fn requested_function(
    expansion: &mut Expansion,
    frames: &mut Frames,
    wish: &Wish,
) -> Result<Option<Function>, FunctionError> {
    let axes = Axes::new(expansion);
    let solved = solved_in_loops(expansion, wish);
    let with_mass = |item: &Item| match item.term {
        Term::MassMatrix => item.by.is_none(),
        Term::ForwardDynamics => item.by.is_some(),
        _ => false,
    };
    let beside_mass = wish.items.iter().any(with_mass);
    let mut quantities = Vec::new();
    let mut missing = None;
    for &item in &wish.items {
        let entries = match solved {
            Some(_) => expansion.can_have(item).map(|()| Vec::new()),
            None if beside_mass => expansion.entries_beside_mass(item),
            None => expansion.entries(item),
        };
        match entries {
            Ok(entries) => quantities.push(Quantity::new(item, &axes, entries)),
            Err(error @ (ItemError::Empty { .. } | ItemError::Contact { .. })) if wish.lenient => {
                missing = Some(error)
            }
            Err(error) if Functions::passes_over(wish) => missing = Some(error),
            Err(error) => return Err(error.into()),
        }
    }
    for frame in &wish.frames {
        quantities.push(frames.quantity(expansion, frame)?);
    }
    // A bundle without what it is named after is none.
    let headless = wish.is_fused()
        && wish.items.first().copied() != quantities.first().and_then(|q: &Quantity| q.item);
    match missing {
        Some(_) if (quantities.is_empty() || headless) && Functions::passes_over(wish) => Ok(None),
        Some(error) if quantities.is_empty() || headless => Err(error.into()),
        _ if !wish.is_fused() => Ok(quantities.pop().map(|only| Function {
            solved,
            ..Function::single(only)
        })),
        _ => Ok(Some(Function {
            name: wish.name.clone(),
            meaning: list_of_meanings(&quantities),
            quantities,
            fused: true,
            solved,
            given: None,
        })),
    }
}

/// `mass_matrix`, `bias_force`.
fn list_of_meanings(quantities: &[Quantity]) -> String {
    let names: Vec<String> = quantities.iter().map(|q| format!("`{}`", q.name)).collect();
    names.join(", ")
}

impl Plan {
    /// The function that another one begins with.
    pub fn giver(&self, function: &Function) -> Option<&Function> {
        let given = function.given.as_ref();
        given.map(|given| &self.functions[given.function])
    }

    /// One more function: of one quantity by itself, or of several.
    pub fn add(&mut self, name: &str, mut quantities: Vec<Quantity>) {
        let single = quantities.len() == 1 && quantities[0].name == name;
        let mut function = match quantities.pop() {
            Some(only) if single => Function::single(only),
            last => {
                quantities.extend(last);
                Function {
                    name: snake(name),
                    meaning: list_of_meanings(&quantities),
                    quantities,
                    fused: true,
                    solved: None,
                    given: None,
                }
            }
        };
        function.settle_signs(&mut self.model.graph);
        self.functions.push(function);
    }
}

impl Function {
    fn single(quantity: Quantity) -> Self {
        Self {
            name: quantity.name.clone(),
            meaning: quantity.meaning.clone(),
            quantities: vec![quantity],
            fused: false,
            solved: None,
            given: None,
        }
    }

    /// Puts signs where they cost least.
    fn settle_signs(&mut self, graph: &mut Graph) {
        let given = |expr| {
            let given = self.given.as_ref();
            given.is_some_and(|given| given.places.contains_key(&expr))
        };
        let settled = graph.settle_signs(&self.entries(), given);
        let places = self.quantities.iter_mut().flat_map(|q| &mut q.entries);
        for (place, expr) in places.zip(settled) {
            *place = expr;
        }
    }

    pub fn entries(&self) -> Vec<ExprId> {
        let entries = self.quantities.iter().flat_map(|q| &q.entries);
        entries.copied().collect()
    }

    /// Whether it is a function of an acceleration that the caller states.
    pub fn takes_acceleration(&self) -> bool {
        let mut items = self.quantities.iter().filter_map(|q| q.item);
        items.any(|item| item.term.takes_acceleration())
    }

    /// Whether it is a function of multipliers that the caller states.
    pub fn takes_multipliers(&self) -> bool {
        let mut items = self.quantities.iter().filter_map(|q| q.item);
        items.any(|item| item.term.takes_multipliers())
    }

    /// Whether it has an argument.
    pub fn takes(&self, argument: Argument) -> bool {
        match argument {
            Argument::Parameters | Argument::Point => true,
            Argument::Acceleration => self.takes_acceleration(),
            Argument::Multipliers => self.takes_multipliers(),
            Argument::Arrays => false,
        }
    }

    /// What is written out: all that it needs but what it begins with.
    pub fn written(&self, graph: &Graph) -> OperationCount {
        match &self.given {
            Some(given) => OperationCount::beyond(graph, &self.entries(), given),
            None => OperationCount::of(graph, &self.entries()),
        }
    }

    /// The straight lines that compute it; `access` is how the language names a member of
    /// what it begins with.
    pub fn body(&self, model: &Model, symbols: &Symbols, access: &str) -> Body {
        let mut outputs = Vec::new();
        for quantity in &self.quantities {
            let wishes = (0..quantity.entries.len()).map(|i| quantity.entry_name(i));
            outputs.extend(quantity.entries.iter().copied().zip(wishes));
        }
        let given = self.given.iter().flat_map(|given| given.texts(access));
        Body::new(&model.graph, symbols, &outputs, given.collect())
    }
}
