//! What a name stands for where a number is wanted.

use super::builder::Builder;
use super::configuration::POSE;
use super::lower::Lowered;
use super::names::Binding;
use super::quantity::{Measure, Quantity};
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::source::Span;
use crate::syntax::PortKind;

impl Builder<'_> {
    pub(super) fn lower_name(&mut self, name: &str, span: Span) -> Lowered {
        if let Some(reading) = self.reading(name) {
            return Some(reading);
        }
        if name == "t" {
            let expr = self.model.graph.var(self.model.time);
            return Some(Quantity {
                expr,
                measure: Measure::Known(Dimension::TIME),
            });
        }
        if name == "pi" {
            let expr = self.model.graph.constant(std::f64::consts::PI);
            return Some(Quantity {
                expr,
                measure: Measure::Bare,
            });
        }
        if let Some(&(kind, index)) = self.scope.ports.get(name) {
            return match kind {
                PortKind::Coordinate => self.position(index),
                PortKind::Input => self.input_symbol(index),
                PortKind::Coordinates => self.lower_set_member(name, span),
                PortKind::Constraint => {
                    let message = format!("`{name}` is a constraint, not a number");
                    let help = format!("read its force: `normal_force({name})`");
                    self.report(Diagnostic::error(span, message).help(help))
                }
                PortKind::Sensor | PortKind::Reading => self.refuse_reading(name, span),
                PortKind::Frame => {
                    let message = format!("`{name}` is a frame, not a number");
                    let help = format!("read something off it: `position({name}).x`");
                    self.report(Diagnostic::error(span, message).help(help))
                }
                PortKind::Drive => {
                    let message = format!("`{name}` is a drive, not a number");
                    let help = format!("read how fast it turns: `dot({name})`");
                    self.report(Diagnostic::error(span, message).help(help))
                }
                PortKind::Body => {
                    let message = format!("`{name}` is a body, not a number");
                    let help =
                        format!("read something off it: `position({name}).x`, `mass({name})`");
                    self.report(Diagnostic::error(span, message).help(help))
                }
            };
        }
        match self
            .scope
            .names
            .get(name)
            .map(|declared| declared.what.clone())
        {
            Some(Binding::Coordinate(index)) => self.position(index),
            Some(Binding::Pose(pose, entry)) => self.pose_entry(pose, entry),
            Some(Binding::Parameter(index)) => {
                let parameter = &self.model.parameters[index];
                let measure = Measure::of(parameter.dimension);
                Some(Quantity {
                    expr: self.model.graph.var(parameter.symbol),
                    measure,
                })
            }
            Some(Binding::State(index)) => self.state_symbol(index),
            Some(Binding::Term(index)) => self.lower_term(index, name, span),
            None => match self.scope.inputs.get(name).map(|declared| declared.what) {
                Some(index) => self.input_symbol(index),
                None => self.unknown_name(name, span),
            },
        }
    }

    /// The position of a coordinate; of a twist's component, which has none, that component.
    pub(super) fn position(&self, index: usize) -> Lowered {
        let coordinate = &self.model.coordinates[index];
        if self.model.pose_of(index).is_some() {
            return Some(Quantity {
                expr: self.model.graph.var(coordinate.velocity),
                measure: Measure::of(coordinate.dimension).rate(),
            });
        }
        let expr = self.model.graph.var(coordinate.position);
        Some(Quantity {
            expr,
            measure: Measure::of(coordinate.dimension),
        })
    }

    /// One of the seven positions of a body that floats by its twist.
    fn pose_entry(&self, pose: usize, entry: usize) -> Lowered {
        let symbol = self.model.poses[pose].symbols().nth(entry)?;
        let dimension = match POSE[entry].1 {
            "m" => Dimension::LENGTH,
            _ => Dimension::ONE,
        };
        Some(Quantity {
            expr: self.model.graph.var(symbol),
            measure: Measure::Known(dimension),
        })
    }

    pub(super) fn input_symbol(&self, index: usize) -> Lowered {
        let input = &self.model.inputs[index];
        let expr = self.model.graph.var(input.symbol);
        Some(Quantity {
            expr,
            measure: Measure::of(input.dimension),
        })
    }
}
