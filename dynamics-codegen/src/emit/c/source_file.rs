//! The `.c` file: definitions.

use super::language::{C, HELPERS, MATH, argument, real};
use super::{Lines, Unit, comment};
use crate::emit::body::{Body, Statement, Term};
use crate::emit::plan::Function;
use crate::emit::symbols::Argument;
use crate::emit::written::Language;

impl Unit<'_> {
    /// The whole file.
    pub(super) fn source_file(&self) -> String {
        let mut definitions = Lines::default();
        for function in &self.plan.functions {
            self.definition(&mut definitions, function);
        }
        let mut w = Lines::default();
        self.title(&mut w);
        w.line(&format!("#include \"{}.h\"", self.file));
        w.blank();
        w.line("#include <math.h>");
        w.blank();
        self.macros(&mut w, &definitions.text);
        self.helpers(&mut w, &definitions.text);
        self.nominal(&mut w);
        w.text.push_str(definitions.text.trim_end());
        w.text.push('\n');
        w.text
    }

    /// Constants and functions in the chosen precision; those that are used.
    fn macros(&self, w: &mut Lines, code: &str) {
        w.line(&format!("#define REAL(x) (({}_real)(x))", self.prefix));
        let used = MATH
            .iter()
            .filter(|(name, ..)| code.contains(&format!("{name}(")));
        let used: Vec<_> = used.collect();
        if !used.is_empty() {
            w.line("#ifdef DYNAMICS_FLOAT");
            for (name, arguments, function) in &used {
                w.line(&format!(
                    "#define {name}({arguments}) {function}f({arguments})"
                ));
            }
            w.line("#else");
            for (name, arguments, function) in &used {
                w.line(&format!(
                    "#define {name}({arguments}) {function}({arguments})"
                ));
            }
            w.line("#endif");
        }
        w.blank();
    }

    fn helpers(&self, w: &mut Lines, code: &str) {
        for (name, doc, value) in HELPERS {
            if code.contains(&format!("{name}(")) {
                comment(w, 0, doc);
                w.line(&format!("static {0}_real {name}({0}_real x)", self.prefix));
                w.line("{");
                w.line(&format!("    return {value};"));
                w.line("}");
                w.blank();
            }
        }
    }

    fn nominal(&self, w: &mut Lines) {
        let prefix = &self.prefix;
        w.line(&format!("const {prefix}_parameters {prefix}_nominal = {{"));
        let parameters = &self.plan.model.parameters;
        if parameters.is_empty() {
            w.line("    0");
        }
        for (index, p) in parameters.iter().enumerate() {
            let comma = if index + 1 < parameters.len() {
                ","
            } else {
                ""
            };
            w.line(&format!("    {}{comma}", real(p.nominal)));
        }
        w.line("};");
        w.blank();
    }

    fn definition(&self, w: &mut Lines, function: &Function) {
        let body = function.body(&self.plan.model, &self.symbols);
        self.signature(w, function, "");
        w.line("{");
        self.prologue(w, function, &body);
        self.statements(w, &body);
        let mut results = body.results.iter();
        for quantity in &function.quantities {
            let target = if function.fused {
                format!("out->{}", quantity.name)
            } else {
                "out".to_string()
            };
            for (index, result) in results.by_ref().take(quantity.entries.len()).enumerate() {
                let place = place(&quantity.shape(), index);
                w.line(&format!(
                    "    {target}{place} = {};",
                    self.write(result, &body)
                ));
            }
        }
        w.line("}");
        w.blank();
    }

    /// Takes out of the point what the body reads.
    fn prologue(&self, w: &mut Lines, function: &Function, body: &Body) {
        let multipliers = function.takes_multipliers() && !self.plan.model.constraints.is_empty();
        let arguments = [
            ("p", Argument::Parameters, true),
            ("x", Argument::Point, true),
            ("a", Argument::Acceleration, function.takes_acceleration()),
            ("lambda", Argument::Multipliers, multipliers),
        ];
        for (name, argument, there) in arguments {
            if there && !body.reads_any(|role| role.argument() == argument) {
                w.line(&format!("    (void){name};"));
            }
        }
        for (name, role) in self.symbols.read_by(body) {
            if let Some(place) = role.place("->") {
                w.line(&format!("    const {}_real {name} = {place};", self.prefix));
            }
        }
    }

    fn statements(&self, w: &mut Lines, body: &Body) {
        let mut constant = |local: usize, value: String| {
            let name = &body.locals[local];
            w.line(&format!("    const {}_real {name} = {value};", self.prefix));
        };
        for statement in &body.statements {
            match statement {
                Statement::Let { local, value } => constant(*local, self.write(value, body)),
                Statement::SinCos {
                    sine,
                    cosine,
                    argument,
                } => {
                    let argument = self.write(argument, body);
                    constant(*sine, format!("SIN({argument})"));
                    constant(*cosine, format!("COS({argument})"));
                }
                Statement::SinCosEach(group) => {
                    for c in group {
                        let argument = self.write(&c.argument, body);
                        constant(c.sine, format!("SIN({argument})"));
                        constant(c.cosine, format!("COS({argument})"));
                    }
                }
            }
        }
    }

    fn write(&self, term: &Term, body: &Body) -> String {
        let language = C {
            symbols: &self.symbols,
        };
        argument(language.write(term, &body.locals))
    }
}

/// `[1][2]`: where entry `index` of an array stands.
fn place(shape: &[usize], index: usize) -> String {
    let mut rest = index;
    let mut place = String::new();
    for &length in shape.iter().rev() {
        place.insert_str(0, &format!("[{}]", rest % length));
        rest /= length;
    }
    place
}
