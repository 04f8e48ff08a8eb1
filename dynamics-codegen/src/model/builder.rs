//! Statements to a model: names declared, then everything lowered.

use super::effects::Templates;
use super::names::Scope;
use super::{Model, PartUse};
use crate::diagnostic::{Diagnostic, nearest};
use crate::graph::{ExprId, Graph};
use crate::source::{Sources, Span};
use crate::syntax::{File, Heading, Statement, StatementKind};
use crate::tree::{Body, Inertia, Joint, Placement, Tree};

/// A model may have this many coordinates, inputs and constraints.
pub(super) const MAX_SIZE: usize = 256;
/// Behind this many findings it is no longer said which name was meant: nobody reads so many,
/// and to look among all names each time takes as long as findings times names.
const MAX_SUGGESTIONS: usize = 100;

/// Builds the model that `file` describes. Findings are added to `diagnostics`;
/// `None` if there is an error among them.
pub(crate) fn build(
    file: &File,
    uses: Vec<PartUse>,
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
    builder.model.uses = uses;
    let statements: Vec<&Statement> = file.statements.iter().collect();
    let states_gravity = |s: &&Statement| matches!(s.kind, StatementKind::Gravity(_));
    builder.states_gravity = statements.iter().any(states_gravity);
    builder.declare(&statements, sources, library);
    let unreadable = file.unreadable.iter().map(|name| name.text.clone());
    builder.scope.unreadable.extend(unreadable);
    builder.refuse_excess(name.span);
    builder.wrong.note(&statements);
    builder.lower_statements(&statements);
    Templates { sources, library }.apply_all(&mut builder, &statements);
    builder.lower_sensors(&statements);
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
    /// Which of several an effect is being applied to, for the names of its states; empty, if to one.
    pub member: String,
    /// The effect at hand, while one is being applied.
    pub effect: Option<usize>,
    /// Which parameters are not folded in.
    pub variables: &'a super::Variables,
    diagnostics: &'a mut Vec<Diagnostic>,
    /// What each input's channel does, composed in the order of the text.
    pub(super) channels: Vec<ExprId>,
    /// Beside [`Model::states`]: where each is declared and given its rate.
    pub(super) state_notes: Vec<super::state::StateNotes>,
    /// What the inputs exert, wherever something asks for it.
    pub(super) loads: Vec<super::contact::Load>,
    /// The forces that inputs make, per coordinate.
    pub(super) driven: Vec<(usize, ExprId)>,
    /// Sets of the ports that are being bound.
    pub(super) pending_sets: std::collections::BTreeMap<String, Vec<usize>>,
    /// Whether a sensor is being lowered: it sees accelerations.
    pub(super) in_sensor: bool,
    /// What sensors that read wrongly read.
    pub(super) wrong: super::sensed::WrongSensors,
    /// Where sensors of frames are mounted.
    pub(super) mounts: super::mounted::Mounts,
    /// How many statements say what is measured.
    pub(super) measurements: usize,
    pub has_kinetic: bool,
    pub too_large: bool,
    /// Whether the model says itself what gravity is.
    pub states_gravity: bool,
    /// The file name of the robot description, as a model beside it would name it.
    pub(super) description: String,
    /// Whether the robot description underneath could not be read: what it holds is
    /// not there, and not to be complained about.
    pub unreadable_base: bool,
    /// Values of the model's own for what the description says.
    pub(super) restated: super::restated::Restated,
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
            poses: Vec::new(),
            inputs: Vec::new(),
            measured: Vec::new(),
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
            contacts: Vec::new(),
            outputs: Vec::new(),
            sensors: Vec::new(),
            boards: Vec::new(),
            accelerations: Vec::new(),
            effects: Vec::new(),
            tables: Vec::new(),
            uses: Vec::new(),
        };
        Self {
            model,
            scope: Scope::default(),
            term_path: Vec::new(),
            prefix: String::new(),
            member: String::new(),
            effect: None,
            variables,
            diagnostics,
            channels: Vec::new(),
            state_notes: Vec::new(),
            loads: Vec::new(),
            driven: Vec::new(),
            pending_sets: std::collections::BTreeMap::new(),
            in_sensor: false,
            wrong: super::sensed::WrongSensors::default(),
            mounts: super::mounted::Mounts::default(),
            measurements: 0,
            has_kinetic: false,
            too_large: false,
            states_gravity: false,
            description: String::new(),
            unreadable_base: false,
            restated: super::restated::Restated::default(),
        }
    }

    /// Reports a finding; always `None`, so that it can end a lowering.
    pub fn report<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.diagnostics.push(diagnostic);
        None
    }

    /// The name among `known` that may have been meant by `name`.
    pub fn near<'n>(
        &self,
        name: &str,
        known: impl IntoIterator<Item = &'n str>,
    ) -> Option<&'n str> {
        let worth_it = self.diagnostics.len() < MAX_SUGGESTIONS;
        worth_it.then(|| nearest(name, known)).flatten()
    }

    /// What has been found so far.
    pub fn findings(&self) -> &[Diagnostic] {
        self.diagnostics
    }

    /// How many findings there are.
    pub fn finding_count(&self) -> usize {
        self.diagnostics.len()
    }

    /// Takes the findings behind the first `count` back: they will be found again.
    pub fn forget(&mut self, count: usize) {
        self.diagnostics.truncate(count);
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
        // Constraints name contacts, forces name constraints.
        let is_contact = |s: &&&Statement| matches!(s.kind, StatementKind::Contact(_));
        for statement in statements.iter().filter(is_contact) {
            self.lower_statement(statement);
        }
        let is_constraint = |s: &&&Statement| matches!(s.kind, StatementKind::Constraint { .. });
        for statement in statements.iter().filter(is_constraint) {
            self.lower_statement(statement);
        }
        for statement in statements
            .iter()
            .filter(|s| !is_constraint(s) && !is_contact(s))
        {
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
            StatementKind::Kinetic(value) => self.lower_kinetic(value)?,
            StatementKind::Potential(value) => self.lower_potential(value)?,
            StatementKind::Dissipation(value) => self.lower_dissipation(value)?,
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
            StatementKind::Measured { name, value } => self.lower_measured(name, value)?,
            StatementKind::Mounted { name, value } => self.lower_mounted(name, value)?,
            StatementKind::Constraint {
                name,
                when,
                left,
                right,
            } => {
                self.lower_constraint(name, left, right, &statement.doc)?;
                self.lower_switch(when.as_ref())?;
            }
            StatementKind::Term { .. } if self.effect.is_none() => {
                let message = "a `term` stands in an effect template, not in a model";
                self.report(Diagnostic::error(statement.span, message))?;
            }
            StatementKind::Contact(contact) => self.lower_unilateral(contact, &statement.doc)?,
            StatementKind::Output { name, value } => {
                self.lower_output(name, value, &statement.doc)?;
            }
            _ => {}
        }
        Some(())
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
