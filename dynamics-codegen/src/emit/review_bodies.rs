//! The part of a review sheet about bodies: masses, gravity, what was rounded and
//! regrouped.

use super::review::{columns, heading};
use super::text::{decimal, one_line};
use crate::graph::ExprId;
use crate::model::Model;
use crate::tree::{Joint, Layout};
use std::fmt::Write as _;

/// Bodies with their joints and inertias, and what the derivation did to them.
pub(super) fn bodies(out: &mut String, model: &Model) -> std::fmt::Result {
    let Some(mechanism) = &model.mechanism else {
        return Ok(());
    };
    let text = |expr: ExprId| match model.graph.as_constant(expr) {
        Some(value) => decimal(value),
        None => one_line(
            &model
                .graph
                .display(expr, |id| model.graph.symbol_name(id).to_string())
                .to_string(),
        ),
    };
    heading(out, "bodies", model.bodies.len())?;
    let rows = model.bodies.iter().map(|body| {
        let massive = &model.tree.bodies[body.massive];
        let [x, y, z] = massive.inertia.center.map(text);
        let tensor = &massive.inertia.tensor;
        let [xx, yy, zz] = [0, 1, 2].map(|i| text(tensor[i][i]));
        let parent = massive
            .parent
            .map_or("world", |p| &model.tree.bodies[p].name);
        // A body of the language sits on the frame of its own name.
        let carrier = if parent == body.name {
            String::new()
        } else {
            format!("{} {}", joint(&massive.joint), one_line(parent))
        };
        [
            one_line(&body.name),
            carrier,
            format!("m {}", text(massive.inertia.mass)),
            format!("at ({x}, {y}, {z})"),
            format!("I ({xx}, {yy}, {zz})"),
            one_line(&body.doc),
        ]
    });
    columns(out, &rows.collect::<Vec<_>>())?;
    let gravity = model.tree.gravity.map(text);
    writeln!(out, "  gravity ({})", gravity.join(", "))?;
    if let Some(robot) = &model.robot {
        let snapped = &robot.snapped;
        writeln!(
            out,
            "  from {}: {} rotation entries rounded to 0 or 1, by {} at most",
            one_line(&robot.file),
            snapped.count,
            if snapped.largest > 0.0 {
                format!("{:.1e}", snapped.largest)
            } else {
                "0".to_string()
            }
        )?;
    }
    let report = mechanism.report();
    let moved: usize = report.regrouped.iter().map(|entry| entry.constants).sum();
    writeln!(
        out,
        "  base parameters: {moved} inertial constants moved to their parents, exactly"
    )?;
    let layout = match report.layout {
        Some(Layout::Distal) => "nearest to the parent's axis",
        Some(Layout::Proximal) => "nearest to the child's axis",
        _ => "as described",
    };
    writeln!(out, "  link frames: {layout}")
}

fn joint(joint: &Joint) -> &'static str {
    match joint {
        Joint::Fixed => "on",
        Joint::Revolute { .. } => "turns on",
        Joint::Prismatic { .. } => "slides on",
        Joint::Planar { .. } => "in a plane of",
        Joint::Ball(_) => "turns freely on",
        Joint::Floating(_) | Joint::Free(_) => "free of",
        Joint::Driven { .. } => "driven on",
    }
}
