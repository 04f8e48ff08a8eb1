//! All that is emitted for one model.

use super::counts::{OperationCount, count_functions};
use super::functions::{FunctionError, Functions};
use super::plan::{Plan, Quantity};
use super::rust::{File, module_name};
use crate::compile::Compiled;
use crate::graph::{Graph, SymbolId};

/// A model with the functions that are emitted for it: the terms of its equations,
/// `equation_of_motion`, and those on request.
///
/// ```
/// use dynamics_codegen::emit::Emission;
/// use dynamics_codegen::{Library, compile};
///
/// let text = "
///     model slider;
///     coordinate x: m;
///     parameter m: kg = 2;
///     kinetic m/2*dot(x)^2;
/// ";
/// let compiled = compile("slider.model", text, &Library::empty())?;
/// let functions = "inverse_dynamics,forward_dynamics_derivatives".parse()?;
/// let emission = Emission::new(&compiled, "slider.model", &functions)?;
/// assert!(emission.rust().contains("pub fn inverse_dynamics<T: Scalar>"));
/// let [header, _] = emission.c();
/// assert!(header.text.contains("void slider_forward_dynamics_derivatives("));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Emission<'a> {
    pub(super) compiled: &'a Compiled,
    pub(super) source_name: &'a str,
    pub(super) plan: Plan,
}

impl<'a> Emission<'a> {
    /// Derives what `functions` ask for. `source_name` is the model's path as files and
    /// sheets are to name it.
    ///
    /// # Errors
    /// If the model cannot have one of the functions.
    pub fn new(
        compiled: &'a Compiled,
        source_name: &'a str,
        functions: &Functions,
    ) -> Result<Self, FunctionError> {
        Ok(Self {
            compiled,
            source_name,
            plan: Plan::new(compiled, functions)?,
        })
    }

    /// With the terms alone.
    pub fn terms(compiled: &'a Compiled, source_name: &'a str) -> Self {
        Self {
            compiled,
            source_name,
            plan: Plan::terms(compiled),
        }
    }

    /// The Rust module as a file.
    pub fn rust_file(&self) -> File {
        File {
            name: format!("{}.rs", module_name(self.compiled)),
            text: self.rust(),
        }
    }

    /// What each function computes, by the function's name, in the order of emission.
    pub fn functions(&self) -> impl Iterator<Item = (&str, &[Quantity])> {
        let functions = self.plan.functions.iter();
        functions.map(|f| (f.name.as_str(), f.quantities.as_slice()))
    }

    /// The graph on which all quantities stand, with the symbols for `a` and `λ`.
    pub fn graph(&self) -> &Graph {
        &self.plan.model.graph
    }

    /// The same, to put quantities of your own on.
    pub fn graph_mut(&mut self) -> &mut Graph {
        &mut self.plan.model.graph
    }

    /// Adds a function that computes quantities of your own; one quantity of the function's
    /// name by itself, else a struct. Names must be free and expressions must read no
    /// symbol but [`arguments`](Self::arguments) without `a, λ`.
    pub fn add(&mut self, function: &str, quantities: Vec<Quantity>) {
        self.plan.add(function, quantities);
    }

    /// The symbols that functions may read, in the order `t, q, v, u, parameters, a, λ`.
    pub fn arguments(&self) -> Vec<SymbolId> {
        self.plan.arguments()
    }

    /// The operations of every function, by its name, in the order of emission.
    pub fn operation_counts(&self) -> Vec<(String, OperationCount)> {
        count_functions(&self.plan)
    }
}
