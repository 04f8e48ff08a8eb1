//! The `.c` file: definitions.

use super::language::{C, HELPERS, MATH, argument, real};
use super::{Lines, Unit, comment};
use crate::emit::body::{Body, Statement, Term};
use crate::emit::plan::Function;
use crate::emit::split::{Part, Parts};
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
        self.solver(&mut w);
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
        if let Some(solved) = &function.solved {
            return self.solved_definition(w, function, solved);
        }
        let body = function.body(&self.plan.model, &self.symbols);
        let parts = Parts::of(&body, &self.symbols);
        let (own, before) = parts.parts.split_last().expect("there is a last part");
        for (index, part) in before.iter().enumerate() {
            self.part_definition(w, function, &body, (index + 1, part, parts.places));
        }
        self.signature(w, function, "");
        w.line("{");
        if parts.are_several() {
            w.line(&format!("    {}_real w[{}];", self.prefix, parts.places));
        }
        self.prologue(w, function, &body, (own, &parts));
        self.statements(w, &body, own);
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

    /// A part of a long body as a function of its own.
    fn part_definition(
        &self,
        w: &mut Lines,
        function: &Function,
        body: &Body,
        (number, part, places): (usize, &Part, usize),
    ) {
        let (prefix, name) = (&self.prefix, &function.name);
        comment(
            w,
            0,
            &format!("Part {number} of {name}; w carries temporaries from part to part."),
        );
        w.line(&format!("static void {prefix}_{name}_part_{number}("));
        for (_, declaration) in self.argument_list(function, part) {
            w.line(&format!("    {declaration},"));
        }
        w.line(&format!("    {prefix}_real w[{places}])"));
        w.line("{");
        self.reading(w, part, body);
        self.statements(w, body, part);
        for &(local, place) in &part.gives {
            w.line(&format!("    w[{place}] = {};", body.locals[local]));
        }
        w.line("}");
        w.blank();
    }

    /// The arguments that a part reads: names and declarations.
    fn argument_list(&self, function: &Function, part: &Part) -> Vec<(&'static str, String)> {
        let (prefix, model) = (&self.prefix, &self.plan.model);
        let stated = |name: &str, length: usize| format!("const {prefix}_real {name}[{length}]");
        let (n, m) = (model.coordinates.len(), model.constraints.len());
        let all = [
            (
                "p",
                Argument::Parameters,
                format!("const {prefix}_parameters *p"),
            ),
            ("x", Argument::Point, format!("const {prefix}_point *x")),
            ("a", Argument::Acceleration, stated("a", n)),
            ("lambda", Argument::Multipliers, stated("lambda", m)),
        ];
        debug_assert!(function.takes_acceleration() || !part.reads_of(Argument::Acceleration));
        let read = all
            .into_iter()
            .filter(|(_, argument, _)| part.reads_of(*argument));
        read.map(|(name, _, declaration)| (name, declaration))
            .collect()
    }

    /// Says which arguments are not read, runs the parts before, and takes out of the
    /// arguments and of what they left what the last part reads.
    fn prologue(
        &self,
        w: &mut Lines,
        function: &Function,
        body: &Body,
        (own, parts): (&Part, &Parts),
    ) {
        // C99 allows statements between declarations.
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
        for (index, part) in parts.parts.iter().enumerate().take(parts.parts.len() - 1) {
            let arguments = self.argument_list(function, part);
            let names: Vec<&str> = arguments.iter().map(|(name, _)| *name).collect();
            let names = [names.as_slice(), &["w"]].concat().join(", ");
            let call = format!("{}_{}_part_{}", self.prefix, function.name, index + 1);
            w.line(&format!("    {call}({names});"));
        }
        self.reading(w, own, body);
    }

    /// Arguments and carried temporaries that a part reads.
    fn reading(&self, w: &mut Lines, part: &Part, body: &Body) {
        for (name, role) in self.symbols.read_by(&part.reads) {
            if let Some(place) = role.place("->") {
                w.line(&format!("    const {}_real {name} = {place};", self.prefix));
            }
        }
        for &(local, place) in &part.takes {
            let name = &body.locals[local];
            w.line(&format!(
                "    const {}_real {name} = w[{place}];",
                self.prefix
            ));
        }
    }

    fn statements(&self, w: &mut Lines, body: &Body, part: &Part) {
        let mut constant = |local: usize, value: String| {
            let name = &body.locals[local];
            w.line(&format!("    const {}_real {name} = {value};", self.prefix));
        };
        for statement in &body.statements[part.statements.clone()] {
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
