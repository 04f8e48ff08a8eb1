//! `skate.model` to a module in `OUT_DIR`.

fn main() -> Result<(), dynamics_codegen::build::Error> {
    dynamics_codegen::build::module("skate.model")
}
