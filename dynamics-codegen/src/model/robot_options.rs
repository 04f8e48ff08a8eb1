//! What stands in the braces of `urdf "…" { … }`.

use super::builder::Builder;
use crate::diagnostic::{Diagnostic, nearest};
use crate::syntax::{Name, RobotOption};

/// The braces, read.
pub(super) struct Options {
    pub floating: bool,
    pub inputs: Option<Vec<Name>>,
    pub losses: bool,
    pub snap: bool,
    pub parameters: Chosen,
    pub origins: Chosen,
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
}

const OPTIONS: [&str; 6] = ["base", "inputs", "losses", "origins", "parameters", "snap"];

impl Builder<'_> {
    pub(super) fn robot_options(&mut self, given: &[RobotOption]) -> Option<Options> {
        let mut options = Options {
            floating: false,
            inputs: None,
            losses: true,
            snap: true,
            parameters: Chosen::default(),
            origins: Chosen::default(),
        };
        let mut clean = true;
        for RobotOption { name, values } in given {
            let only = |word: &str| values.len() == 1 && values[0].text == word;
            let understood = match name.text.as_str() {
                "base" => {
                    options.floating = only("floating");
                    only("fixed") || only("floating")
                }
                "losses" => {
                    options.losses = only("act");
                    only("act") || only("ignore")
                }
                "snap" => {
                    options.snap = only("on");
                    only("on") || only("off")
                }
                "inputs" => {
                    options.inputs = match (only("none"), only("all")) {
                        (true, _) => Some(Vec::new()),
                        (_, true) => None,
                        _ => Some(values.clone()),
                    };
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
                _ => false,
            };
            if !understood {
                clean = false;
                self.report_option(name, values);
            }
        }
        clean.then_some(options)
    }

    fn report_option(&mut self, name: &Name, values: &[Name]) {
        let words = match name.text.as_str() {
            "base" => "`base` is `fixed` or `floating`",
            "losses" => "`losses` are `act` or `ignore`",
            "snap" => "`snap` is `on` or `off`",
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
