//! `dynamics check`: what a model contains.

use crate::mistake::Mistake;
use crate::model::{Loaded, ModelArguments};
use crate::output;
use crate::page::{Table, count, first_line};
use crate::parameters::{bounds, number};
use clap::Args;
use dynamics_codegen::derive::{Sensitivity, Variable};
use dynamics_codegen::graph::ExprId;
use dynamics_codegen::model::{ConstraintKind, Effect};
use dynamics_codegen::{Severity, System};
use serde_json::{Map, Value, json};
use std::io::Write;

/// Show what a model contains: coordinates, inputs, parameters, constraints, effects,
/// outputs; how many operations its equations cost; what is worth a warning.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  dynamics check models/pendulum2.model
  dynamics check models/fourbar.model --json | jq .operations")]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Print one JSON object instead of a page
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// If the model is faulty.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let loaded = arguments.model.load_quietly()?;
    let operations = operations(&loaded);
    if arguments.json {
        return output::print_json(&as_json(&loaded, &operations));
    }
    let page = as_page(&loaded, &operations);
    let mut out = output::stdout();
    out.write_all(page.as_bytes())?;
    out.flush()?;
    let warnings = &loaded.compiled.warnings;
    if !warnings.diagnostics.is_empty() {
        let colours = output::colours_on_stderr();
        output::complain(&Mistake::from(warnings.clone()).render(colours));
    }
    Ok(())
}

/// What a function of the model is called, its symbol, and what one state costs.
/// A subexpression that several entries of one function share is counted once.
struct Operations {
    name: &'static str,
    symbol: &'static str,
    count: usize,
}

fn operations(loaded: &Loaded) -> Vec<Operations> {
    let System {
        mass_matrix,
        bias_force,
        applied_force,
        input_matrix,
        force,
        constraint_matrix,
        constraint_bias,
        constraint_residual,
        constraint_rate,
        outputs,
        ..
    } = &loaded.compiled.system;
    let flat = |matrix: &[Vec<ExprId>]| matrix.concat();
    let (mass, inputs, rows) = (
        flat(mass_matrix),
        flat(input_matrix),
        flat(constraint_matrix),
    );
    let motion = [
        mass.clone(),
        force.clone(),
        rows.clone(),
        constraint_bias.clone(),
    ]
    .concat();
    let graph = &loaded.compiled.model.graph;
    let entry = |name, symbol, expressions: &[ExprId]| Operations {
        name,
        symbol,
        count: graph.operation_count(expressions),
    };
    vec![
        entry("mass_matrix", "M", &mass),
        entry("bias_force", "Q_C", bias_force),
        entry("applied_force", "Q_D", applied_force),
        entry("input_matrix", "B", &inputs),
        entry("force", "Q", force),
        entry("constraint_jacobian", "A", &rows),
        entry("constraint_bias", "b", constraint_bias),
        entry("constraint_residual", "c", constraint_residual),
        entry("constraint_rate", "c_dot", constraint_rate),
        entry("outputs", "y", outputs),
        entry("dynamics", "M, Q, A, b together", &motion),
        Operations {
            name: "derivatives",
            symbol: "their derivatives by q, v, u",
            count: derivative_count(loaded),
        },
    ]
}

fn derivative_count(loaded: &Loaded) -> usize {
    let (mut model, system) = (loaded.compiled.model.clone(), &loaded.compiled.system);
    let (n, k) = (model.coordinates.len(), model.inputs.len());
    let variables: Vec<Variable> = (0..n)
        .map(Variable::Position)
        .chain((0..n).map(Variable::Velocity))
        .chain((0..k).map(Variable::Input))
        .collect();
    let columns = Sensitivity::new(&mut model, system, &variables).columns;
    model.graph.operation_count(&columns.concat())
}

fn kind(kind: ConstraintKind) -> &'static str {
    match kind {
        ConstraintKind::Holonomic => "holonomic",
        ConstraintKind::Nonholonomic => "nonholonomic",
    }
}

fn places(effect: &Effect) -> Vec<&str> {
    effect.on.iter().map(|(_, name)| name.as_str()).collect()
}

