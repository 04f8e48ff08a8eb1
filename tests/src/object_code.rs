//! Compiled Rust and the symbols it leaves to others.
//!
//! A release object that calls nothing but a few known functions cannot allocate, print or
//! panic: each of these is a call into another object.

use object::read::archive::ArchiveFile;
use object::{Object, ObjectSymbol};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Libraries of a release build by crate name, and where they lie.
#[derive(Debug)]
pub struct Libraries {
    paths: BTreeMap<String, PathBuf>,
    folder: PathBuf,
}

impl Libraries {
    /// Builds the packages as cargo does for a release, into a folder of their own.
    pub fn build(workspace: &Path, packages: &[&str], folder: &Path) -> Self {
        let mut command = Command::new(env!("CARGO"));
        command.current_dir(workspace).args([
            "build",
            "--release",
            "--offline",
            "--message-format=json",
            "--target-dir",
        ]);
        command.arg(folder);
        for package in packages {
            command.args(["-p", package]);
        }
        // As a user's build: none of the flags that this test may run under.
        for variable in ["CARGO_ENCODED_RUSTFLAGS", "RUSTFLAGS"] {
            command.env_remove(variable);
        }
        let output = command.output().expect("cargo runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        let mut paths = BTreeMap::new();
        for line in String::from_utf8_lossy(&output.stdout).lines() {
            let message: serde_json::Value = serde_json::from_str(line).expect("cargo writes JSON");
            let name = message["target"]["name"].as_str().unwrap_or_default();
            let files = message["filenames"].as_array().into_iter().flatten();
            let library = files
                .filter_map(|file| file.as_str())
                .find(|file| file.ends_with(".rlib"));
            if let Some(library) = library {
                paths.insert(name.replace('-', "_"), PathBuf::from(library));
            }
        }
        let folder = folder.join("release/deps");
        Self { paths, folder }
    }

    /// The library of a crate.
    pub fn path(&self, name: &str) -> &Path {
        let path = self.paths.get(name);
        path.unwrap_or_else(|| panic!("cargo built no library `{name}`"))
    }

    /// Compiles a library crate that may use `crates` to an object.
    pub fn compile(&self, source: &str, crates: &[&str], object: &Path) {
        let file = object.with_extension("rs");
        let name = object.file_stem().expect("an object has a name").display();
        std::fs::write(&file, source).expect("the folder is writable");
        let mut command = Command::new(std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into()));
        command
            .args(["--edition=2024", "--crate-type=lib"])
            // Its own: what rustc writes on the way is called after the crate.
            .arg(format!("--crate-name={name}"))
            .args(["-Copt-level=3", "-Ccodegen-units=1", "-Cpanic=abort"])
            .arg(format!("--emit=obj={}", object.display()))
            .arg(format!("-Ldependency={}", self.folder.display()))
            .arg(&file);
        for name in crates {
            command.arg(format!("--extern={name}={}", self.path(name).display()));
        }
        let output = command.output().expect("rustc runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
    }
}

/// Names that objects define and that they leave to others, demangled.
#[derive(Debug, Default)]
pub struct Symbols {
    /// Functions and data with a body.
    pub defined: BTreeSet<String>,
    /// What must come from elsewhere.
    pub wanted: BTreeSet<String>,
}

impl Symbols {
    /// Adds those of an object, or of every object in a library.
    pub fn add(&mut self, path: &Path) {
        let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let Ok(archive) = ArchiveFile::parse(bytes.as_slice()) else {
            return self.add_object(&bytes);
        };
        for member in archive.members() {
            let member = member.expect("a library is sound");
            // Beside the objects a library holds what the compiler knows of the crate.
            if member.name().ends_with(b".o") {
                self.add_object(member.data(bytes.as_slice()).expect("a library is sound"));
            }
        }
    }

    fn add_object(&mut self, bytes: &[u8]) {
        let object = object::File::parse(bytes).expect("rustc writes objects");
        for symbol in object.symbols() {
            let name = symbol.name().expect("symbols have names");
            let name = format!("{:#}", rustc_demangle::demangle(name));
            if symbol.is_undefined() && !name.is_empty() {
                self.wanted.insert(name);
            } else if symbol.is_definition() {
                self.defined.insert(name);
            }
        }
    }

    /// What is left to others and not allowed.
    pub fn strangers(&self, allowed: impl Fn(&str) -> bool) -> Vec<&str> {
        let wanted = self.wanted.difference(&self.defined).map(String::as_str);
        wanted.filter(|name| !allowed(name)).collect()
    }
}
