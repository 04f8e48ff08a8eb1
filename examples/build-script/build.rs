//! `skate.model` to a module in `OUT_DIR`, with functions beside the terms.

use dynamics_codegen::build::ModelFile;

fn main() -> Result<(), dynamics_codegen::build::Error> {
    ModelFile::new("skate.model")
        .functions("inverse_dynamics, constrained_dynamics_derivatives")
        .write()
}
