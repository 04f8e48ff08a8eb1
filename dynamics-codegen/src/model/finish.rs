//! The end of the building: channels and loads put in, the whole looked at.

use super::Model;
use super::builder::Builder;
use crate::diagnostic::{Diagnostic, Severity};
use crate::robot::Format;
use crate::source::Span;
use crate::tree::{Mechanism, Options};

impl Builder<'_> {
    /// Closes the model: puts the channels in, and looks at the whole.
    pub(super) fn finish(mut self, heading: Span) -> Option<Model> {
        if self.too_large || !self.scope.unreadable.is_empty() || self.unreadable_base {
            return None;
        }
        self.check_motion(heading);
        self.refuse_states_without_rate();
        self.put_loads_into_forces();
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

    /// Something moves, and has inertia.
    fn check_motion(&mut self, heading: Span) {
        if self.model.coordinates.is_empty() && self.model.robot.is_some() {
            let message = "the robot description has no joint that moves";
            let format = self.model.robot.as_ref().map(|robot| robot.format);
            let help = match format {
                Some(Format::Mjcf) => "a body that moves freely has a `<freejoint/>`".to_string(),
                _ => format!(
                    "a body that moves freely is a model of two lines, in a file beside the description: `model free;` and `urdf {:?} {{ base: floating; }}`",
                    self.description
                ),
            };
            self.report::<()>(Diagnostic::error(heading, message).help(help));
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
            .findings()
            .iter()
            .all(|d| d.severity != Severity::Error)
        {
            self.look_for_inertia();
        }
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
