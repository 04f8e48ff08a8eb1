//! `models/wheelbot.model` with what simulations add to it: one model text in `OUT_DIR`, and
//! its Rust module.

use dynamics_codegen::build::ModelFile;
use std::error::Error;
use std::path::PathBuf;

const PARTS: [&str; 2] = ["../models/wheelbot.model", "instruments.model"];

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("`OUT_DIR` is not set")?);
    let mut text = String::new();
    for part in PARTS {
        // Standard output is cargo's.
        println!("cargo::rerun-if-changed={part}");
        text += &std::fs::read_to_string(part).map_err(|e| format!("{part}: {e}"))?;
    }
    std::fs::write(out.join("wheelbot.model"), text)?;
    ModelFile::new("wheelbot.model")
        .root(out)
        .functions("sensors")
        .write()?;
    Ok(())
}
