//! What may stand in a URDF, as data.
//!
//! From the specification at <http://wiki.ros.org/urdf/XML>; what does not bear
//! on motion is listed as ignored and not looked into.

use crate::robot::value::{Form, Range};

/// An attribute.
#[derive(Debug)]
pub(super) struct AttributeRule {
    pub name: &'static str,
    pub form: Form,
    pub required: bool,
    /// What it is, with its unit.
    pub meaning: &'static str,
}

/// How often an element stands in its parent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Occurs {
    Once,
    AtMostOnce,
    Often,
}

/// An element.
#[derive(Debug)]
pub(super) struct ElementRule {
    pub name: &'static str,
    pub attributes: &'static [AttributeRule],
    pub children: &'static [(Occurs, &'static ElementRule)],
    /// Elements that may stand here and do not bear on motion.
    pub ignored: &'static [&'static str],
}

impl ElementRule {
    /// Whether it is a link or a joint, which messages call by their names.
    pub fn is_part(&self) -> bool {
        matches!(self.name, "link" | "joint")
    }
}

const fn required(name: &'static str, form: Form, meaning: &'static str) -> AttributeRule {
    AttributeRule {
        name,
        form,
        required: true,
        meaning,
    }
}

const fn optional(name: &'static str, form: Form, meaning: &'static str) -> AttributeRule {
    AttributeRule {
        name,
        form,
        required: false,
        meaning,
    }
}

use Form::{Name, Number, Text, Vector, Version, Word};
use Occurs::{AtMostOnce, Often, Once};
use Range::{Any, Finite, NotNegative, NotNegativeOrInfinite};

/// The joint types of the specification, and `spherical`, which other readers know.
pub(super) const JOINT_TYPES: [&str; 7] = [
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
    "floating",
    "planar",
    "spherical",
];

pub(super) static ROBOT: ElementRule = ElementRule {
    name: "robot",
    attributes: &[
        required("name", Name, "the robot's name"),
        optional("version", Version, "the version of the format, such as 1.0"),
    ],
    children: &[(Often, &LINK), (Often, &JOINT)],
    ignored: &[
        "material",
        "transmission",
        "gazebo",
        "sensor",
        "ros2_control",
        "group_state",
    ],
};

static LINK: ElementRule = ElementRule {
    name: "link",
    attributes: &[
        required("name", Name, "the link's name"),
        optional("type", Text, "unused"),
    ],
    children: &[(AtMostOnce, &INERTIAL)],
    ignored: &["visual", "collision", "contact"],
};

static INERTIAL: ElementRule = ElementRule {
    name: "inertial",
    attributes: &[],
    children: &[(AtMostOnce, &ORIGIN), (Once, &MASS), (Once, &INERTIA)],
    ignored: &[],
};

static ORIGIN: ElementRule = ElementRule {
    name: "origin",
    attributes: &[
        optional("xyz", Vector(3), "lengths in m"),
        optional("rpy", Vector(3), "angles in rad"),
        optional("quat_xyzw", Vector(4), "a quaternion x y z w"),
    ],
    children: &[],
    ignored: &[],
};

static MASS: ElementRule = ElementRule {
    name: "mass",
    attributes: &[required("value", Number(NotNegative), "a mass in kg")],
    children: &[],
    ignored: &[],
};

static INERTIA: ElementRule = ElementRule {
    name: "inertia",
    attributes: &[
        required("ixx", Number(Finite), "a moment of inertia in kg·m²"),
        required("ixy", Number(Finite), "a product of inertia in kg·m²"),
        required("ixz", Number(Finite), "a product of inertia in kg·m²"),
        required("iyy", Number(Finite), "a moment of inertia in kg·m²"),
        required("iyz", Number(Finite), "a product of inertia in kg·m²"),
        required("izz", Number(Finite), "a moment of inertia in kg·m²"),
    ],
    children: &[],
    ignored: &[],
};

static JOINT: ElementRule = ElementRule {
    name: "joint",
    attributes: &[
        required("name", Name, "the joint's name"),
        required("type", Word(&JOINT_TYPES), "how the joint moves"),
    ],
    children: &[
        (AtMostOnce, &ORIGIN),
        (Once, &PARENT),
        (Once, &CHILD),
        (AtMostOnce, &AXIS),
        (AtMostOnce, &LIMIT),
        (AtMostOnce, &DYNAMICS),
        (AtMostOnce, &MIMIC),
    ],
    ignored: &["calibration", "safety_controller"],
};

static PARENT: ElementRule = ElementRule {
    name: "parent",
    attributes: &[required("link", Name, "a link's name")],
    children: &[],
    ignored: &[],
};

static CHILD: ElementRule = ElementRule {
    name: "child",
    attributes: &[required("link", Name, "a link's name")],
    children: &[],
    ignored: &[],
};

static AXIS: ElementRule = ElementRule {
    name: "axis",
    attributes: &[required(
        "xyz",
        Vector(3),
        "a direction in the joint's frame",
    )],
    children: &[],
    ignored: &[],
};

static LIMIT: ElementRule = ElementRule {
    name: "limit",
    attributes: &[
        optional("lower", Number(Any), "a coordinate in rad or m"),
        optional("upper", Number(Any), "a coordinate in rad or m"),
        optional(
            "effort",
            Number(NotNegativeOrInfinite),
            "a torque in N·m, or a force in N",
        ),
        optional(
            "velocity",
            Number(NotNegativeOrInfinite),
            "a speed in rad/s or m/s",
        ),
        optional(
            "acceleration",
            Number(NotNegativeOrInfinite),
            "a change of speed in rad/s² or m/s²",
        ),
        optional(
            "deceleration",
            Number(NotNegativeOrInfinite),
            "a change of speed in rad/s² or m/s²",
        ),
        optional(
            "jerk",
            Number(NotNegativeOrInfinite),
            "a jerk in rad/s³ or m/s³",
        ),
    ],
    children: &[],
    ignored: &[],
};

static DYNAMICS: ElementRule = ElementRule {
    name: "dynamics",
    attributes: &[
        optional(
            "damping",
            Number(NotNegative),
            "a damping in N·m·s/rad or N·s/m",
        ),
        optional(
            "friction",
            Number(NotNegative),
            "a torque in N·m, or a force in N",
        ),
    ],
    children: &[],
    ignored: &[],
};

static MIMIC: ElementRule = ElementRule {
    name: "mimic",
    attributes: &[
        required("joint", Name, "a joint's name"),
        optional("multiplier", Number(Finite), "a ratio"),
        optional("offset", Number(Finite), "a coordinate in rad or m"),
    ],
    children: &[],
    ignored: &[],
};
