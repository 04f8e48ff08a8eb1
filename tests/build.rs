//! Every language model with functions on request, in Rust, for the tests of derivatives:
//! `OUT_DIR/full/*.rs`, and `OUT_DIR/full.rs`, which names the modules and calls their
//! functions by name.

use dynamics_codegen::emit::{Emission, Functions, Quantity, identifier, module_name};
use dynamics_codegen::{Compiled, Library, compile_bytes};
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Besides `full`, where a model can have them.
const MORE: [&str; 20] = [
    "force_residual",
    "acceleration_residual",
    "mass_matrix_by_position",
    "mass_matrix_by_parameters",
    "bias_force_by_position",
    "bias_force_by_velocity",
    "bias_force_by_parameters",
    "constraint_jacobian_by_position",
    "constraint_bias_by_position",
    "constraint_bias_by_velocity",
    "inverse_dynamics_by_parameters",
    "inverse_dynamics_by_time",
    "forward_dynamics_by_parameters",
    "forward_dynamics_by_time",
    "constrained_acceleration_by_parameters+constrained_multipliers_by_parameters",
    "outputs_by_position",
    "sensors",
    "sensors_by_position",
    "sensors_by_velocity",
    "predicted_sensors_by_time+predicted_sensors_by_parameters",
];

/// Robots whose functions are compared: the second one's derivatives come in parts.
const ROBOTS: [&str; 2] = ["../models/iiwa7.urdf", "../models/panda.urdf"];

/// The functions of a robot.
const ROBOT: &str = "mass_matrix+bias_force,inverse_dynamics,inverse_dynamics_derivatives,\
    forward_dynamics,forward_dynamics_derivatives,force_residual,residual_derivatives,\
    mass_matrix_by_position,bias_force_by_position,bias_force_by_velocity";

/// And of one with constraints.
const CONSTRAINED: &str =
    "acceleration_residual,constrained_dynamics,constrained_dynamics_derivatives";

/// The functions of a robot of many coordinates: those that solve, and what they solve with.
const MANY: &str = "inverse_dynamics,inverse_dynamics_derivatives,forward_dynamics,\
    forward_dynamics_derivatives,force_residual,residual_derivatives,\
    forward_dynamics_by_velocity,constrained_multipliers_by_input";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../models");
    println!("cargo::rerun-if-changed=data/models");
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::create_dir_all(out.join("full"))?;
    let mut modules = String::new();
    for path in models()? {
        let name = path.display().to_string();
        let bytes = std::fs::read(&path).map_err(|e| format!("{name}: {e}"))?;
        let mut library = Library::builtin();
        library.look_in(path.parent().unwrap_or(Path::new("")));
        let compiled = compile_bytes(&name, &bytes, &library).map_err(|report| report.render())?;
        // What remembers has other arguments; `tests/bead.rs` calls its functions.
        if !compiled.model.states.is_empty() || !compiled.model.delays.is_empty() {
            continue;
        }
        let list = match &compiled.model.robot {
            None => list(&compiled),
            Some(_) if compiled.model.coordinates.len() > 12 => format!("{MANY},{CONSTRAINED}"),
            Some(_) if compiled.model.constraints.is_empty() => ROBOT.to_string(),
            Some(_) => format!("{ROBOT},{CONSTRAINED}"),
        };
        let emission = Emission::new(&compiled, &name, &list.parse()?)?;
        let file = emission.rust_file();
        let path = out.join("full").join(&file.name);
        std::fs::write(&path, file.text)?;
        let module = module_name(&compiled);
        writeln!(
            modules,
            "#[path = {path:?}]\npub mod {module};\n\
             pub mod call_{module} {{\nuse super::{module} as module;\n\
             pub const FUNCTIONS: &str = {list:?};"
        )?;
        calls(&mut modules, &emission, &compiled)?;
        modules.push_str("}\n");
    }
    std::fs::write(out.join("full.rs"), modules)?;
    Ok(())
}

/// Everything that a model can have.
fn list(compiled: &Compiled) -> String {
    let possible = |name: &&str| {
        let functions: Result<Functions, _> = name.parse();
        functions.is_ok_and(|functions| Emission::new(compiled, "", &functions).is_ok())
    };
    let more: Vec<&str> = MORE.into_iter().filter(possible).collect();
    [&["full"], more.as_slice()].concat().join(",")
}

/// A function that calls the module's functions by name; arguments are
/// `t, q, v, u, parameters, a, λ`.
fn calls(out: &mut String, emission: &Emission<'_>, compiled: &Compiled) -> std::fmt::Result {
    let model = &compiled.model;
    let (n, k, m) = (
        model.coordinates.len(),
        model.inputs.len(),
        model.constraints.len(),
    );
    let mut start = 0;
    let mut take = |length: usize| {
        let range = format!("core::array::from_fn(|i| arguments[{start} + i])");
        start += length;
        range
    };
    let _time = take(1);
    let point = [take(n), take(n), take(k)];
    let parameters: Vec<String> = (model.parameters.iter().enumerate())
        .map(|(i, p)| format!("{}: arguments[{}]", identifier(&p.name), 1 + 2 * n + k + i))
        .collect();
    let _parameters = take(model.parameters.len());
    let stated = [take(n), take(m)];
    writeln!(
        out,
        "pub fn call<T: dynamics::Scalar>(function: &str, arguments: &[T]) -> Vec<Vec<T>> {{\n\
         let x = dynamics::Point {{ t: arguments[0], q: {}, v: {}, u: {}, z: [] }};\n\
         let a: [T; {n}] = {}; let lambda: [T; {m}] = {};",
        point[0], point[1], point[2], stated[0], stated[1]
    )?;
    if parameters.is_empty() {
        writeln!(out, "let p = module::Parameters::nominal();")?;
    } else {
        writeln!(
            out,
            "let p = module::Parameters {{ {} }};",
            parameters.join(", ")
        )?;
    }
    writeln!(out, "let _ = (&a, &lambda);\nmatch function {{")?;
    for (name, quantities) in emission.functions() {
        let takes = |which: fn(&Quantity) -> bool| quantities.iter().any(which);
        let a = if takes(|q| q.item.is_some_and(|item| item.term.takes_acceleration())) {
            ", &a"
        } else {
            ""
        };
        let lambda = if takes(|q| q.item.is_some_and(|item| item.term.takes_multipliers())) {
            ", &lambda"
        } else {
            ""
        };
        let single = quantities.len() == 1 && quantities[0].name == name;
        let values = quantities.iter().map(|q| {
            let field = if single {
                String::new()
            } else {
                format!(".{}", q.name)
            };
            let flat = ".concat()".repeat(q.axes.len() - 1);
            let flat = if flat.is_empty() { ".to_vec()" } else { &flat };
            format!("r{field}{flat}")
        });
        let values = values.collect::<Vec<_>>().join(", ");
        writeln!(
            out,
            "{name:?} => {{ let r = module::{name}(&p, &x{a}{lambda}); vec![{values}] }}"
        )?;
    }
    writeln!(out, "_ => panic!(\"no function {{function}}\"),\n}}\n}}")
}

fn models() -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut paths = ROBOTS.map(PathBuf::from).to_vec();
    paths.push(PathBuf::from("data/models/type.model"));
    paths.push(PathBuf::from("data/models/sensed.model"));
    paths.push(PathBuf::from("data/models/limbs.model"));
    for entry in std::fs::read_dir(Path::new("../models"))? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "model") {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}
