//! The models under `models/`.

use crate::files::root;
use dynamics_codegen::emit::{Emission, Functions};
use dynamics_codegen::{Compiled, Library, compile_bytes};

/// All of them, by file name, each with its path from the workspace's folder.
pub fn all() -> Vec<(String, Compiled)> {
    let mut names: Vec<String> = std::fs::read_dir(root().join("models"))
        .expect("models/ is there")
        .map(|entry| entry.expect("models/ is readable").file_name())
        .map(|name| name.into_string().expect("models have plain names"))
        .filter(|name| name.ends_with(".model") || name.ends_with(".urdf"))
        .collect();
    names.sort();
    names
        .iter()
        .map(|name| (format!("models/{name}"), one(name)))
        .collect()
}

/// What `generated/` holds of a model of [`all`]: its terms, and the functions that
/// `generated/functions.txt` asks for.
pub fn emission<'a>((path, compiled): &'a (String, Compiled)) -> Emission<'a> {
    Emission::new(compiled, path, &requested(&compiled.model.name))
        .unwrap_or_else(|e| panic!("generated/functions.txt: {path}: {e}"))
}

fn requested(model: &str) -> Functions {
    let text = std::fs::read_to_string(root().join("generated/functions.txt"))
        .expect("generated/functions.txt is there");
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let list = lines.filter_map(|line| line.split_once(':'));
    let list = list
        .filter(|(name, _)| *name == model)
        .map(|(_, list)| list);
    list.collect::<String>()
        .parse()
        .unwrap_or_else(|e| panic!("generated/functions.txt: {model}: {e}"))
}

/// One of them; `name` is the file's.
pub fn one(name: &str) -> Compiled {
    read(&format!("models/{name}"))
}

/// The model at a path from the workspace's folder.
pub fn read(path: &str) -> Compiled {
    let file = root().join(path);
    let bytes = std::fs::read(&file).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut library = Library::builtin();
    library.look_in(file.parent().expect("a file lies in a folder"));
    compile_bytes(path, &bytes, &library).unwrap_or_else(|report| panic!("{report}"))
}

/// A model that has everything: a fixture of the tests.
pub const EVERYTHING: &str = "tests/data/models/type.model";

/// A model of so many coordinates that its motion is solved for in loops: a fixture.
pub const MANY: &str = "tests/data/models/limbs.model";

/// A model with contacts of all kinds, two of them held by constraints, one of which comes and goes
/// and has friction: a fixture.
pub const TOUCHING: &str = "tests/data/models/touching.model";

/// A model with sensors of all kinds: a fixture of the tests.
pub const SENSED: &str = "tests/data/models/sensed.model";
