//! What drives the joints of a robot description, and what stores energy in them.

use super::Input;
use super::robot::Assembly;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::robot::Joint;
use crate::source::Span;
use crate::tree;

impl Assembly<'_, '_> {
    /// The inputs of a joint: its actuators, or a torque or force of its name. Unless the model says
    /// which joints are driven, they are those that have an actuator, and all if none has.
    pub(super) fn drive(&mut self, index: usize, joint: &Joint, effort: &str, on: usize) {
        let robot = self.robot;
        let own = robot.actuators.iter().filter(|drive| drive.body == index);
        let own: Vec<_> = own.collect();
        let driven = match &self.options.inputs {
            None => robot.actuators.is_empty() || !own.is_empty(),
            Some(chosen) => chosen.includes(&joint.name),
        };
        if driven && own.is_empty() {
            self.input(&joint.name, effort, joint.span, on, 1.0);
        }
        for drive in own.into_iter().filter(|_| driven) {
            self.input(&drive.name, effort, drive.span, on, drive.gear);
        }
    }

    fn input(&mut self, name: &str, unit: &str, span: Span, on: usize, gear: f64) {
        if let Some(first) = self.builder.scope.inputs.get(name) {
            let message = format!("two inputs are called `{name}`");
            let error = Diagnostic::error(span, message).also(first.span, "the first");
            let error = error.help("rename the actuator or the joint");
            self.builder.report::<()>(error);
            return;
        }
        let model = &mut self.builder.model;
        let symbol = model.graph.symbol(format!("u_{name}"));
        let arrives = model.graph.var(symbol);
        let force = model.graph.scale(gear, arrives);
        model.forces[on] = model.graph.add(model.forces[on], force);
        let input = Input {
            name: name.to_string(),
            dimension: Some(match unit {
                "N" => Dimension::ENERGY / Dimension::LENGTH,
                _ => Dimension::ENERGY,
            }),
            unit: unit.to_string(),
            symbol,
            arrives,
            doc: String::new(),
            assumed: true,
        };
        self.builder.push_input(input, span);
        self.builder.note_driven(on, force);
    }

    /// Of a joint's rotor, `armature v²/2`, and of its spring, `stiffness (q − rest)²/2`.
    pub(super) fn energies(&mut self, joint: &Joint, coordinate: &tree::Coordinate) {
        let model = &mut self.builder.model;
        let graph = &mut model.graph;
        if joint.armature != 0.0 {
            let square = graph.mul(coordinate.v, coordinate.v);
            let energy = graph.scale(0.5 * joint.armature, square);
            model.kinetic = graph.add(model.kinetic, energy);
        }
        if let Some(spring) = joint.spring {
            let rest = graph.constant(spring.rest);
            let stretch = graph.sub(coordinate.q, rest);
            let square = graph.mul(stretch, stretch);
            let energy = graph.scale(0.5 * spring.stiffness, square);
            model.potential = graph.add(model.potential, energy);
        }
    }
}
