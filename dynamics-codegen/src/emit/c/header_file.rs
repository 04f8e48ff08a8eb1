//! The `.h` file: types and declarations.

use super::{Lines, Unit, comment};
use crate::dimension::shown_unit;
use crate::emit::axes::{coordinate_unit, inputs, positions};
use crate::emit::indices::indices;
use crate::emit::naming::c_member;
use crate::emit::plan::{Entry, Function, Quantity};
use crate::emit::text::{decimal, one_line};
use crate::model::Parameter;

/// What the velocities of a floating body are.
const TWIST: &str = "\nOf a body that floats these are its twist, in its own frame: with R and eta of its\nquaternion (x, y, z, w, a unit), its position changes by R (vx, vy, vz), and eta by\n1/2 eta * (wx, wy, wz, 0). Keep eta a unit. Derivatives by q are by displacements of\nthe displaced body along its twist, as many as velocities.";

/// `out[2][3]` or `out[2]`.
pub(super) fn dimensions(quantity: &Quantity) -> String {
    let lengths = quantity.shape().into_iter();
    lengths.map(|length| format!("[{length}]")).collect()
}

fn list(entries: impl IntoIterator<Item = (String, String)>) -> String {
    let items = entries.into_iter().map(|(name, unit)| match unit.as_str() {
        "" => one_line(&name),
        unit => format!("{} ({unit})", one_line(&name)),
    });
    items.collect::<Vec<_>>().join(", ")
}

fn entries(entries: &[Entry]) -> String {
    list(entries.iter().map(|e| (e.name.clone(), e.unit.clone())))
}

fn describe(quantity: &Quantity) -> String {
    let meaning = quantity.meaning.replace('`', "");
    let mut lines = vec![format!("{meaning}.")];
    lines.extend(quantity.notes(entries));
    lines.join("\n")
}

