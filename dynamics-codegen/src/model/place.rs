//! What a name in `force x = …` or `effect e(x);` stands for.

use super::builder::Builder;
use super::names::{Binding, Declared};
use crate::diagnostic::Diagnostic;
use crate::syntax::{Name, PortKind};

impl Builder<'_> {
    /// What a port of this kind is bound to by a name, with the kind that this is.
    pub(super) fn find_port(&mut self, kind: PortKind, place: &Name) -> Option<(PortKind, usize)> {
        let index = match kind {
            PortKind::Reading => return self.find_reading(place),
            PortKind::Sensor => self.find_sensor(place)?,
            PortKind::Frame => self.find_frame(&place.text, place.span)?,
            PortKind::Coordinate | PortKind::Coordinates => self.find_coordinate(place)?,
            PortKind::Input => self.find_input(place)?,
            PortKind::Drive => self.find_drive(place)?,
            PortKind::Body => self.find_body(&place.text, place.span)?,
            PortKind::Constraint => self.find_constraint(place)?,
        };
        Some((kind, index))
    }

    /// The coordinate of this name, directly or through a port.
    pub(super) fn find_coordinate(&mut self, name: &Name) -> Option<usize> {
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
    pub(super) fn find_input(&mut self, name: &Name) -> Option<usize> {
        if let Some(&(PortKind::Input, index)) = self.scope.ports.get(&name.text) {
            return Some(index);
        }
        if let Some(declared) = self.scope.inputs.get(&name.text) {
            return Some(declared.what);
        }
        let known: Vec<String> = self.model.inputs.iter().map(|u| u.name.clone()).collect();
        self.unknown_place(name, "input", &known)
    }

    /// The coordinate or the sensor of this name, directly or through a port, with which of the two
    /// it is.
    pub(super) fn find_reading(&mut self, name: &Name) -> Option<(PortKind, usize)> {
        if let Some(&(kind @ (PortKind::Coordinate | PortKind::Sensor), index)) =
            self.scope.ports.get(&name.text)
        {
            return Some((kind, index));
        }
        if self.sees_sensor(&name.text) {
            return self
                .find_sensor(name)
                .map(|index| (PortKind::Sensor, index));
        }
        if let Some(Declared {
            what: Binding::Coordinate(index),
            ..
        }) = self.scope.names.get(&name.text)
        {
            return Some((PortKind::Coordinate, *index));
        }
        self.refuse_vector(name)?;
        let coordinates = self.model.coordinates.iter().map(|c| c.name.clone());
        let known: Vec<String> = coordinates.chain(self.visible_sensors()).collect();
        self.unknown_place(name, "coordinate or sensor", &known)
    }

    /// The sensor, or the component of one, of this name, directly or through a port.
    pub(super) fn find_sensor(&mut self, name: &Name) -> Option<usize> {
        if let Some(&(PortKind::Sensor, index)) = self.scope.ports.get(&name.text) {
            return Some(index);
        }
        if self.sees_sensor(&name.text) {
            return Some(self.note_sensor(&name.text));
        }
        self.refuse_vector(name)?;
        let known = self.visible_sensors();
        self.unknown_place(name, "sensor", &known)
    }

    pub(super) fn unknown_place<T>(
        &mut self,
        name: &Name,
        what: &str,
        known: &[String],
    ) -> Option<T> {
        if self.unreadable_base || self.scope.is_unreadable(&name.text) {
            return None;
        }
        // A name in quotes may have a `.` of its own.
        if let Some((head, _)) = name.text.split_once('.')
            && self.near_use(head).is_some()
        {
            return self.unknown_use(head, name.span);
        }
        let error = Diagnostic::error(
            name.span,
            format!("there is no {what} named `{}`", name.text),
        );
        self.report(
            match self.near(&name.text, known.iter().map(String::as_str)) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None if known.len() > 20 => error,
                None if known.is_empty() => error.help(format!("the model declares no {what}")),
                None => error.help(format!("the model has: {}", known.join(", "))),
            },
        )
    }
}
