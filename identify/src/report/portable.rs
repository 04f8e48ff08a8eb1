//! A model with all that it needs, so that the folder it lies in can be moved.

use dynamics_codegen::source::Sources;
use dynamics_codegen::syntax::{Name, Statement, StatementKind, parse};
use dynamics_codegen::{Compiled, Library};
use std::collections::BTreeMap;
use std::path::Path;

/// The folder of a robot description, beside the model.
const ROBOT: &str = "robot";
/// The folder of the effects that are not built in, beside the model.
pub const EFFECTS: &str = "effects";

/// A model's text whose paths lead to files beside it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Portable {
    /// The text.
    pub model: String,
    /// Files by their path from the model's folder, with `/` between names.
    pub files: BTreeMap<String, String>,
    /// Names of the effects that are found by `--effects effects` only, sorted.
    pub effects: Vec<String>,
}

/// Puts beside the model `text`, a revision of `compiled`, what it names: its robot description
/// and the effects of `library` that are not built in.
pub fn portable(text: &str, compiled: &Compiled, library: &Library) -> Portable {
    let mut portable = Portable {
        model: text.to_string(),
        files: BTreeMap::new(),
        effects: Vec::new(),
    };
    for statement in statements(text) {
        match &statement.kind {
            StatementKind::Urdf { file, .. } => portable.take_robot(text, file, compiled),
            StatementKind::Effect { template, .. } => portable.take_effect(&template.text, library),
            _ => {}
        }
    }
    portable
}

impl Portable {
    /// A model has one robot description.
    fn take_robot(&mut self, text: &str, file: &Name, compiled: &Compiled) {
        let Some(robot) = &compiled.model.robot else {
            return;
        };
        let name = Path::new(&file.text).file_name().unwrap_or_default();
        let path = format!("{ROBOT}/{}", name.to_string_lossy());
        let (before, after) = (&text[..file.span.start], &text[file.span.end..]);
        self.model = format!("{before}{path:?}{after}");
        let description = &compiled.warnings.sources.get(robot.source).text;
        self.files.insert(path, description.clone());
    }

    fn take_effect(&mut self, name: &str, library: &Library) {
        let Some(template) = library.own(name) else {
            return;
        };
        let path = format!("{EFFECTS}/{name}.model");
        if self.files.insert(path, template.to_string()).is_none() {
            self.effects.push(name.to_string());
            self.effects.sort();
        }
    }
}

fn statements(text: &str) -> Vec<Statement> {
    let mut sources = Sources::new();
    let id = sources.add("model", text);
    let (file, _) = parse(&sources, id);
    file.map(|file| file.statements).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics_codegen::compile;

    const ARM: &str = r#"<robot name="arm"><link name="base"/><link name="rod"><inertial>
        <mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
        </link><joint name="j" type="continuous"><parent link="base"/><child link="rod"/>
        <axis xyz="0 1 0"/></joint></robot>"#;

    #[test]
    fn what_a_model_names_comes_along() {
        let mut library = Library::builtin();
        let mine = "effect mine(joint: coordinate);\nparameter d: N*m*s/rad = 0.1;\n\
                    force joint = -d*dot(joint);\n";
        library.add("mine", "somewhere/mine.model", mine);
        library.add_file("../far/arm.urdf", "far/arm.urdf", ARM);
        let text = "model m;\nurdf \"../far/arm.urdf\" { inputs: j; }\n\
                    effect viscous(j) { d = 1 }\neffect mine(j);\n";
        let compiled = compile("m.model", text, &library).unwrap();
        let portable = portable(text, &compiled, &library);
        assert_eq!(portable.model, text.replace("../far/", "robot/"));
        let files: Vec<(&str, &str)> = portable
            .files
            .iter()
            .map(|(path, text)| (path.as_str(), text.as_str()))
            .collect();
        assert_eq!(
            files,
            [("effects/mine.model", mine), ("robot/arm.urdf", ARM)]
        );
        assert_eq!(portable.effects, ["mine"]);
    }

    #[test]
    fn a_model_that_needs_nothing_stays_as_it_is() {
        let text = "model m;\ncoordinate x: m;\nparameter m: kg = 1;\nkinetic m/2*dot(x)^2;\n\
                    effect viscous(x);\n";
        let library = Library::builtin();
        let compiled = compile("m.model", text, &library).unwrap();
        let portable = portable(text, &compiled, &library);
        assert_eq!(portable.model, text);
        assert!(portable.files.is_empty() && portable.effects.is_empty());
    }
}
