//! Every model in `models/` compiles without a word.

use dynamics_codegen::{Library, compile};

#[test]
fn every_model_compiles() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../models");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "model") {
            let text = std::fs::read_to_string(&path).unwrap();
            let mut library = Library::builtin();
            library.look_in(folder);
            let compiled = compile(&path.display().to_string(), &text, &library)
                .unwrap_or_else(|report| panic!("{report}"));
            assert!(
                compiled.warnings.diagnostics.is_empty(),
                "{}",
                compiled.warnings
            );
            let s = &compiled.system;
            let m: Vec<_> = s.mass_matrix.iter().flatten().copied().collect();
            println!(
                "{} M {} bias {} A {}",
                compiled.model.name,
                compiled.model.graph.operation_count(&m),
                compiled.model.graph.operation_count(&s.bias_force),
                compiled.model.graph.operation_count(&s.constraint_bias)
            );
            count += 1;
        }
    }
    assert!(count >= 8);
}
