//! The `.c` file: definitions.

use super::header_file::dimensions;
use super::language::{C, argument, preamble, real, write_statements};
use super::long::{Numbers, declare_side_by_side};
use super::{Lines, Unit, comment};
use crate::emit::body::Body;
use crate::emit::given::place;
use crate::emit::plan::Function;
use crate::emit::split::{Part, Parts};
use crate::emit::symbols::Argument;
use crate::emit::written::Language;

/// A function without loops, in parts that a compiler can take.
struct Straight {
    body: Body,
    parts: Parts,
}

impl Unit<'_> {
    /// The whole file.
    pub(super) fn source_file(&self) -> String {
        let written: Vec<Option<Straight>> = self
            .plan
            .functions
            .iter()
            .map(|f| self.straight(f))
            .collect();
        let long = written
            .iter()
            .flatten()
            .filter(|straight| straight.parts.are_several());
        let numbers = Numbers::of(long.map(|straight| &straight.body));
        let mut definitions = Lines::default();
        for (function, straight) in self.plan.functions.iter().zip(&written) {
            match (&function.solved, straight) {
                (_, Some(straight)) => {
                    self.definition(&mut definitions, function, (straight, &numbers))
                }
                (Some(solved), None) => self.solved_definition(&mut definitions, function, solved),
                (None, None) => unreachable!("what is not solved in loops is straight"),
            }
        }
        let mut w = Lines::default();
        self.title(&mut w);
        w.line(&format!("#include \"{}.h\"", self.file));
        w.blank();
        w.line("#include <math.h>");
        w.blank();
        preamble(&mut w, &self.prefix, &definitions.text);
        self.nominal(&mut w);
        self.solver(&mut w);
        numbers.define(&mut w, &self.prefix);
        w.text.push_str(definitions.text.trim_end());
        w.text.push('\n');
        w.text
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

    /// A function without loops; `None` for one that solves in them.
    fn straight(&self, function: &Function) -> Option<Straight> {
        if function.solved.is_some() {
            return None;
        }
        let body = function.body(&self.plan.model, &self.symbols, "->");
        let parts = Parts::of(&body, &self.symbols);
        Some(Straight { body, parts })
    }

    fn definition(
        &self,
        w: &mut Lines,
        function: &Function,
        (straight, numbers): (&Straight, &Numbers),
    ) {
        let Straight { body, parts } = straight;
        let language = C {
            symbols: &self.symbols,
            numbers,
        };
        let (own, before) = parts.parts.split_last().expect("there is a last part");
        for (index, part) in before.iter().enumerate() {
            self.part_definition(w, function, (straight, &language), (index + 1, part));
        }
        self.signature(w, function, "");
        w.line("{");
        if parts.are_several() {
            w.line(&format!("    {}_real w[{}];", self.prefix, parts.places));
        }
        if let Some(giver) = self.plan.giver(function) {
            w.line(&format!("    {};", self.given(giver)));
        }
        self.prologue(w, function, straight, own);
        self.statements(w, (straight, &language), own);
        let mut results = body.results.iter();
        for quantity in &function.quantities {
            let target = if function.fused {
                format!("out->{}", quantity.name)
            } else {
                "out".to_string()
            };
            for (index, result) in results.by_ref().take(quantity.entries.len()).enumerate() {
                let place = place(quantity, index);
                w.line(&format!(
                    "    {target}{place} = {};",
                    argument(language.write(result, &body.locals))
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
        (straight, language): (&Straight, &C<'_>),
        (number, part): (usize, &Part),
    ) {
        let Straight { body, parts } = straight;
        let (prefix, name) = (&self.prefix, &function.name);
        comment(
            w,
            0,
            &format!("Part {number} of {name}; w carries temporaries from part to part."),
        );
        w.line(&format!("static void {prefix}_{name}_part_{number}("));
        for (_, declaration) in self.argument_list(|argument| part.reads_of(argument)) {
            w.line(&format!("    {declaration},"));
        }
        if let Some(giver) = self.plan.giver(function).filter(|_| part.reads_given) {
            w.line(&format!("    {},", self.given_argument(giver)));
        }
        w.line(&format!("    {prefix}_real w[{}])", parts.places));
        w.line("{");
        self.reading(w, straight, part);
        self.statements(w, (straight, language), part);
        for &(local, place) in &part.gives {
            w.line(&format!("    w[{place}] = {};", body.locals[local]));
        }
        w.line("}");
        w.blank();
    }

    /// The arguments that are wanted: names and declarations.
    fn argument_list(&self, wanted: impl Fn(Argument) -> bool) -> Vec<(&'static str, String)> {
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
        let read = all.into_iter().filter(|(_, argument, _)| wanted(*argument));
        read.map(|(name, _, declaration)| (name, declaration))
            .collect()
    }

    /// Says which arguments are not read, runs the parts before, and takes out of the
    /// arguments and of what they left what the last part reads.
    fn prologue(&self, w: &mut Lines, function: &Function, straight: &Straight, own: &Part) {
        let Straight { body, parts } = straight;
        // C99 allows statements between declarations.
        let giver = self.plan.giver(function);
        let multipliers = function.takes_multipliers() && !self.plan.model.constraints.is_empty();
        let arguments = [
            ("p", Argument::Parameters, true),
            ("x", Argument::Point, true),
            ("a", Argument::Acceleration, function.takes_acceleration()),
            ("lambda", Argument::Multipliers, multipliers),
        ];
        for (name, argument, there) in arguments {
            let handed = giver.is_some_and(|giver| giver.takes(argument));
            if there && !handed && !body.reads_any(|role| role.argument() == argument) {
                w.line(&format!("    (void){name};"));
            }
        }
        if let Some(giver) = giver {
            let none = self.plan.model.constraints.is_empty();
            let wanted =
                |argument| giver.takes(argument) && !(none && argument == Argument::Multipliers);
            let arguments = self.argument_list(wanted);
            let mut names: Vec<&str> = arguments.iter().map(|(name, _)| *name).collect();
            names.push("given");
            w.line(&format!(
                "    {}_{}({});",
                self.prefix,
                giver.name,
                names.join(", ")
            ));
        }
        for (index, part) in parts.parts.iter().enumerate().take(parts.parts.len() - 1) {
            let arguments = self.argument_list(|argument| part.reads_of(argument));
            let mut names: Vec<&str> = arguments.iter().map(|(name, _)| *name).collect();
            names.extend(part.reads_given.then_some("given"));
            names.push("w");
            let names = names.join(", ");
            let call = format!("{}_{}_part_{}", self.prefix, function.name, index + 1);
            w.line(&format!("    {call}({names});"));
        }
        self.reading(w, straight, own);
    }

    /// Where the results of the function that another one begins with stand: an array, so
    /// that its parts name it as it does.
    fn given(&self, giver: &Function) -> String {
        match giver.fused {
            true => format!("{} given[1]", self.result_type(giver)),
            false => {
                let dimensions = dimensions(&giver.quantities[0]);
                format!("{}_real given{dimensions}", self.prefix)
            }
        }
    }

    /// The same as an argument of a part.
    fn given_argument(&self, giver: &Function) -> String {
        match giver.fused {
            true => format!("const {} *given", self.result_type(giver)),
            // An array of arrays loses nothing but its `const`, which C would not convert to.
            false => self.given(giver),
        }
    }

    /// Arguments and carried temporaries that a part reads.
    fn reading(&self, w: &mut Lines, straight: &Straight, part: &Part) {
        let prefix = &self.prefix;
        let arguments = self.symbols.read_by(&part.reads).into_iter();
        let mut read: Vec<(&str, String)> = arguments
            .filter_map(|(name, role)| Some((name, role.place("->")?)))
            .collect();
        let locals = &straight.body.locals;
        let carried = part.takes.iter();
        read.extend(carried.map(|&(local, place)| (locals[local].as_str(), format!("w[{place}]"))));
        if straight.parts.are_several() {
            return declare_side_by_side(w, prefix, &read);
        }
        for (name, place) in read {
            w.line(&format!("    const {prefix}_real {name} = {place};"));
        }
    }

    fn statements(&self, w: &mut Lines, (straight, language): (&Straight, &C<'_>), part: &Part) {
        let Straight { body, parts } = straight;
        let statements = &body.statements[part.statements.clone()];
        write_statements(
            w,
            &self.prefix,
            language,
            (body, statements, parts.are_several()),
        );
    }
}
