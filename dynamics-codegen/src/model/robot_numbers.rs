//! The numbers of a robot description: constants, or parameters where the model says so.

use super::Parameter;
use super::builder::Builder;
use super::names::Binding;
use super::robot::{Assembly, Described};
use super::robot_options::Chosen;
use crate::dimension::Dimension;
use crate::emit::identifier;
use crate::graph::ExprId;
use crate::robot::{self, Joint, JointKind, Losses};
use crate::source::Span;
use crate::syntax::Name;
use crate::tree;

impl Assembly<'_, '_> {
    /// Where a body's joint stands on its parent. `origins: all` frees the lengths that the
    /// description has, a joint's name all three of its.
    pub(super) fn placement(&mut self, index: usize) -> tree::Placement {
        let Some(joint) = &self.robot.bodies[index].joint else {
            let graph = &mut self.builder.model.graph;
            let robot::Placement {
                rotation,
                translation,
            } = robot::Placement::IDENTITY;
            return tree::Placement {
                rotation,
                translation: translation.map(|x| graph.constant(x)),
            };
        };
        let Chosen { all, .. } = self.options.origins;
        let named = self.options.origins.names(&joint.name);
        let given = joint.placement.translation;
        let entries = [("x", given[0]), ("y", given[1]), ("z", given[2])];
        let translation = entries.map(|(axis, value)| {
            if named || (all && value != 0.0 && !joint.name.is_empty()) {
                let described = Described {
                    parameter: format!("{}_origin_{axis}", identifier(&joint.name)),
                    option: "origins",
                    of: joint.name.clone(),
                };
                let any = f64::NEG_INFINITY;
                self.builder
                    .described_parameter(described, joint.span, "m", any, value)
            } else {
                self.builder.model.graph.constant(value)
            }
        });
        tree::Placement {
            rotation: joint.placement.rotation,
            translation,
        }
    }

    /// Damping and dry friction of a joint. `friction: all` frees those that the description states, and so does a
    /// joint's name; of joints with one freedom of their own. With the values that the model gives them.
    pub(super) fn loss(
        &mut self,
        joint: &Joint,
        given: Losses,
        follows: bool,
    ) -> [(ExprId, f64); 2] {
        let units = match joint.kind {
            JointKind::Revolute { .. } => Some(["N*m*s", "N*m"]),
            JointKind::Prismatic { .. } => Some(["N*s/m", "N"]),
            _ => None,
        };
        let is_free = self.options.friction.includes(&joint.name) && !follows;
        let units = units.filter(|_| is_free);
        let [damping, friction] = units.map_or([None; 2], |units| units.map(Some));
        let stated = [
            ("damping", damping, given.damping),
            ("friction", friction, given.friction),
        ];
        stated.map(|(what, unit, value)| match unit.filter(|_| value != 0.0) {
            Some(unit) => {
                let described = Described {
                    parameter: format!("{}_{what}", identifier(&joint.name)),
                    option: "friction",
                    of: joint.name.clone(),
                };
                let name = described.parameter.clone();
                let entry =
                    (self.builder).described_parameter(described, joint.span, unit, 0.0, value);
                let mut parameters = self.builder.model.parameters.iter();
                let stated = parameters.find(|p| p.name == name);
                (entry, stated.map_or(value, |p| p.nominal))
            }
            None => (self.builder.model.graph.constant(value), value),
        })
    }

    pub(super) fn inertia(&mut self, index: usize) -> tree::Inertia {
        let body = &self.robot.bodies[index];
        let given = &body.inertia;
        let Chosen { all, .. } = self.options.parameters;
        let free = self.options.parameters.names(&body.link) || (all && !given.is_zero());
        let mut entry = |what: &str, unit: &str, lower: f64, value: f64| {
            if free {
                let described = Described {
                    parameter: format!("{}_{what}", identifier(&body.link)),
                    option: "parameters",
                    of: body.link.clone(),
                };
                self.builder
                    .described_parameter(described, body.span, unit, lower, value)
            } else {
                self.builder.model.graph.constant(value)
            }
        };
        let mass = entry("mass", "kg", 0.0, given.mass);
        let any = f64::NEG_INFINITY;
        let center = [("cx", 0), ("cy", 1), ("cz", 2)]
            .map(|(what, i)| entry(what, "m", any, given.center[i]));
        let mut tensor = [[mass; 3]; 3];
        for (what, i, j) in [
            ("ixx", 0, 0),
            ("iyy", 1, 1),
            ("izz", 2, 2),
            ("ixy", 0, 1),
            ("ixz", 0, 2),
            ("iyz", 1, 2),
        ] {
            let lower = if i == j { 0.0 } else { any };
            let value = entry(what, "kg*m^2", lower, given.tensor[i][j]);
            tensor[i][j] = value;
            tensor[j][i] = value;
        }
        tree::Inertia {
            mass,
            center,
            tensor,
        }
    }
}

impl Builder<'_> {
    /// `<link>_mass`, `<link>_cx`, …, `<link>_iyz`, `<joint>_origin_x`, ….
    fn described_parameter(
        &mut self,
        described: Described,
        span: Span,
        unit: &str,
        lower: f64,
        value: f64,
    ) -> ExprId {
        let full_name = described.parameter.clone();
        let (value, belief) = self.stated_for_robot(&full_name, lower, value);
        let name = Name {
            text: full_name.clone(),
            span,
        };
        let index = self.model.parameters.len();
        if !self.bind(&name, Binding::Parameter(index)) {
            return self.model.graph.constant(value);
        }
        let symbol = self.model.graph.symbol(full_name.clone());
        let of = |unit| Dimension::of_unit(unit).unwrap_or_default();
        let dimension = match unit {
            "kg*m^2" => of("kg") * Dimension::LENGTH.powi(2),
            "N*m*s" => of("Nm") * of("s"),
            "N*m" => of("Nm"),
            "N*s/m" => of("N") * of("s") * Dimension::LENGTH.powi(-1),
            unit => of(unit),
        };
        self.model.parameters.push(Parameter {
            name: full_name,
            dimension: Some(dimension),
            unit: unit.to_string(),
            nominal: value,
            default: value,
            lower,
            upper: f64::INFINITY,
            belief,
            tries: None,
            symbol,
            effect: None,
            doc: String::new(),
        });
        if let Some(robot) = &mut self.model.robot {
            robot.described.push(described);
        }
        // The description's values are final, and bodies are built at once.
        self.fold_parameter(index);
        self.model.graph.var(symbol)
    }
}
