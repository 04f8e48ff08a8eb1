//! Statements to a model: names declared, then everything lowered.

use super::effects::Templates;
use super::names::{Binding, Declared, RESERVED, Scope, Term, TermState, VECTORS};
use super::quantity::{Measure, Quantity};
use super::{Constraint, ConstraintKind, Coordinate, Input, Model, Output, Parameter};
use crate::diagnostic::{Diagnostic, Severity, nearest};
use crate::dimension::Dimension;
use crate::graph::{ExprId, Graph};
use crate::source::{Sources, Span};
use crate::syntax::{
    Bounds, Expr, ExprKind, File, Heading, Name, PortKind, Prior, Statement, StatementKind, Unit,
    UnitBase,
};
use crate::tree::{Body, Inertia, Joint, Mechanism, Options, Placement, Tree};

/// A model may have this many coordinates, inputs and constraints.
pub(super) const MAX_SIZE: usize = 256;

/// Builds the model that `file` describes. Findings are added to `diagnostics`;
/// `None` if there is an error among them.
pub(crate) fn build(
    file: &File,
    sources: &mut Sources,
    library: &super::Library,
    variables: &super::Variables,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Model> {
    let name = match &file.heading {
        Heading::Model(name) => name,
        Heading::Effect { name, .. } => {
            diagnostics.push(
                Diagnostic::error(name.span, "this file is an effect template, not a model")
                    .help("name it in a model with `effect name(place);`"),
            );
            return None;
        }
    };
    let mut builder = Builder::new(name.text.clone(), file.doc.clone(), variables, diagnostics);
    let statements: Vec<&Statement> = file.statements.iter().collect();
    let states_gravity = |s: &&Statement| matches!(s.kind, StatementKind::Gravity(_));
    builder.states_gravity = statements.iter().any(states_gravity);
    builder.declare(&statements, sources, library);
    let unreadable = file.unreadable.iter().map(|name| name.text.clone());
    builder.scope.unreadable = unreadable.collect();
    builder.refuse_excess(name.span);
    builder.lower_statements(&statements);
    Templates { sources, library }.apply_all(&mut builder, &statements);
    builder.finish(name.span)
}

/// A model under construction.
pub(super) struct Builder<'a> {
    pub model: Model,
    pub scope: Scope,
    /// The terms that are being lowered, each needed by the one before.
    pub term_path: Vec<usize>,
    /// What parameters of the file at hand are called in the model.
    pub prefix: String,
    /// The effect at hand, while one is being applied.
    pub effect: Option<usize>,
    /// Which parameters are not folded in.
    pub variables: &'a super::Variables,
    diagnostics: &'a mut Vec<Diagnostic>,
    /// What each input's channel does, composed in the order of the text.
    pub(super) channels: Vec<ExprId>,
    /// Beside [`Model::states`]: where each is declared and given its rate.
    pub(super) state_notes: Vec<super::state::StateNotes>,
    pub has_kinetic: bool,
    pub too_large: bool,
    /// Whether the model says itself what gravity is.
    pub states_gravity: bool,
    /// Whether the robot description underneath could not be read: what it holds is
    /// not there, and not to be complained about.
    pub unreadable_base: bool,
}

impl<'a> Builder<'a> {
    fn new(
        name: String,
        doc: String,
        variables: &'a super::Variables,
        diagnostics: &'a mut Vec<Diagnostic>,
    ) -> Self {
        let mut graph = Graph::new();
        let time = graph.symbol("t");
        let zero = graph.zero();
        let model = Model {
            name,
            doc,
            graph,
            time,
            coordinates: Vec::new(),
            inputs: Vec::new(),
            delays: Vec::new(),
            states: Vec::new(),
            parameters: Vec::new(),
            fixed: Vec::new(),
            kinetic: zero,
            potential: zero,
            dissipation: zero,
            forces: Vec::new(),
            point_forces: Vec::new(),
            tree: world(zero),
            mechanism: None,
            bodies: Vec::new(),
            kinematics: Vec::new(),
            robot: None,
            constraints: Vec::new(),
            outputs: Vec::new(),
            effects: Vec::new(),
        };
        Self {
            model,
            scope: Scope::default(),
            term_path: Vec::new(),
            prefix: String::new(),
            effect: None,
            variables,
            diagnostics,
            channels: Vec::new(),
            state_notes: Vec::new(),
            has_kinetic: false,
            too_large: false,
            states_gravity: false,
            unreadable_base: false,
        }
    }

