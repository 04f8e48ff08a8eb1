//! What may stand in an MJCF, as data: which attributes are read, which bear on motion and are
//! not, and which only say how things look, touch or are solved for.
//!
//! From MuJoCo's XML reference, <https://mujoco.readthedocs.io/en/stable/XMLreference.html>.

/// An element with its attributes.
#[derive(Debug)]
pub(super) struct ElementRule {
    pub name: &'static str,
    /// Attributes that are read.
    pub read: &'static [&'static str],
    /// Attributes that bear on motion and are not read.
    pub ignored: &'static [&'static str],
    /// Attributes without a meaning for the equations of motion.
    pub idle: &'static [&'static str],
}

impl ElementRule {
    /// Every attribute that the element may have.
    pub fn known(&self) -> impl Iterator<Item = &'static str> {
        let all = [self.read, self.ignored, self.idle];
        all.into_iter().flatten().copied()
    }
}

pub(super) static COMPILER: ElementRule = ElementRule {
    name: "compiler",
    read: &[
        "angle",
        "balanceinertia",
        "boundinertia",
        "boundmass",
        "coordinate",
        "eulerseq",
        "inertiafromgeom",
        "inertiagrouprange",
        "settotalmass",
    ],
    ignored: &["alignfree"],
    idle: &[
        "assetdir",
        "autolimits",
        "conflict",
        "convexhull",
        "discardvisual",
        "exactmeshinertia",
        "fitaabb",
        "fusestatic",
        "meshdir",
        "passthrough",
        "savecanonical",
        "savecompiled",
        "saveinertial",
        "strippath",
        "texturedir",
        "usethread",
    ],
};

pub(super) static OPTION: ElementRule = ElementRule {
    name: "option",
    read: &["gravity"],
    ignored: &["density", "viscosity", "wind"],
    idle: &[
        "actuatorgroupdisable",
        "apirate",
        "ccd_iterations",
        "ccd_tolerance",
        "collision",
        "cone",
        "impratio",
        "integrator",
        "iterations",
        "jacobian",
        "ls_iterations",
        "ls_tolerance",
        "magnetic",
        "mpr_iterations",
        "mpr_tolerance",
        "noslip_iterations",
        "noslip_tolerance",
        "o_friction",
        "o_margin",
        "o_solimp",
        "o_solref",
        "sdf_initpoints",
        "sdf_iterations",
        "sleep_tolerance",
        "solver",
        "timestep",
        "tolerance",
    ],
};

pub(super) static FLAG: ElementRule = ElementRule {
    name: "flag",
    read: &["equality", "gravity"],
    ignored: &["damper", "frictionloss", "passive", "spring"],
    idle: &[
        "actuation",
        "autoreset",
        "clampctrl",
        "constraint",
        "contact",
        "diagexact",
        "energy",
        "eulerdamp",
        "filterparent",
        "fwdinv",
        "invdiscrete",
        "ipc",
        "island",
        "limit",
        "midphase",
        "multiccd",
        "nativeccd",
        "override",
        "refsafe",
        "sensor",
        "sensornoise",
        "sleep",
        "speculative",
        "warmstart",
    ],
};

pub(super) static BODY: ElementRule = ElementRule {
    name: "body",
    read: &[
        "axisangle",
        "childclass",
        "euler",
        "name",
        "pos",
        "quat",
        "xyaxes",
        "zaxis",
    ],
    ignored: &["gravcomp", "mocap"],
    idle: &["fuse", "simple", "sleep", "user"],
};

pub(super) static FRAME: ElementRule = ElementRule {
    name: "frame",
    read: &[
        "axisangle",
        "childclass",
        "euler",
        "pos",
        "quat",
        "xyaxes",
        "zaxis",
    ],
    ignored: &[],
    idle: &["name"],
};

