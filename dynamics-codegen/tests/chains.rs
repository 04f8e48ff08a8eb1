//! Long chains: what is generated for them ends, or is refused with a mend.

use dynamics_codegen::emit::{Emission, FunctionError, Functions};
use dynamics_codegen::{Compiled, Library, compile};
use std::fmt::Write;

/// A chain of `links` rods whose hinges turn about y and z by turns.
fn chain(links: usize) -> Compiled {
    let mut text = "<robot name=\"chain\"><link name=\"l0\"/>\n".to_string();
    for i in 1..=links {
        let axis = if i % 2 == 0 { "0 1 0" } else { "0 0 1" };
        writeln!(
            text,
            "<link name=\"l{i}\"><inertial><origin xyz=\"0.1 0 0\"/><mass value=\"1\"/>\
             <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.02\"/></inertial></link>\
             <joint name=\"j{i}\" type=\"revolute\"><parent link=\"l{before}\"/><child link=\"l{i}\"/>\
             <origin xyz=\"0.2 0 0\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>",
            before = i - 1
        )
        .unwrap();
    }
    text.push_str("</robot>\n");
    compile("chain.urdf", &text, &Library::builtin()).unwrap_or_else(|e| panic!("{e}"))
}

/// What the help of the refusal asks for can be had.
#[test]
fn a_long_chain_has_its_dynamics() {
    let compiled = chain(60);
    let functions = "inverse_dynamics,forward_dynamics".parse().unwrap();
    let emission = Emission::new(&compiled, "chain.urdf", &functions).unwrap();
    let counts = emission.operation_counts();
    let of = |name: &str| counts.iter().find(|(n, _)| n == name).unwrap().1.total();
    // They grow with the square and with the cube of the length.
    assert!(
        of("inverse_dynamics") < 10_000,
        "{}",
        of("inverse_dynamics")
    );
    assert!(
        of("forward_dynamics") < 200_000,
        "{}",
        of("forward_dynamics")
    );
}

/// All functions of a chain as C, in bytes.
fn size(links: usize) -> usize {
    let compiled = chain(links);
    let emission = Emission::new(&compiled, "chain.urdf", &Functions::full()).unwrap();
    emission.c().iter().map(|file| file.text.len()).sum()
}

/// Solved in loops, all functions grow with the square of the length; written out they grew
/// with its cube, to 100 MB for 60 links.
#[test]
fn all_functions_of_a_long_chain_grow_with_its_square() {
    let [half, whole] = [30, 60].map(size);
    assert!(whole <= 8_500_000, "{whole} bytes");
    // Four times as many pairs of joints, whose names are a little longer.
    assert!(10 * whole <= 42 * half, "{half} bytes, then {whole}");
}

/// What no compiler would end with is refused before anything is written, and before what
/// comes behind is derived.
#[test]
fn what_is_too_large_is_refused() {
    let compiled = chain(60);
    let functions = "mass_matrix_by_position,inverse_dynamics_derivatives,bias_force_by_position";
    let error = Emission::new(&compiled, "chain.urdf", &functions.parse().unwrap()).unwrap_err();
    let function = "inverse_dynamics_derivatives".to_string();
    assert_eq!(error, FunctionError::TooLarge { function });
    assert!(error.to_string().contains("1000000 operations"), "{error}");
    let help = error.help().expect("a mend");
    assert!(
        help.contains("--functions inverse_dynamics,forward_dynamics"),
        "{help}"
    );
}