    /// Reports a finding; always `None`, so that it can end a lowering.
    pub fn report<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.diagnostics.push(diagnostic);
        None
    }

    /// How many findings there are.
    pub fn finding_count(&self) -> usize {
        self.diagnostics.len()
    }

    /// Says of the findings behind the first `count`, unless they are in the text of
    /// `place` themselves, that `place` is why the text they are in was read.
    pub fn explain(&mut self, count: usize, place: Span) {
        for finding in &mut self.diagnostics[count..] {
            if finding.primary.span.source != place.source {
                let needed = finding.clone().also(place, "needed here");
                *finding = needed;
            }
        }
    }

    /// First pass: every name, so that the order of the text does not matter.
    pub fn declare(
        &mut self,
        statements: &[&Statement],
        sources: &mut Sources,
        library: &super::Library,
    ) {
        for statement in statements {
            match &statement.kind {
                StatementKind::Urdf { file, options } => {
                    self.declare_robot(file, options, sources, library);
                }
                StatementKind::Frame { name, value } => self.declare_frame(name, value),
                StatementKind::Body(body) => self.declare_body(body),
                StatementKind::Coordinate { name, unit } => {
                    self.declare_coordinate(name, unit.as_ref(), &statement.doc);
                }
                StatementKind::Input { name, unit } => {
                    self.declare_input(name, unit.as_ref(), &statement.doc);
                }
                StatementKind::State { name, unit, .. } => {
                    self.declare_state(name, unit.as_ref(), &statement.doc);
                }
                StatementKind::Constant { name, unit, value } => {
                    let declared = unit.as_ref().and_then(|unit| self.dimension(unit));
                    self.declare_term(name, value, declared, true);
                }
                StatementKind::Let { name, value } => self.declare_term(name, value, None, false),
                _ => {}
            }
        }
        // Nominal values and bounds may use constants.
        for statement in statements {
            if let StatementKind::Parameter {
                name,
                unit,
                nominal,
                bounds,
                prior,
            } = &statement.kind
            {
                self.declare_parameter(
                    name,
                    unit.as_ref(),
                    nominal.as_ref(),
                    bounds.as_ref(),
                    prior.as_deref(),
                    &statement.doc,
                );
            }
        }
    }

    fn declare_coordinate(&mut self, name: &Name, unit: Option<&Unit>, doc: &str) {
        let dimension = unit.and_then(|unit| self.dimension(unit));
        let graph = &mut self.model.graph;
        let coordinate = Coordinate {
            name: name.text.clone(),
            dimension,
            unit: unit.map_or_else(String::new, unit_text),
            position: graph.symbol(format!("q_{}", name.text)),
            velocity: graph.symbol(format!("dq_{}", name.text)),
            doc: doc.to_string(),
        };
        let zero = graph.zero();
        let binding = Binding::Coordinate(self.model.coordinates.len());
        if self.bind(name, binding) {
            self.model.coordinates.push(coordinate);
            self.model.forces.push(zero);
        }
    }

    fn declare_input(&mut self, name: &Name, unit: Option<&Unit>, doc: &str) {
        if let Some(first) = self.scope.inputs.get(&name.text) {
            let first = first.span;
            self.duplicate(name, first);
            return;
        }
        let dimension = unit.and_then(|unit| self.dimension(unit));
        let symbol = self.model.graph.symbol(format!("u_{}", name.text));
        let arrives = self.model.graph.var(symbol);
        let input = Input {
            name: name.text.clone(),
            dimension,
            unit: unit.map_or_else(String::new, unit_text),
            symbol,
            arrives,
            doc: doc.to_string(),
            assumed: false,
        };
        self.push_input(input, name.span);
    }

    /// Adds an input whose name is free.
    pub fn push_input(&mut self, input: Input, span: Span) {
        let declared = Declared {
            what: self.model.inputs.len(),
            span,
        };
        self.scope.inputs.insert(input.name.clone(), declared);
        self.channels.push(input.arrives);
        self.model.inputs.push(input);
    }

    fn declare_term(
        &mut self,
        name: &Name,
        value: &Expr,
        declared: Option<Dimension>,
        constant: bool,
    ) {
        let binding = Binding::Term(self.scope.terms.len());
        if self.bind(name, binding) {
            let state = TermState::Waiting;
            self.scope.terms.push(Term {
                name: name.clone(),
                value: value.clone(),
                declared,
                state,
                constant,
            });
        }
    }

    fn declare_parameter(
        &mut self,
        name: &Name,
        unit: Option<&Unit>,
        nominal: Option<&Expr>,
        bounds: Option<&Bounds>,
        prior: Option<&Prior>,
        doc: &str,
    ) {
        let in_model = self.effect.is_none();
        let nominal_value = match nominal {
            Some(expr) => self.number(expr),
            None if in_model => self.report(
                Diagnostic::error(name.span, format!("parameter `{}` has no value", name.text))
                    .help(format!("give it one: `parameter {}: … = 1.0;`", name.text)),
            ),
            // An effect does nothing until its strength is known.
            None => Some(0.0),
        };
        let lower = bounds
            .and_then(|b| b.lower.as_ref())
            .map_or(Some(f64::NEG_INFINITY), |e| self.number(e));
        let upper = bounds
            .and_then(|b| b.upper.as_ref())
            .map_or(Some(f64::INFINITY), |e| self.number(e));
        let prior = prior.map(|p| self.prior(p));
        let dimension = unit.and_then(|unit| self.dimension(unit));
        let binding = Binding::Parameter(self.model.parameters.len());
        if !self.bind(name, binding) {
            return;
        }
        let full_name = format!("{}{}", self.prefix, name.text);
        if let Some(earlier) = self.model.parameters.iter().find(|p| p.name == full_name) {
            let message = format!("a parameter named `{}` exists already", earlier.name);
            self.report::<()>(Diagnostic::error(name.span, message));
        }
        let symbol = self.model.graph.symbol(full_name.clone());
        // Units of a template are written in terms of its ports: show them resolved.
        let unit = match (unit, dimension) {
            (Some(_), dimension) if self.effect.is_some() => {
                dimension.map_or_else(String::new, |d| d.to_string())
            }
            (Some(unit), _) => unit_text(unit),
            (None, _) => String::new(),
        };
        let (nominal_value, lower, upper) = (
            nominal_value.unwrap_or(0.0),
            lower.unwrap_or(f64::NEG_INFINITY),
            upper.unwrap_or(f64::INFINITY),
        );
        self.model.parameters.push(Parameter {
            name: full_name,
            dimension,
            unit,
            nominal: nominal_value,
            lower,
            upper,
            prior: prior.flatten(),
            symbol,
            effect: self.effect,
            doc: doc.to_string(),
        });
        let span = bounds.map_or(name.span, |b| b.span);
        if lower >= upper {
            self.report::<()>(Diagnostic::error(
                span,
                format!("no value lies between {lower} and {upper}"),
            ));
        } else if !(lower..=upper).contains(&nominal_value) {
            let message = format!(
                "the value {nominal_value} of `{}` is not in its bounds",
                name.text
            );
            let place = nominal.map_or(name.span, |e| e.span);
            self.report::<()>(Diagnostic::error(place, message).also(span, "the bounds"));
        }
    }

    fn prior(&mut self, prior: &Prior) -> Option<(f64, f64)> {
        let (mean, sd) = (self.number(&prior.mean)?, self.number(&prior.sd)?);
        if sd > 0.0 {
            return Some((mean, sd));
        }
        self.report(Diagnostic::error(
            prior.sd.span,
            "a standard deviation is greater than zero",
        ))
    }

    /// The value of an expression of numbers and constants.
    pub fn number(&mut self, expr: &Expr) -> Option<f64> {
        let quantity = self.lower(expr)?;
        match self.model.graph.as_constant(quantity.expr) {
            Some(value) => Some(value),
            None => self.report(
                Diagnostic::error(expr.span, "expected a number")
                    .label("this may vary")
                    .help("numbers and constants only: `0.5`, `pi/4`, `-g0`"),
            ),
        }
    }

    /// Binds a plain word; `false` (and a finding) if it is taken.
    pub fn bind(&mut self, name: &Name, what: Binding) -> bool {
        if RESERVED.contains(&name.text.as_str()) {
            let message = format!(
                "`{}` has a meaning of its own and cannot be redefined",
                name.text
            );
            self.report::<()>(Diagnostic::error(name.span, message));
            return false;
        }
        let taken = self
            .scope
            .names
            .get(&name.text)
            .map(|declared| declared.span);
        if let Some(first) = taken {
            self.duplicate(name, first);
            return false;
        }
        self.scope.names.insert(
            name.text.clone(),
            Declared {
                what,
                span: name.span,
            },
        );
        true
    }

    pub fn duplicate(&mut self, name: &Name, first: Span) {
        self.report::<()>(
            Diagnostic::error(name.span, format!("`{}` is defined twice", name.text))
                .label("again here")
                .also(first, "first here"),
        );
    }

    /// The dimension of a unit as written; `None` (and a finding) if it is unknown.
    pub(super) fn dimension(&mut self, unit: &Unit) -> Option<Dimension> {
        let mut product = Dimension::ONE;
        for factor in &unit.factors {
            let base = match &factor.base {
                UnitBase::One => Some(Dimension::ONE),
                UnitBase::Named(name) => Dimension::of_unit(name).or_else(|| {
                    let error = Diagnostic::error(factor.span, format!("`{name}` is not a unit of the SI"));
                    self.report(error.help(
                        "units are products of m, kg, s, A, K, rad, N, J, W, Pa, V, …; prefixes and degrees are not known: convert the number",
                    ))
                }),
                UnitBase::OfPort { function, port } => match self.unit_of_port(function, port)? {
                    Some(dimension) => Some(dimension),
                    // The model leaves the port's unit open: so is this one.
                    None => return None,
                },
            };
            product = product * base?.powi(factor.exponent);
        }
        Some(product)
    }

    /// `unit(port)`, `rate(port)`, `torque(port)`; the inner `None` if the model
    /// does not state the port's unit.
    fn unit_of_port(&mut self, function: &Name, port: &Name) -> Option<Option<Dimension>> {
        let Some(&(kind, index)) = self.scope.ports.get(&port.text) else {
            return self.report(
                Diagnostic::error(
                    port.span,
                    format!("`{}` is not a port of this effect", port.text),
                )
                .help(
                    "a unit follows from a port in effect templates only; in a model write it out",
                ),
            );
        };
        let declared = self.port_dimension(kind, index);
        let of = |f: fn(Dimension) -> Dimension| Some(declared.map(f));
        match function.text.as_str() {
            "unit" => of(|d| d),
            "rate" => of(Dimension::rate),
            "torque" => of(|d| Dimension::ENERGY / d),
            _ => self.report(
                Diagnostic::error(
                    function.span,
                    format!("there is no unit `{}(…)`", function.text),
                )
                .help(
                    "a unit may follow from a port by `unit(port)`, `rate(port)` or `torque(port)`",
                ),
            ),
        }
    }

    /// Matrices grow with the square of the model's size: what cannot be a model is
    /// refused before it fills the memory.
    fn refuse_excess(&mut self, heading: Span) {
        for (what, count) in [
            ("coordinates", self.model.coordinates.len()),
            ("inputs", self.model.inputs.len()),
            ("states", self.model.states.len()),
        ] {
            if count > MAX_SIZE {
                let message = format!("the model has {count} {what}; it may have {MAX_SIZE}");
                self.report::<()>(
                    Diagnostic::error(heading, message).help("split the model into smaller ones"),
                );
                self.too_large = true;
            }
        }
    }

    /// Second pass: expressions.
    pub fn lower_statements(&mut self, statements: &[&Statement]) {
        if self.too_large {
            return;
        }
        self.fold();
        for statement in statements {
            self.lower_statement(statement);
        }
        self.resolve_frames();
        // Terms that nothing uses are still checked.
        for index in 0..self.scope.terms.len() {
            self.resolve_term(index);
        }
    }

    fn lower_statement(&mut self, statement: &Statement) -> Option<()> {
        match &statement.kind {
            StatementKind::Kinetic(value) => {
                self.has_kinetic = true;
                let energy = self.energy(value, Dimension::ENERGY, "kinetic energy")?;
                self.model.kinetic = self.model.graph.add(self.model.kinetic, energy);
            }
            StatementKind::Potential(value) => {
                let energy = self.energy(value, Dimension::ENERGY, "potential energy")?;
                self.refuse_velocity(energy, value.span, "potential energy")?;
                self.model.potential = self.model.graph.add(self.model.potential, energy);
            }
            StatementKind::Dissipation(value) => {
                let power = self.energy(value, Dimension::ENERGY.rate(), "dissipation")?;
                self.model.dissipation = self.model.graph.add(self.model.dissipation, power);
            }
            StatementKind::Force { on, value } => self.lower_force(on, value)?,
            StatementKind::Channel { name, value } => self.lower_channel(name, value)?,
            StatementKind::Body(body) => {
                self.has_kinetic = true;
                self.lower_body(body, &statement.doc)?;
            }
            StatementKind::Gravity(components) => self.lower_gravity(components)?,
            StatementKind::PointForce(force) => self.lower_point_force(force)?,
            StatementKind::State { name, initial, .. } => {
                self.lower_initial(name, initial.as_ref())?
            }
            StatementKind::Rate { name, value } => self.lower_rate(name, value)?,
            StatementKind::Constraint { name, left, right } => {
                self.lower_constraint(name, left, right, &statement.doc)?;
            }
            StatementKind::Output { name, value } => {
                self.lower_output(name, value, &statement.doc)?;
            }
            _ => {}
        }
        Some(())
    }

    /// One output, or one per component of a vector: `output tip = position(tool);`.
    fn lower_output(&mut self, name: &Name, value: &Expr, doc: &str) -> Option<()> {
        let components = match &value.kind {
            ExprKind::Call(function, arguments) if VECTORS.contains(&function.text.as_str()) => {
                let vector = self.vector(function, arguments, value.span)?;
                let mut components = Vec::new();
                for (index, letter) in ["x", "y", "z"].into_iter().enumerate() {
                    let name = format!("{}_{letter}", name.text);
                    components.push((name, vector(self, index)?));
                }
                components
            }
            _ => vec![(name.text.clone(), self.lower(value)?)],
        };
        for (text, quantity) in components {
            if self.model.outputs.iter().any(|y| y.name == text) {
                let message = format!("there are two outputs named `{text}`");
                return self.report(Diagnostic::error(name.span, message));
            }
            self.model.outputs.push(Output {
                name: text,
                value: quantity.expr,
                dimension: quantity.measure.known(),
                doc: doc.to_string(),
            });
        }
        Some(())
    }

    fn energy(&mut self, value: &Expr, dimension: Dimension, role: &str) -> Option<ExprId> {
        let quantity = self.lower(value)?;
        self.expect_dimension(quantity, dimension, value.span, role)?;
        self.refuse_inputs(quantity.expr, value.span, role)?;
        Some(quantity.expr)
    }

    fn refuse_velocity(&mut self, expr: ExprId, span: Span, role: &str) -> Option<()> {
        let found = self
            .model
            .coordinates
            .iter()
            .find(|c| self.model.graph.depends_on(&[expr], c.velocity));
        match found.map(|c| c.name.clone()) {
            None if self.model.contains_velocity(expr) => self.report(Diagnostic::error(
                span,
                format!("{role} contains the velocity of a frame"),
            )),
            None => Some(()),
            Some(name) => self.report(Diagnostic::error(
                span,
                format!("{role} contains the velocity `dot({name})`"),
            )),
        }
    }

    fn refuse_inputs(&mut self, expr: ExprId, span: Span, role: &str) -> Option<()> {
        let found = self
            .model
            .inputs
            .iter()
            .find(|u| self.model.graph.depends_on(&[expr], u.symbol));
        match found.map(|u| u.name.clone()) {
            None => self.refuse_memory(expr, span, role),
            Some(name) => self.report(
                Diagnostic::error(span, format!("{role} contains the input `{name}`"))
                    .help("an input acts through `force`"),
            ),
        }
    }

    fn lower_force(&mut self, on: &Name, value: &Expr) -> Option<()> {
        let index = self.find_coordinate(on)?;
        let quantity = self.lower(value)?;
        if let Some(dimension) = self.model.coordinates[index].dimension {
            let role = format!("a force on `{}`", on.text);
            self.expect_dimension(quantity, Dimension::ENERGY / dimension, value.span, &role)?;
        }
        let sum = self
            .model
            .graph
            .add(self.model.forces[index], quantity.expr);
        self.model.forces[index] = sum;
        Some(())
    }

    /// The coordinate of this name, directly or through a port.
    pub fn find_coordinate(&mut self, name: &Name) -> Option<usize> {
        if let Some(&(PortKind::Coordinate, index)) = self.scope.ports.get(&name.text) {
            return Some(index);
        }
        if let Some(Declared {
            what: Binding::Coordinate(index),
            ..
        }) = self.scope.names.get(&name.text)
        {
            return Some(*index);
        }
        let known: Vec<String> = self
            .model
            .coordinates
            .iter()
            .map(|c| c.name.clone())
            .collect();
        self.unknown_place(name, "coordinate", &known)
    }

    /// The input of this name, directly or through a port.
    pub fn find_input(&mut self, name: &Name) -> Option<usize> {
        if let Some(&(PortKind::Input, index)) = self.scope.ports.get(&name.text) {
            return Some(index);
        }
        if let Some(declared) = self.scope.inputs.get(&name.text) {
            return Some(declared.what);
        }
        let known: Vec<String> = self.model.inputs.iter().map(|u| u.name.clone()).collect();
        self.unknown_place(name, "input", &known)
    }

    pub fn unknown_place<T>(&mut self, name: &Name, what: &str, known: &[String]) -> Option<T> {
        if self.unreadable_base || self.scope.unreadable.contains(&name.text) {
            return None;
        }
        let error = Diagnostic::error(
            name.span,
            format!("there is no {what} named `{}`", name.text),
        );
        self.report(
            match nearest(&name.text, known.iter().map(String::as_str)) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None if known.is_empty() => error.help(format!("the model declares no {what}")),
                None => error.help(format!("the model has: {}", known.join(", "))),
            },
        )
    }

    /// `input u = f(u)`: what arrived so far becomes the argument.
    fn lower_channel(&mut self, name: &Name, value: &Expr) -> Option<()> {
        let index = self.find_input(name)?;
        let quantity = self.lower(value)?;
        if let Some(dimension) = self.model.inputs[index].dimension {
            let role = format!("what arrives at `{}`", name.text);
            self.expect_dimension(quantity, dimension, value.span, &role)?;
        }
        let replacement = self.what_arrives(index, quantity.expr, value.span)?;
        self.channels[index] = self.model.graph.substitute(&[quantity.expr], &replacement)[0];
        Some(())
    }

    fn lower_constraint(
        &mut self,
        name: &Name,
        left: &Expr,
        right: &Expr,
        doc: &str,
    ) -> Option<()> {
        let (a, b) = (self.lower(left), self.lower(right));
        let (a, b): (Quantity, Quantity) = (a?, b?);
        let measure: Measure =
            self.unify(a.measure, left.span, b.measure, right.span, "equated")?;
        let span = left.span.to(right.span);
        if self.model.constraints.iter().any(|c| c.name == name.text) {
            let message = format!("there are two constraints named `{}`", name.text);
            return self.report(Diagnostic::error(name.span, message));
        }
        if self.model.constraints.len() == MAX_SIZE {
            let message = format!("the model has more than {MAX_SIZE} constraints");
            return self.report(Diagnostic::error(name.span, message));
        }
        let residual = self.model.graph.sub(a.expr, b.expr);
        self.refuse_inputs(residual, span, "a constraint")?;
        let graph = &self.model.graph;
        let kind = if self.model.contains_velocity(residual) {
            ConstraintKind::Nonholonomic
        } else if self.model.contains_position(residual) {
            ConstraintKind::Holonomic
        } else {
            return self.report(
                Diagnostic::error(span, "this constraint contains no coordinate")
                    .help("it would have to hold by itself; a constraint restricts coordinates or their rates"),
            );
        };
        let time_dependent = graph.depends_on(&[residual], self.model.time);
        self.model.constraints.push(Constraint {
            name: name.text.clone(),
            kind,
            time_dependent,
            residual,
            dimension: measure.known(),
            doc: doc.to_string(),
        });
        Some(())
    }

    /// Closes the model: puts the channels in, and looks at the whole.
    fn finish(mut self, heading: Span) -> Option<Model> {
        if self.too_large || !self.scope.unreadable.is_empty() || self.unreadable_base {
            return None;
        }
        if self.model.coordinates.is_empty() && self.model.robot.is_some() {
            let message = "the robot description has no joint that moves";
            self.report::<()>(Diagnostic::error(heading, message));
        } else if self.model.coordinates.is_empty() {
            self.report::<()>(
                Diagnostic::error(heading, "the model has no coordinate")
                    .help("declare what moves: `coordinate x: m;`"),
            );
        } else if !self.has_kinetic {
            self.report::<()>(
                Diagnostic::error(heading, "the model has no kinetic energy")
                    .help("state it, `kinetic m/2*dot(x)^2;`, or a body that has it"),
            );
        } else if self
            .diagnostics
            .iter()
            .all(|d| d.severity != Severity::Error)
        {
            self.look_for_inertia();
        }
        self.refuse_states_without_rate();
        self.put_channels_into_forces(heading);
        for (input, &arrives) in self.model.inputs.iter_mut().zip(&self.channels) {
            input.arrives = arrives;
        }
        self.drop_idle_delays();
        self.model.set_folded_aside(self.variables);
        if !self.failed() {
            self.prepare_tree(heading);
        }
        (!self.failed()).then_some(self.model)
    }

    /// Makes the tree ready for derivation, if there is more to it than the world.
    fn prepare_tree(&mut self, heading: Span) {
        if self.model.tree.bodies.len() == 1 {
            return;
        }
        self.model.tree.coordinates = self.model.coordinates.len();
        // What a file rounds has been rounded when it was read.
        let options = Options {
            snap: None,
            ..Options::default()
        };
        let read: Vec<usize> = (self.model.kinematics.iter().map(|k| k.frame))
            .chain(self.model.point_forces.iter().map(|force| force.frame))
            .collect();
        let graph = &mut self.model.graph;
        let is_read = |body: usize| read.contains(&body);
        match Mechanism::with_frames(graph, &self.model.tree, options, is_read) {
            Ok(mechanism) => self.model.mechanism = Some(mechanism),
            Err(error) => {
                let message = format!("the bodies do not form a machine: {error}");
                self.report::<()>(Diagnostic::error(heading, message));
            }
        }
    }

    /// What has been found so far.
    pub fn findings(&self) -> &[Diagnostic] {
        self.diagnostics
    }

    /// A coordinate without kinetic energy makes `M` singular: allowed (a
    /// constraint may carry it), but worth a word.
    fn look_for_inertia(&mut self) {
        for index in 0..self.model.coordinates.len() {
            let coordinate = &self.model.coordinates[index];
            let in_energy = [self.model.kinetic];
            if self.moves_bodies(index)
                || self.model.graph.depends_on(&in_energy, coordinate.velocity)
            {
                continue;
            }
            let name = coordinate.name.clone();
            let Some(span) = self.scope.names.get(&name).map(|declared| declared.span) else {
                continue;
            };
            self.report::<()>(
                Diagnostic::warning(
                    span,
                    format!("`{name}` has no kinetic energy: the mass matrix is singular"),
                )
                .help("fine if constraints determine it; otherwise add its part to `kinetic`"),
            );
        }
    }
}

/// A tree of nothing but the world.
fn world(zero: ExprId) -> Tree {
    let placement = Placement {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [zero; 3],
    };
    let world = Body {
        name: "world".to_string(),
        parent: None,
        placement,
        joint: Joint::Fixed,
        inertia: Inertia {
            mass: zero,
            center: [zero; 3],
            tensor: [[zero; 3]; 3],
        },
    };
    Tree {
        bodies: vec![world],
        gravity: [zero; 3],
        coordinates: 0,
    }
}

/// A unit as written, normalised.
pub(super) fn unit_text(unit: &Unit) -> String {
    let mut text = String::new();
    for (position, factor) in unit.factors.iter().enumerate() {
        let base = match &factor.base {
            UnitBase::One => "1".to_string(),
            UnitBase::Named(name) => name.clone(),
            UnitBase::OfPort { function, port } => format!("{}({})", function.text, port.text),
        };
        if position > 0 {
            text.push(if factor.exponent < 0 { '/' } else { '*' });
        }
        text.push_str(&base);
        let power = if position > 0 {
            factor.exponent.abs()
        } else {
            factor.exponent
        };
        if power != 1 {
            text.push_str(&format!("^{power}"));
        }
    }
    text
}
