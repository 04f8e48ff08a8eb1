//! Units as written: their dimension, and their text.

use super::builder::Builder;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::syntax::{Name, PortKind, Unit, UnitBase, UnitFactor};

impl Builder<'_> {
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

    /// The text of a template's unit, in terms of what its ports are. An angle is no dimension, but
    /// where one is left alone or over time it says what turns: `rad/s`, not `1/s`.
    pub(super) fn resolved_unit(&self, unit: &Unit, dimension: Dimension) -> String {
        let text = dimension.to_string();
        let angles: i32 = unit.factors.iter().map(|factor| self.angles(factor)).sum();
        match text.strip_prefix('1') {
            Some(rest) if angles == 1 => format!("rad{rest}"),
            _ => text,
        }
    }

    /// The unit that a coordinate, an input or a sensor is declared with.
    fn port_unit(&self, kind: PortKind, index: usize) -> Option<&str> {
        match kind {
            PortKind::Coordinate | PortKind::Coordinates => {
                Some(&self.model.coordinates[index].unit)
            }
            PortKind::Input => Some(&self.model.inputs[index].unit),
            PortKind::Sensor | PortKind::Reading => Some(&self.wrong.known[index].unit),
            PortKind::Drive if self.model.inputs[index].unit == "N*m" => Some("rad"),
            PortKind::Constraint | PortKind::Body | PortKind::Frame | PortKind::Drive => None,
        }
    }

    /// The power of an angle in a factor.
    fn angles(&self, factor: &UnitFactor) -> i32 {
        let by = match &factor.base {
            UnitBase::Named(name) if name == "rad" => 1,
            UnitBase::OfPort { function, port } => {
                let port = self.scope.ports.get(&port.text);
                let declared = port.and_then(|&(kind, index)| self.port_unit(kind, index));
                match function.text.as_str() {
                    _ if declared != Some("rad") => 0,
                    "torque" => -1,
                    _ => 1,
                }
            }
            _ => 0,
        };
        by * factor.exponent
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

#[cfg(test)]
mod tests {
    use crate::{Library, compile};

    /// What turns says so, in effects as in models; forces and lengths are as they were.
    #[test]
    fn an_angle_left_alone_keeps_its_name() {
        let text = "model a; coordinate j: rad; coordinate x: m; parameter m: kg = 1;
                    kinetic m/2*dot(x)^2; kinetic m*x^2/2*dot(j)^2;
                    effect coulomb(j); effect coulomb(x); effect spring(j);";
        let model = compile("a", text, &Library::builtin()).unwrap().model;
        let unit = |name: &str| {
            let mut parameters = model.parameters.iter();
            let found = parameters.find(|p| p.name == name);
            found.unwrap_or_else(|| panic!("{name}")).unit.clone()
        };
        assert_eq!(unit("coulomb_j_v_s"), "rad/s");
        assert_eq!(unit("coulomb_x_v_s"), "m/s");
        assert_eq!(unit("spring_j_q_0"), "rad");
        assert_eq!(unit("coulomb_j_f_c"), "N*m");
        assert_eq!(unit("coulomb_x_f_c"), "N");
        assert_eq!(unit("spring_j_k"), "N*m");
    }
}
