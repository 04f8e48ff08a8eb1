//! The arm that is timed, in Rust and C.

use dynamics_codegen::emit::{Emission, Entry, Quantity};
use dynamics_codegen::graph::ExprId;
use dynamics_codegen::tree::Frame;
use dynamics_codegen::{Library, compile_bytes};
use std::error::Error;
use std::path::PathBuf;

const MODEL: &str = "../models/iiwa7.urdf";
const FUNCTIONS: &str = "mass_matrix+bias_force,inverse_dynamics,forward_dynamics,\
    inverse_dynamics_derivatives,forward_dynamics_derivatives";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={MODEL}");
    let bytes = std::fs::read(MODEL).map_err(|e| format!("{MODEL}: {e}"))?;
    let compiled = compile_bytes("models/iiwa7.urdf", &bytes, &Library::builtin())
        .map_err(|report| report.render())?;
    let mut emission = Emission::new(&compiled, "models/iiwa7.urdf", &FUNCTIONS.parse()?)?;
    tool(&compiled, &mut emission)?;
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("iiwa7.rs"), emission.rust())?;
    for file in emission.c() {
        std::fs::write(out.join(&file.name), file.text)?;
    }
    Ok(())
}

/// The Jacobian of the last link's frame with its rate, and the motion with the origin of
/// that frame held at its height.
fn tool(
    compiled: &dynamics_codegen::Compiled,
    emission: &mut Emission<'_>,
) -> Result<(), Box<dyn Error>> {
    let model = &compiled.model;
    let mechanism = model.mechanism.clone().ok_or("the model has bodies")?;
    let mut bodies = model.tree.bodies.iter();
    let link = bodies.position(|b| b.name == "link_7").ok_or("there is link_7")?;
    let applied: Vec<ExprId> = model.inputs.iter().map(|u| model.graph.var(u.symbol)).collect();
    let g = emission.graph_mut();
    let frame = Frame::of_body(g, link);
    let jacobian = mechanism.jacobian(g, &frame);
    let rate = mechanism.jacobian_rate(g, &frame);
    let drift = mechanism.jacobian_rate_times_velocity(g, &frame)[2];
    let bias = g.neg(drift);
    let held = [jacobian[2].clone()];
    let motion = mechanism.constrained_forward_dynamics(g, &applied, &held, &[bias]);
    let axis = |names: &[&str]| -> Vec<Entry> {
        let entry = |name: &&str| Entry {
            name: (*name).to_string(),
            unit: String::new(),
        };
        names.iter().map(entry).collect()
    };
    let joints: Vec<&str> = model.coordinates.iter().map(|c| c.name.as_str()).collect();
    let (joints, twist) = (axis(&joints), axis(&["vx", "vy", "vz", "wx", "wy", "wz"]));
    let matrix = |name: &str, entries: &[Vec<ExprId>]| {
        let axes = vec![twist.clone(), joints.clone()];
        Quantity::own(name, "Jacobian of the last link's frame, or its rate", axes, entries.concat())
    };
    let vector = |name: &str, axis: &[Entry], entries: Vec<ExprId>| {
        Quantity::own(name, "Motion with the tool held", vec![axis.to_vec()], entries)
    };
    emission.add("jacobian", vec![matrix("jacobian", &jacobian)]);
    emission.add(
        "jacobian_and_rate",
        vec![matrix("jacobian", &jacobian), matrix("rate", &rate)],
    );
    emission.add(
        "contact",
        vec![
            vector("acceleration", &joints, motion.acceleration),
            vector("multiplier", &axis(&["normal"]), motion.multipliers),
        ],
    );
    Ok(())
}
