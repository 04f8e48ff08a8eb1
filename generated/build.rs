//! With the feature `regenerate`: the models of `../models` to Rust in `OUT_DIR`, as a user's
//! own build script would do it.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    #[cfg(feature = "regenerate")]
    if let Err(message) = regenerate::run() {
        // A model's faults are rendered reports: show them as they are.
        for line in message.lines() {
            println!("cargo::error={line}");
        }
    }
}

#[cfg(feature = "regenerate")]
mod regenerate {
    use dynamics_codegen::emit::{Emission, Functions};
    use dynamics_codegen::{Library, compile_bytes, emit};
    use std::path::{Path, PathBuf};

    pub fn run() -> Result<(), String> {
        let folder = "../models";
        println!("cargo::rerun-if-changed={folder}");
        let mut models = Vec::new();
        for path in model_files(Path::new(folder))? {
            let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            // The name from the workspace root, as in the checked-in header.
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            let name = format!("models/{file}");
            let mut library = Library::builtin();
            library.look_in(folder);
            let compiled =
                compile_bytes(&name, &bytes, &library).map_err(|report| report.render())?;
            models.push((name, compiled));
        }
        println!("cargo::rerun-if-changed=functions.txt");
        let list =
            std::fs::read_to_string("functions.txt").map_err(|e| format!("functions.txt: {e}"))?;
        let mut emissions = Vec::new();
        for (path, compiled) in &models {
            let functions = requested(&list, &compiled.model.name)?;
            let emission = Emission::new(compiled, path, &functions);
            emissions.push(emission.map_err(|e| format!("functions.txt: {path}: {e}"))?);
        }
        let out = PathBuf::from(std::env::var("OUT_DIR").map_err(|e| e.to_string())?);
        for file in emit::rust_crate_of(&emissions).map_err(|e| e.to_string())? {
            let path = out.join(&file.name);
            std::fs::write(&path, file.text).map_err(|e| format!("{}: {e}", path.display()))?;
        }
        Ok(())
    }

    /// The functions that the list asks for beside a model's terms.
    fn requested(list: &str, model: &str) -> Result<Functions, String> {
        let lines = list.lines().filter(|line| !line.starts_with('#'));
        let own = lines.filter_map(|line| line.split_once(':'));
        let own = own.filter(|(name, _)| *name == model).map(|(_, own)| own);
        let functions = own.collect::<String>().parse();
        functions.map_err(|e| format!("functions.txt: {model}: {e}"))
    }

    /// The model files of a folder, sorted: the order of a folder is not the same on
    /// every machine.
    fn model_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
        let unreadable = |e: std::io::Error| format!("{}: {e}", folder.display());
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(unreadable)? {
            let path = entry.map_err(unreadable)?.path();
            if path
                .extension()
                .is_some_and(|e| e == "model" || e == "urdf")
            {
                paths.push(path);
            }
        }
        paths.sort();
        Ok(paths)
    }
}
