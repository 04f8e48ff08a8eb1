//! What single links and joints mean: origins, axes, limits, losses, inertias.

use super::records::{JointRecord, LinkRecord, child};
use super::values::{quaternion, version};
use crate::diagnostic::Diagnostic;
use crate::robot::spatial::{dot, rotation_from_quaternion, rotation_from_rpy};
use crate::robot::text::shown;
use crate::robot::xml::Places;
use crate::robot::{Inertia, JointKind, Limits, Losses, Options, Placement, Snapped, Vector3};
use roxmltree::Node;

/// A joint without its place in the tree.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub kind: JointKind,
    pub placement: Placement,
    pub limits: Option<Limits>,
    pub losses: Option<Losses>,
}

/// Reads links and joints one by one, and counts what it rounds.
pub(super) struct PartReader<'p, 't> {
    pub places: Places<'t>,
    pub findings: &'p mut Vec<Diagnostic>,
    pub snapped: Snapped,
}

impl<'p, 't> PartReader<'p, 't> {
    /// Nothing read yet.
    pub fn new(
        places: Places<'t>,
        options: Options<'_>,
        findings: &'p mut Vec<Diagnostic>,
    ) -> Self {
        Self {
            places,
            findings,
            snapped: Snapped::within(options.snap.unwrap_or(0.0)),
        }
    }

    /// The inertia of a link in its own axes.
    pub fn inertia(&mut self, record: &LinkRecord, value: &urdf_rs::Inertial) -> Inertia {
        let Some(inertial) = record.inertial else {
            return Inertia::ZERO;
        };
        let owner = format!("link `{}`", shown(record.name));
        let placement = self.placement(inertial, &value.origin, &owner);
        let i = &value.inertia;
        Inertia {
            mass: value.mass.value,
            center: [0.0; 3],
            tensor: [
                [i.ixx, i.ixy, i.ixz],
                [i.ixy, i.iyy, i.iyz],
                [i.ixz, i.iyz, i.izz],
            ],
        }
        .placed(&placement)
    }

    /// A joint.
    pub fn joint(&mut self, record: &JointRecord, value: &urdf_rs::Joint) -> Part {
        let owner = format!("joint `{}`", shown(record.name));
        let placement = self.placement(record.node, &value.origin, &owner);
        let kind = match value.joint_type {
            urdf_rs::JointType::Revolute | urdf_rs::JointType::Continuous => JointKind::Revolute {
                axis: self.axis(record, value.axis.xyz.0),
            },
            urdf_rs::JointType::Prismatic => JointKind::Prismatic {
                axis: self.axis(record, value.axis.xyz.0),
            },
            urdf_rs::JointType::Planar => JointKind::Planar {
                axis: self.axis(record, value.axis.xyz.0),
            },
            urdf_rs::JointType::Floating => JointKind::Floating {
                home: Placement::IDENTITY,
            },
            urdf_rs::JointType::Spherical => JointKind::Ball,
            urdf_rs::JointType::Fixed => JointKind::Fixed,
        };
        let losses = record.element("dynamics").and_then(|node| {
            let span = self.places.tag(node);
            value.dynamics.as_ref().map(|stated| Losses {
                damping: stated.damping,
                friction: stated.friction,
                span,
            })
        });
        Part {
            kind,
            placement,
            limits: self.limits(record, &value.limit),
            losses,
        }
    }

    /// The `<origin>` of an element.
    fn placement(&mut self, element: Node, value: &urdf_rs::Pose, owner: &str) -> Placement {
        let quaternion = quaternion(element).inspect(|q| self.check_quaternion(element, q, owner));
        let mut rotation = match quaternion {
            Some(q) if q.iter().any(|&x| x != 0.0) => rotation_from_quaternion(q),
            _ => rotation_from_rpy(value.rpy.0),
        };
        self.snapped.rotation(&mut rotation);
        Placement {
            rotation,
            translation: value.xyz.0,
        }
    }

    fn check_quaternion(&mut self, element: Node, q: &[f64; 4], owner: &str) {
        let Some(origin) = child(element, "origin") else {
            return;
        };
        let at = self.places.value_or_tag(origin, "quat_xyzw");
        let error = if version(element.document()) < (1, 1) {
            Diagnostic::error(
                at,
                format!("{owner}: `quat_xyzw` needs version 1.1 of the format"),
            )
            .help("write <robot version=\"1.1\" …>, or `rpy` in place of `quat_xyzw`")
        } else if origin.has_attribute("rpy") {
            Diagnostic::error(
                at,
                format!("{owner}: <origin> has both `rpy` and `quat_xyzw`"),
            )
            .help("keep one of the two")
        } else if q.iter().all(|&x| x == 0.0) {
            Diagnostic::error(at, format!("{owner}: the quaternion is zero"))
                .label("no rotation; the identity is 0 0 0 1")
        } else {
            return;
        };
        self.findings.push(error);
    }