pub(super) static INERTIAL: ElementRule = ElementRule {
    name: "inertial",
    read: &[
        "axisangle",
        "diaginertia",
        "euler",
        "fullinertia",
        "mass",
        "pos",
        "quat",
        "xyaxes",
        "zaxis",
    ],
    ignored: &[],
    idle: &[],
};

pub(super) static JOINT: ElementRule = ElementRule {
    name: "joint",
    read: &[
        "armature",
        "axis",
        "class",
        "damping",
        "frictionloss",
        "name",
        "pos",
        "ref",
        "springref",
        "stiffness",
        "type",
    ],
    ignored: &[
        "actuatorfrcrange",
        "actuatorgravcomp",
        "range",
        "springdamper",
    ],
    idle: &[
        "actuatorfrclimited",
        "group",
        "limited",
        "margin",
        "solimpfriction",
        "solimplimit",
        "solreffriction",
        "solreflimit",
        "springyield",
        "user",
    ],
};

pub(super) static FREEJOINT: ElementRule = ElementRule {
    name: "freejoint",
    read: &["name"],
    ignored: &["align"],
    idle: &["group"],
};

pub(super) static GEOM: ElementRule = ElementRule {
    name: "geom",
    read: &[
        "axisangle",
        "class",
        "density",
        "euler",
        "fromto",
        "group",
        "mass",
        "mesh",
        "pos",
        "quat",
        "shellinertia",
        "size",
        "type",
        "xyaxes",
        "zaxis",
    ],
    ignored: &[],
    idle: &[
        "adhesion",
        "castshadow",
        "conaffinity",
        "condim",
        "contype",
        "fitscale",
        "fluidcoef",
        "fluidshape",
        "friction",
        "gap",
        "hfield",
        "margin",
        "material",
        "name",
        "priority",
        "rgba",
        "solimp",
        "solmix",
        "solref",
        "surfacevel",
        "user",
    ],
};

/// The elements of `<actuator>`.
pub(super) const ACTUATORS: [&str; 14] = [
    "adhesion",
    "cylinder",
    "damper",
    "dcmotor",
    "general",
    "intvelocity",
    "motor",
    "muscle",
    "orientation",
    "pid",
    "plugin",
    "position",
    "velocity",
    "integrator",
];

/// What stands in `<mujoco>` beside what is read.
pub(super) const SECTIONS: [&str; 11] = [
    "asset",
    "contact",
    "custom",
    "deformable",
    "extension",
    "keyframe",
    "sensor",
    "size",
    "statistic",
    "tendon",
    "visual",
];

/// What is read of `<mujoco>`.
pub(super) const READ_SECTIONS: [&str; 6] = [
    "actuator",
    "compiler",
    "default",
    "equality",
    "option",
    "worldbody",
];

/// What is read of `<equality>`.
pub(super) const EQUALITIES: [&str; 2] = ["connect", "joint"];

/// What else stands there.
pub(super) const EQUALITIES_IGNORED: [&str; 6] = [
    "distance",
    "flex",
    "flexstrain",
    "flexvert",
    "tendon",
    "weld",
];

pub(super) static CONNECT: ElementRule = ElementRule {
    name: "connect",
    read: &[
        "active", "anchor", "body1", "body2", "class", "name", "site1", "site2",
    ],
    ignored: &[],
    idle: &["solimp", "solref"],
};

pub(super) static COUPLING: ElementRule = ElementRule {
    name: "joint",
    read: &["active", "class", "joint1", "joint2", "name", "polycoef"],
    ignored: &[],
    idle: &["solimp", "solref"],
};

/// What stands in a body beside what is read.
pub(super) const IN_BODY: [&str; 4] = ["camera", "light", "plugin", "site"];

/// What is read of a body.
pub(super) const READ_IN_BODY: [&str; 6] =
    ["body", "frame", "freejoint", "geom", "inertial", "joint"];

/// What writes bodies and joints by itself.
pub(super) const MACROS: [&str; 4] = ["attach", "composite", "flexcomp", "replicate"];