impl Unit<'_> {
    /// The whole file.
    pub(super) fn header_file(&self) -> String {
        let mut w = Lines::default();
        self.title(&mut w);
        let guard = format!("DYNAMICS_{}_H", self.prefix);
        w.line(&format!("#ifndef {guard}"));
        w.line(&format!("#define {guard}"));
        w.blank();
        w.line("#ifdef __cplusplus");
        w.line("extern \"C\" {");
        w.line("#endif");
        w.blank();
        self.types(&mut w);
        for function in &self.plan.functions {
            if function.fused {
                self.result_struct(&mut w, function);
            }
            self.declaration(&mut w, function);
        }
        w.line("#ifdef __cplusplus");
        w.line("}");
        w.line("#endif");
        w.blank();
        w.line(&format!("#endif /* {guard} */"));
        w.text
    }

    fn types(&self, w: &mut Lines) {
        let prefix = &self.prefix;
        comment(
            w,
            0,
            "The real number type: double, or float if DYNAMICS_FLOAT is defined, for every\nfile that includes this one: what is computed in float has names of its own, so\nthat files that differ do not link.",
        );
        w.line("#ifdef DYNAMICS_FLOAT");
        w.line(&format!("typedef float {prefix}_real;"));
        for name in self.linked_names() {
            w.line(&format!("#define {name} {name}_float"));
        }
        w.line("#else");
        w.line(&format!("typedef double {prefix}_real;"));
        w.line("#endif");
        w.blank();
        self.parameters_type(w);
        self.point_type(w);
        self.index_names(w);
    }

    /// `cartpole_q_theta`, …
    fn index_names(&self, w: &mut Lines) {
        for indices in indices(&self.plan.model) {
            if indices.entries.is_empty() {
                continue;
            }
            let arrays = indices.arrays.replace('`', "");
            comment(w, 0, &format!("Places in {arrays}."));
            w.line("enum {");
            let last = indices.entries.len() - 1;
            for index in &indices.entries {
                let comma = if index.place == last { "" } else { "," };
                w.line(&format!(
                    "    {}_{} = {}{comma}",
                    self.prefix, index.code, index.place
                ));
            }
            w.line("};");
            w.blank();
        }
    }

    /// Everything that the linker sees.
    fn linked_names(&self) -> impl Iterator<Item = String> {
        let functions = self.plan.functions.iter().map(|f| f.name.as_str());
        let names = std::iter::once("nominal").chain(functions);
        names.map(|name| format!("{}_{name}", self.prefix))
    }

    fn parameters_type(&self, w: &mut Lines) {
        let prefix = &self.prefix;
        let parameters = &self.plan.model.parameters;
        comment(w, 0, "The model's parameters.");
        w.line(&format!("typedef struct {prefix}_parameters {{"));
        if parameters.is_empty() {
            w.line("    char none; /* a struct must not be empty */");
        }
        for p in parameters {
            comment(w, 1, &describe_parameter(p));
            w.line(&format!("    {prefix}_real {};", c_member(&p.name)));
        }
        w.line(&format!("}} {prefix}_parameters;"));
        w.blank();
        comment(w, 0, "The nominal values.");
        w.line(&format!(
            "extern const {prefix}_parameters {prefix}_nominal;"
        ));
        w.blank();
    }

    fn point_type(&self, w: &mut Lines) {
        let (prefix, model) = (&self.prefix, &self.plan.model);
        let coordinates = |order| {
            list(
                model
                    .coordinates
                    .iter()
                    .map(|c| (c.name.clone(), coordinate_unit(c, order))),
            )
        };
        let n = model.coordinates.len();
        let positions = positions(model, 0);
        comment(w, 0, "Where the model is evaluated.");
        w.line(&format!("typedef struct {prefix}_point {{"));
        comment(w, 1, "Time (s).");
        w.line(&format!("    {prefix}_real t;"));
        let (title, note) = if model.poses.is_empty() {
            ("Coordinates", "")
        } else {
            ("Positions", TWIST)
        };
        comment(w, 1, &format!("{title}: {}.", entries(&positions)));
        w.line(&format!("    {prefix}_real q[{}];", positions.len()));
        comment(w, 1, &format!("Velocities: {}.{note}", coordinates(1)));
        w.line(&format!("    {prefix}_real v[{n}];"));
        let inputs = inputs(model);
        if !inputs.is_empty() {
            let mut text = format!("Inputs: {}.", entries(&inputs));
            for delay in &model.delays {
                let of = &model.inputs[delay.input].name;
                let name = |id| one_line(model.graph.symbol_name(id));
                let by = model.graph.display(delay.by, name);
                text.push_str(&format!(
                    "\n{} is {} as it was {by} seconds ago: the caller keeps its past.",
                    one_line(&delay.name),
                    one_line(of)
                ));
            }
            if model.uses_multipliers() {
                text.push_str(
                    "\nForces depend on the constraints' multipliers lambda, in the last places. \
                     Begin with 0,\nsolve, put the multipliers found here, and repeat until \
                     they stand still.",
                );
            }
            comment(w, 1, &text);
            w.line(&format!("    {prefix}_real u[{}];", inputs.len()));
        }
        if !model.states.is_empty() {
            let states = model.states.iter();
            let states = states.map(|z| (z.name.clone(), shown_unit(&z.unit)));
            comment(w, 1, &format!("Internal states: {}.", list(states)));
            w.line(&format!("    {prefix}_real z[{}];", model.states.len()));
        }
        w.line(&format!("}} {prefix}_point;"));
        w.blank();
    }

    /// The struct that a function of several quantities fills.
    fn result_struct(&self, w: &mut Lines, function: &Function) {
        let (prefix, name) = (&self.prefix, self.result_type(function));
        let meaning = function.meaning.replace('`', "");
        comment(w, 0, &format!("{meaning}."));
        w.line(&format!("typedef struct {name} {{"));
        for quantity in &function.quantities {
            comment(w, 1, &describe(quantity));
            let dimensions = dimensions(quantity);
            w.line(&format!("    {prefix}_real {}{dimensions};", quantity.name));
        }
        w.line(&format!("}} {name};"));
        w.blank();
    }

    fn declaration(&self, w: &mut Lines, function: &Function) {
        if function.fused {
            let meaning = function.meaning.replace('`', "");
            comment(w, 0, &format!("{meaning}; shared terms are computed once."));
        } else {
            comment(w, 0, &describe(&function.quantities[0]));
        }
        self.signature(w, function, ";");
        w.blank();
    }
}

fn describe_parameter(p: &Parameter) -> String {
    let mut facts = one_line(&p.name);
    if !p.unit.is_empty() {
        facts.push_str(&format!(" ({})", shown_unit(&p.unit)));
    }
    facts.push_str(&format!("; nominal {}", decimal(p.nominal)));
    if p.lower.is_finite() {
        facts.push_str(&format!(", at least {}", decimal(p.lower)));
    }
    if p.upper.is_finite() {
        facts.push_str(&format!(", at most {}", decimal(p.upper)));
    }
    if p.doc.is_empty() {
        format!("{facts}.")
    } else {
        format!("{}\n{facts}.", p.doc)
    }
}