    /// The unit axis; `stated` is URDF's default if the file has none.
    fn axis(&mut self, record: &JointRecord, stated: Vector3) -> Vector3 {
        let owner = format!("joint `{}`", shown(record.name));
        let Some(element) = record.element("axis") else {
            self.findings.push(
                Diagnostic::warning(
                    record.span,
                    format!("{owner} is {} but has no <axis>", record.kind),
                )
                .label("URDF's default is taken: 1 0 0")
                .help("write <axis xyz=\"1 0 0\"/>"),
            );
            return stated;
        };
        let at = self.places.value_or_tag(element, "xyz");
        // Scaled first: the square of a huge or tiny number is none.
        let scale = stated.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if scale == 0.0 {
            self.findings.push(
                Diagnostic::error(at, format!("{owner}: the axis is zero"))
                    .label("expected a direction"),
            );
            return [1.0, 0.0, 0.0];
        }
        let scaled = stated.map(|x| x / scale);
        let length = dot(scaled, scaled).sqrt();
        if (length * scale - 1.0).abs() > AXIS_ROUNDING {
            self.findings.push(
                Diagnostic::warning(
                    at,
                    format!("{owner}: the axis has length {:.6}, not 1", length * scale),
                )
                .label("only its direction is used"),
            );
        }
        let mut axis = scaled.map(|x| x / length);
        self.snapped.unit_vector(&mut axis);
        axis
    }

    fn limits(&mut self, record: &JointRecord, value: &urdf_rs::JointLimit) -> Option<Limits> {
        if !record.has_one_coordinate() {
            return None;
        }
        let continuous = record.kind == "continuous";
        let owner = format!("joint `{}`", shown(record.name));
        let Some(element) = record.element("limit") else {
            if !continuous {
                self.findings.push(no_limit(record, &owner));
            }
            return None;
        };
        let at = self.places.tag(element);
        let ranged = !continuous && version(element.document()) < (1, 2);
        let names: &[&str] = if ranged {
            &["lower", "upper", "effort", "velocity"]
        } else {
            &[]
        };
        let absent = |name: &&&str| !element.has_attribute(**name);
        let missing: Vec<String> = names
            .iter()
            .filter(absent)
            .map(|n| format!("`{n}`"))
            .collect();
        if !missing.is_empty() {
            self.findings.push(
                Diagnostic::warning(
                    at,
                    format!("{owner}: <limit> has no {}", missing.join(", ")),
                )
                .label("unstated `lower` and `upper` are 0, `effort` and `velocity` unlimited"),
            );
        }
        let (lower, upper) = if continuous {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            (value.lower, value.upper)
        };
        if missing.is_empty() || lower > upper {
            self.check_range(element, lower, upper, &owner);
        }
        Some(Limits {
            lower,
            upper,
            effort: value.effort,
            velocity: value.velocity,
            span: at,
        })
    }

    fn check_range(&mut self, element: Node, lower: f64, upper: f64, owner: &str) {
        if lower < upper {
            return;
        }
        let at = self.places.value_or_tag(element, "lower");
        let finding = if lower > upper {
            Diagnostic::error(at, format!("{owner}: `lower` is above `upper`"))
                .label(format!("{lower} > {upper}"))
                .help("exchange the two")
        } else {
            Diagnostic::warning(at, format!("{owner}: `lower` and `upper` are both {lower}"))
                .label("limits are no part of the dynamics: the joint moves")
                .help("a joint that must not move is type=\"fixed\"")
        };
        self.findings.push(finding);
    }
}

/// How far the length of an axis may be from 1 without a word: what four
/// written digits leave.
const AXIS_ROUNDING: f64 = 1e-4;

fn no_limit(record: &JointRecord, owner: &str) -> Diagnostic {
    let warning = Diagnostic::warning(
        record.span,
        format!("{owner} is {} but has no <limit>", record.kind),
    )
    .label("its range is taken as unlimited");
    if record.kind == "revolute" {
        return warning.help("write <limit lower=\"…\" upper=\"…\" effort=\"…\" velocity=\"…\"/>, or type=\"continuous\"");
    }
    warning.help("write <limit lower=\"…\" upper=\"…\" effort=\"…\" velocity=\"…\"/>")
}
