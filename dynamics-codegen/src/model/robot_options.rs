//! What stands in the braces of `urdf "…" { … }` and `mjcf "…" { … }`.

use super::builder::Builder;
use crate::diagnostic::{Diagnostic, nearest};
use crate::robot::Lock;
use crate::source::Span;
use crate::syntax::{Expr, Name, RobotOption};

/// The braces, read.
pub(super) struct Options {
    pub floating: bool,
    /// Where it says that what floats moves by its twist.
    pub twist: Option<Span>,
    /// Which joints are driven; `None`: as the description says.
    pub inputs: Option<Chosen>,
    pub losses: Acting,
    pub lock: Vec<Lock>,
    pub impossible: bool,
    pub snap: bool,
    /// Where it says that equalities of the description hold.
    pub equalities: Option<Span>,
    pub parameters: Chosen,
    pub origins: Chosen,
    /// Joints whose losses are parameters.
    pub friction: Chosen,
}

/// Which joints' losses act.
pub(super) enum Acting {
    All,
    Of(Vec<Name>),
}

impl Acting {
    pub fn includes(&self, joint: &str) -> bool {
        match self {
            Self::All => true,
            Self::Of(names) => names.iter().any(|name| name.text == joint),
        }
    }

    /// The joints that are named.
    pub fn names(&self) -> &[Name] {
        match self {
            Self::All => &[],
            Self::Of(names) => names,
        }
    }
}

/// `none`, `all` or some names.
#[derive(Default)]
pub(super) struct Chosen {
    pub names: Vec<Name>,
    pub all: bool,
}

impl Chosen {
    fn read(values: &[Name]) -> Self {
        let only = |word: &str| values.len() == 1 && values[0].text == word;
        let named = !only("all") && !only("none");
        Self {
            names: values.iter().filter(|_| named).cloned().collect(),
            all: only("all"),
        }
    }

    pub fn names(&self, name: &str) -> bool {
        self.names.iter().any(|chosen| chosen.text == name)
    }

    pub fn includes(&self, name: &str) -> bool {
        self.all || self.names(name)
    }
}

const OPTIONS: [&str; 11] = [
    "base",
    "equalities",
    "friction",
    "inertias",
    "inputs",
    "lock",
    "losses",
    "origins",
    "parameters",
    "snap",
    "velocities",
];

impl Builder<'_> {
    pub(super) fn robot_options(&mut self, given: &[RobotOption]) -> Option<Options> {
        let mut options = Options {
            floating: false,
            twist: None,
            inputs: None,
            losses: Acting::All,
            lock: Vec::new(),
            impossible: false,
            snap: true,
            equalities: None,
            parameters: Chosen::default(),
            origins: Chosen::default(),
            friction: Chosen::default(),
        };
        let mut clean = true;
        for RobotOption {
            name,
            values,
            positions,
        } in given
        {
            let only = |word: &str| values.len() == 1 && values[0].text == word;
            let understood = match name.text.as_str() {
                "base" => {
                    options.floating = only("floating");
                    only("fixed") || only("floating")
                }
                "equalities" => {
                    options.equalities = only("hold").then_some(name.span);
                    only("hold") || only("ignore")
                }
                "velocities" => {
                    options.twist = only("twist").then_some(name.span);
                    only("twist") || only("rates")
                }
                "losses" => {
                    options.losses = match (only("act"), only("ignore")) {
                        (true, _) => Acting::All,
                        (_, true) => Acting::Of(Vec::new()),
                        _ => Acting::Of(values.clone()),
                    };
                    true
                }
                "lock" => {
                    let locks = values.iter().zip(positions);
                    let locks = locks.map(|(joint, position)| self.lock(joint, position.as_ref()));
                    options.lock.extend(locks.collect::<Option<Vec<Lock>>>()?);
                    true
                }
                "inertias" => {
                    options.impossible = only("as_stated");
                    only("possible") || only("as_stated")
                }
                "snap" => {
                    options.snap = only("on");
                    only("on") || only("off")
                }
                "inputs" => {
                    options.inputs = Some(Chosen::read(values));
                    true
                }
                "parameters" => {
                    options.parameters = Chosen::read(values);
                    true
                }
                "origins" => {
                    options.origins = Chosen::read(values);
                    true
                }
                "friction" => {
                    options.friction = Chosen::read(values);
                    true
                }
                _ => false,
            };
            let placed = positions.iter().flatten().next();
            if !understood {
                clean = false;
                self.report_option(name, values);
            } else if let Some(position) = placed.filter(|_| name.text != "lock") {
                clean = false;
                let message = format!("`{}` takes no numbers", name.text);
                let error = Diagnostic::error(position.span, message);
                self.report::<()>(error.help("only `lock` does: `lock: j5 = 0.3`"));
            }
        }
        clean.then_some(options)
    }

    fn lock(&mut self, joint: &Name, position: Option<&Expr>) -> Option<Lock> {
        let at = match position {
            Some(position) => self.number(position)?,
            None => 0.0,
        };
        Some(Lock {
            joint: joint.text.clone(),
            at,
            span: joint.span,
        })
    }

    fn report_option(&mut self, name: &Name, values: &[Name]) {
        let words = match name.text.as_str() {
            "base" => "`base` is `fixed` or `floating`",
            "equalities" => "`equalities` are `hold` or `ignore`",
            "inertias" => "`inertias` are `possible` or `as_stated`",
            "snap" => "`snap` is `on` or `off`",
            "velocities" => "`velocities` are `rates` or `twist`",
            other => {
                let message = format!("a robot description has no option `{other}`");
                let error = Diagnostic::error(name.span, message);
                let error = match nearest(other, OPTIONS) {
                    Some(near) => error.help(format!("did you mean `{near}`?")),
                    None => error.help(format!("the options are: {}", OPTIONS.join(", "))),
                };
                self.report::<()>(error);
                return;
            }
        };
        let at = values.first().map_or(name.span, |value| value.span);
        self.report::<()>(Diagnostic::error(at, words));
    }
}
