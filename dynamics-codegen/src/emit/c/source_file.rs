//! The `.c` file: definitions.

use super::language::{C, HELPERS, MATH, argument, real};
use super::{Lines, Unit, comment};
use crate::emit::body::{Body, Statement, Term};
use crate::emit::plan::Function;
use crate::emit::symbols::Role;
use crate::emit::written::Language;

impl Unit<'_> {
    /// The whole file.
    pub(super) fn source_file(&self, functions: &[Function<'_>]) -> String {
        let mut definitions = Lines::default();
        for function in functions {
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
        let parameters = &self.compiled.model.parameters;
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

    fn definition(&self, w: &mut Lines, function: &Function<'_>) {
        let body = function.body(self.compiled, &self.symbols);
        self.signature(w, function, "");
        w.line("{");
        self.prologue(w, &body);
        self.statements(w, &body);
        let mut results = body.results.iter();
        for quantity in &function.quantities {
            let target = if function.is_fused() {
                format!("out->{}", quantity.name)
            } else {
                "out".to_string()
            };
            let columns = quantity.columns.as_ref().map(Vec::len);
            for (index, result) in results.by_ref().take(quantity.entries.len()).enumerate() {
                let place = match columns {
                    None => format!("[{index}]"),
                    Some(columns) => format!("[{}][{}]", index / columns, index % columns),
                };
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
    fn prologue(&self, w: &mut Lines, body: &Body) {
        if !body.reads_any(|role| matches!(role, Role::Parameter(_))) {
            w.line("    (void)p;");
        }
        if !body.reads_any(|role| !matches!(role, Role::Parameter(_))) {
            w.line("    (void)x;");
        }
        for (name, role) in self.symbols.read_by(body) {
            let place = match role {
                Role::Time => "t".to_string(),
                Role::Position(i) => format!("q[{i}]"),
                Role::Velocity(i) => format!("v[{i}]"),
                Role::Input(i) => format!("u[{i}]"),
                Role::State(i) => format!("z[{i}]"),
                Role::Parameter(_) => continue,
            };
            w.line(&format!(
                "    const {}_real {name} = x->{place};",
                self.prefix
            ));
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