fn as_json(loaded: &Loaded, operations: &[Operations]) -> Value {
    let model = &loaded.compiled.model;
    let finite = |value: f64| value.is_finite().then_some(value);
    let effect_name = |index: usize| {
        let effect = &model.effects[index];
        format!("{}({})", effect.template, places(effect).join(", "))
    };
    let unit = |dimension: Option<dynamics_codegen::dimension::Dimension>| {
        dimension.map(|dimension| dimension.to_string())
    };
    json!({
        "model": model.name,
        "file": loaded.path.display().to_string(),
        "description": model.doc,
        "sizes": {
            "coordinates": model.coordinates.len(),
            "inputs": model.inputs.len(),
            "parameters": model.parameters.len(),
            "constraints": model.constraints.len(),
            "effects": model.effects.len(),
            "outputs": model.outputs.len(),
        },
        "coordinates": model.coordinates.iter().map(|c| json!({
            "name": c.name, "unit": c.unit, "description": c.doc,
        })).collect::<Vec<_>>(),
        "inputs": model.inputs.iter().map(|u| json!({
            "name": u.name, "unit": u.unit, "description": u.doc,
        })).collect::<Vec<_>>(),
        "parameters": model.parameters.iter().zip(&loaded.parameters).map(|(p, value)| json!({
            "name": p.name, "unit": p.unit, "nominal": p.nominal, "value": value,
            "lower": finite(p.lower), "upper": finite(p.upper),
            "prior": p.prior.map(|(mean, sd)| json!({"mean": mean, "sd": sd})),
            "effect": p.effect.map(effect_name), "description": p.doc,
        })).collect::<Vec<_>>(),
        "constraints": model.constraints.iter().map(|c| json!({
            "name": c.name, "kind": kind(c.kind), "time_dependent": c.time_dependent,
            "unit": unit(c.dimension), "description": c.doc,
        })).collect::<Vec<_>>(),
        "effects": model.effects.iter().map(|e| json!({
            "effect": e.template, "on": places(e),
            "parameters": e.parameters.iter().map(|&p| &model.parameters[p].name).collect::<Vec<_>>(),
            "description": e.doc,
        })).collect::<Vec<_>>(),
        "outputs": model.outputs.iter().map(|y| json!({
            "name": y.name, "unit": unit(y.dimension), "description": y.doc,
        })).collect::<Vec<_>>(),
        "operations": operations.iter()
            .map(|o| (o.name.to_string(), Value::from(o.count))).collect::<Map<_, _>>(),
        "warnings": warnings(loaded),
    })
}

fn warnings(loaded: &Loaded) -> Vec<Value> {
    let report = &loaded.compiled.warnings;
    let warnings = report.diagnostics.iter();
    warnings
        .filter(|d| d.severity == Severity::Warning)
        .map(|d| {
            let (line, column) = report.sources.line_column(d.primary.span);
            let file = &report.sources.get(d.primary.span.source).name;
            json!({"message": d.message, "file": file, "line": line, "column": column, "help": d.help})
        })
        .collect()
}

fn as_page(loaded: &Loaded, operations: &[Operations]) -> String {
    let model = &loaded.compiled.model;
    let mut page = format!("{}  {}\n", model.name, loaded.path.display());
    for line in model.doc.lines() {
        page.push_str(&format!("  {line}").trim_end());
        page.push('\n');
    }
    let mut section = |title: String, table: &Table| {
        page.push_str(&format!("\n{title}\n{}", table.render()));
    };

    let mut table = Table::new("<<<");
    for c in &model.coordinates {
        table.row([&c.name, &c.unit, first_line(&c.doc)]);
    }
    section(count(model.coordinates.len(), "coordinate"), &table);

    let mut table = Table::new("<<<");
    for u in &model.inputs {
        table.row([&u.name, &u.unit, first_line(&u.doc)]);
    }
    section(count(model.inputs.len(), "input"), &table);

    section(
        count(model.parameters.len(), "parameter"),
        &parameters(loaded),
    );

    let mut table = Table::new("<<<<");
    for c in &model.constraints {
        let time = if c.time_dependent {
            "depends on time"
        } else {
            ""
        };
        table.row([&c.name, kind(c.kind), time, first_line(&c.doc)]);
    }
    section(count(model.constraints.len(), "constraint"), &table);

    if !model.effects.is_empty() {
        let mut table = Table::new("<<");
        for e in &model.effects {
            let call = format!("{}({})", e.template, places(e).join(", "));
            table.row([call.as_str(), first_line(&e.doc)]);
        }
        section(count(model.effects.len(), "effect"), &table);
    }
    if !model.outputs.is_empty() {
        let mut table = Table::new("<<<");
        for y in &model.outputs {
            let unit = y.dimension.map(|d| d.to_string()).unwrap_or_default();
            table.row([&y.name, &unit, first_line(&y.doc)]);
        }
        section(count(model.outputs.len(), "output"), &table);
    }

    let mut table = Table::new("<><");
    for o in operations.iter().filter(|o| o.count > 0) {
        table.row([o.name, &o.count.to_string(), o.symbol]);
    }
    section("operations per state".to_string(), &table);
    page
}

fn parameters(loaded: &Loaded) -> Table {
    let mut table = Table::new("<><<<<");
    let parameters = &loaded.compiled.model.parameters;
    for (p, &value) in parameters.iter().zip(&loaded.parameters) {
        let bounds = match bounds(p.lower, p.upper) {
            bounds if bounds.is_empty() => bounds,
            bounds => format!("in {bounds}"),
        };
        let nominal = if value == p.nominal {
            String::new()
        } else {
            format!("nominal {}", number(p.nominal))
        };
        let prior = p
            .prior
            .map(|(mean, sd)| format!("prior {} ± {}", number(mean), number(sd)));
        let remarks: Vec<&str> = [nominal.as_str(), prior.as_deref().unwrap_or("")]
            .into_iter()
            .filter(|remark| !remark.is_empty())
            .collect();
        table.row([
            &p.name,
            &number(value),
            &p.unit,
            &bounds,
            &remarks.join(", "),
            first_line(&p.doc),
        ]);
    }
    table
}
