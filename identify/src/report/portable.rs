//! A model with all that it needs, so that the folder it lies in can be moved.

use dynamics_codegen::emit::identifier;
use dynamics_codegen::source::{SourceId, Sources};
use dynamics_codegen::syntax::{Name, Statement, StatementKind};
use dynamics_codegen::syntax::{TableContent, TableStatement, parse};
use dynamics_codegen::{Compiled, Library};
use std::collections::BTreeMap;
use std::path::{Component, Path};

/// The folder of a robot description, beside the model.
const ROBOT: &str = "robot";
/// The folder of the tables, beside the model.
const TABLES: &str = "tables";
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

/// Puts beside the model `text`, a revision of `compiled`, what it names: its robot description,
/// its tables and the effects of `library` that are not built in.
pub fn portable(text: &str, compiled: &Compiled, library: &Library) -> Portable {
    let mut portable = Portable {
        model: text.to_string(),
        files: BTreeMap::new(),
        effects: Vec::new(),
    };
    // From the end, so that places in front stay where they are.
    for statement in statements(text).iter().rev() {
        portable.take(statement, compiled, library);
    }
    portable.effects.sort();
    portable
}

impl Portable {
    fn take(&mut self, statement: &Statement, compiled: &Compiled, library: &Library) {
        match &statement.kind {
            StatementKind::Robot { file, .. } => self.take_robot(file, compiled),
            StatementKind::Table(table) => self.take_table(table, compiled),
            StatementKind::Effect { template, .. } => self.take_effect(&template.text, library),
            StatementKind::Part(part) => {
                for inner in part.statements.iter().rev() {
                    self.take(inner, compiled, library);
                }
            }
            _ => {}
        }
    }

    /// A model has one robot description, with the files that this includes: those that lie
    /// beside it or below.
    fn take_robot(&mut self, file: &Name, compiled: &Compiled) {
        let Some(robot) = &compiled.model.robot else {
            return;
        };
        let name = Path::new(&file.text).file_name().unwrap_or_default();
        let path = format!("{ROBOT}/{}", name.to_string_lossy());
        self.take_file(file, path, compiled, robot.source);
        let sources = &compiled.warnings.sources;
        for (path, source) in &robot.included {
            let below = |part| matches!(part, Component::Normal(_) | Component::CurDir);
            if Path::new(path).components().all(below) {
                let text = sources.get(*source).text.clone();
                self.files.insert(format!("{ROBOT}/{path}"), text);
            }
        }
    }

    /// Tables have names of their own; their files need not.
    fn take_table(&mut self, table: &TableStatement, compiled: &Compiled) {
        let mut known = compiled.model.tables.iter();
        let known = known.find(|known| known.name == table.name.text);
        let source = known.and_then(|known| known.file.as_ref());
        if let (TableContent::File(file), Some((_, source))) = (&table.content, source) {
            let path = format!("{TABLES}/{}.csv", identifier(&table.name.text));
            self.take_file(file, path, compiled, *source);
        }
    }

    fn take_file(&mut self, named: &Name, path: String, compiled: &Compiled, source: SourceId) {
        self.model
            .replace_range(named.span.start..named.span.end, &format!("{path:?}"));
        let text = &compiled.warnings.sources.get(source).text;
        self.files.insert(path, text.clone());
    }

    fn take_effect(&mut self, name: &str, library: &Library) {
        let Some(template) = library.own(name) else {
            return;
        };
        let path = format!("{EFFECTS}/{name}.model");
        if self.files.insert(path, template.to_string()).is_none() {
            self.effects.push(name.to_string());
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
    fn what_a_description_includes_comes_along() {
        let mut library = Library::builtin();
        let arm = "<mujoco><include file=\"parts/a.xml\"/><worldbody><body name=\"rod\"><joint name=\"j\"/>\
                   <geom size=\"0.1\"/></body></worldbody></mujoco>";
        let part = "<mujocoinclude><default><geom density=\"500\"/></default></mujocoinclude>";
        library.add_file("../far/arm.xml", "far/arm.xml", arm);
        library.add_file("../far/parts/a.xml", "far/parts/a.xml", part);
        let text = "model m;\nmjcf \"../far/arm.xml\";\n";
        let compiled = compile("m.model", text, &library).unwrap();
        let portable = portable(text, &compiled, &library);
        assert_eq!(portable.model, text.replace("../far/", "robot/"));
        assert_eq!(portable.files["robot/arm.xml"], arm);
        assert_eq!(portable.files["robot/parts/a.xml"], part);
        let mut there = Library::builtin();
        for (path, text) in &portable.files {
            there.add_file(path, path, text);
        }
        assert!(compile("m.model", &portable.model, &there).is_ok());
    }

    /// Two tables whose files have one name, and an effect that only a part names.
    #[test]
    fn tables_come_along() {
        let mut library = Library::builtin();
        library.add(
            "mine",
            "mine.model",
            "effect mine(joint); parameter pull: torque(joint) = 0; force joint = pull;",
        );
        library.add_file("a/d.csv", "a/d.csv", "0,0\n1,2\n");
        library.add_file("../d.csv", "d.csv", "0,1\n1,3\n");
        let text = "model m;\ntable near(x: m): N = \"a/d.csv\";\ntable far(x: m): N = \"../d.csv\";\n\
                    part cart(k) { coordinate x: m; kinetic k/2*dot(x)^2; force x = near(x) + far(x);\n\
                    effect mine(x); }\nconstant k: kg = 1;\nuse only = cart(k);\n";
        let compiled = compile("m.model", text, &library).unwrap();
        let portable = portable(text, &compiled, &library);
        let moved = text.replace("a/d.csv", "tables/near.csv");
        assert_eq!(portable.model, moved.replace("../d.csv", "tables/far.csv"));
        assert_eq!(portable.files["tables/far.csv"], "0,1\n1,3\n");
        assert_eq!(portable.effects, ["mine"]);
        let mut there = Library::builtin();
        for (path, text) in &portable.files {
            there.add_file(path, path, text);
        }
        there.add("mine", "mine.model", &portable.files["effects/mine.model"]);
        assert!(compile("m.model", &portable.model, &there).is_ok());
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
