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

/// All functions of such a chain would be 100 MB of C: refused before anything is written,
/// and before what comes behind is derived.
#[test]
fn all_functions_of_a_long_chain_are_refused() {
    let compiled = chain(60);
    let error = Emission::new(&compiled, "chain.urdf", &Functions::full()).unwrap_err();
    let function = "forward_dynamics_derivatives".to_string();
    assert_eq!(error, FunctionError::TooLarge { function });
    assert!(error.to_string().contains("1000000 operations"), "{error}");
    let help = error.help().expect("a mend");
    assert!(
        help.contains("--functions inverse_dynamics,forward_dynamics"),
        "{help}"
    );
}
