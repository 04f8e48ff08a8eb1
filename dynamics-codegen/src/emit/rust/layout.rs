//! Lines of Rust, laid out as rustfmt does in its default style.
//!
//! Everything that is emitted is one of few forms, and each is either independent of
//! its width (a comment) or follows rustfmt's rule, restated here.

use super::documentation::Doc;

/// rustfmt's `max_width`.
const MAX_WIDTH: usize = 100;
/// rustfmt's `array_width`: the longest content of an array in one line.
const ARRAY_WIDTH: usize = 60;
/// rustfmt's `short_array_element_width_threshold`.
const SHORT: usize = 10;
/// rustfmt's `fn_call_width`: the longest arguments of a call in one line.
const CALL_WIDTH: usize = 60;

/// Text with an indentation.
#[derive(Debug, Default)]
pub(super) struct Writer {
    out: String,
    depth: usize,
}

impl Writer {
    pub fn into_text(self) -> String {
        self.out
    }

    pub fn line(&mut self, line: impl AsRef<str>) {
        let line = line.as_ref();
        if !line.is_empty() {
            self.out.push_str(&" ".repeat(4 * self.depth));
            self.out.push_str(line);
        }
        self.out.push('\n');
    }

    pub fn blank(&mut self) {
        self.out.push('\n');
    }

    /// A doc comment.
    pub fn doc(&mut self, doc: &Doc) {
        for line in doc.lines() {
            self.line(format!("/// {line}").trim_end());
        }
    }

    /// A line that ends in an opening bracket, the inside, the closing bracket.
    pub fn block(&mut self, opening: &str, closing: &str, inside: impl FnOnce(&mut Self)) {
        self.line(opening);
        self.depth += 1;
        inside(self);
        self.depth -= 1;
        self.line(closing);
    }

    /// `impl<T: Scalar> of for name { … }`
    pub fn implementation(&mut self, of: &str, name: &str, inside: impl FnOnce(&mut Self)) {
        let one = format!("impl<T: Scalar> {of} for {name} {{");
        if one.len() <= MAX_WIDTH {
            return self.block(&one, "}", inside);
        }
        self.line(format!("impl<T: Scalar> {of}"));
        self.line(format!("    for {name}"));
        self.block("{", "}", inside);
    }

    /// A function with its body.
    pub fn function(
        &mut self,
        name: &str,
        arguments: &[String],
        result: &str,
        body: impl FnOnce(&mut Self),
    ) {
        self.signature(name, arguments, &format!(" -> {result} {{"), body);
    }

    /// A function without a result.
    pub fn procedure(&mut self, name: &str, arguments: &[String], body: impl FnOnce(&mut Self)) {
        self.signature(name, arguments, " {", body);
    }

    fn signature(
        &mut self,
        name: &str,
        arguments: &[String],
        end: &str,
        body: impl FnOnce(&mut Self),
    ) {
        let one = format!("{name}({}){end}", arguments.join(", "));
        if 4 * self.depth + one.len() <= MAX_WIDTH {
            return self.block(&one, "}", body);
        }
        self.block(&format!("{name}("), &format!("){end}"), |w| {
            for argument in arguments {
                w.line(format!("{argument},"));
            }
        });
        self.depth += 1;
        body(self);
        self.depth -= 1;
        self.line("}");
    }

    /// `opening value closing`, as `mass_matrix: […],` or `[…]`.
    pub fn array(&mut self, opening: &str, value: &Array, closing: &str) {
        let used = 4 * self.depth + opening.len() + closing.len();
        let text = value.layout(self.depth, MAX_WIDTH.saturating_sub(used));
        self.line(format!("{opening}{text}{closing}"));
    }

    /// `let name = value;`
    pub fn binding(&mut self, name: &str, value: &str) {
        let one = format!("let {name} = {value};");
        if 4 * self.depth + one.chars().count() <= MAX_WIDTH {
            return self.line(one);
        }
        self.line(format!("let {name} ="));
        self.line(format!("    {value};"));
    }

    /// `opening function(arguments) closing`.
    pub fn call(&mut self, opening: &str, function: &str, arguments: &[String], closing: &str) {
        let inside = arguments.join(", ");
        let whole = format!("{opening}{function}({inside}){closing}");
        let fits = 4 * self.depth + whole.chars().count() <= MAX_WIDTH;
        if fits && inside.chars().count() <= CALL_WIDTH {
            return self.line(whole);
        }
        self.block(
            &format!("{opening}{function}("),
            &format!("){closing}"),
            |w| {
                for argument in arguments {
                    w.line(format!("{argument},"));
                }
            },
        );
    }

    /// `pub const NAME: TYPE = […];`
    pub fn constant(&mut self, opening: &str, value: &Array) {
        let one_line = value.one_line();
        let fits = |used: usize| {
            one_line
                .as_ref()
                .filter(|text| used + text.len() < MAX_WIDTH)
        };
        if fits(opening.len() + 1).is_none()
            && let Some(text) = fits(4)
        {
            self.line(opening);
            return self.line(format!("    {text};"));
        }
        self.array(&format!("{opening} "), value, ";");
    }
}

/// An array expression.
#[derive(Debug, Clone)]
pub(super) enum Array {
    /// A name, a number, a string: what rustfmt calls simple.
    Simple(String),
    /// Any other expression of one line.
    Other(String),
    Row(Vec<Array>),
}

impl Array {
    /// A term in one line.
    pub fn of(text: String) -> Self {
        if text.ends_with(')') {
            Self::Other(text)
        } else {
            Self::Simple(text)
        }
    }

    /// In one line, if rustfmt would leave it there given the room.
    fn one_line(&self) -> Option<String> {
        match self {
            Self::Simple(text) | Self::Other(text) => Some(text.clone()),
            Self::Row(items) => {
                let items: Option<Vec<String>> = items.iter().map(Self::one_line).collect();
                let content = items?.join(", ");
                (content.chars().count() <= ARRAY_WIDTH).then(|| format!("[{content}]"))
            }
        }
    }

    /// Behind text at `depth`, with `room` columns left on the line.
    fn layout(&self, depth: usize, room: usize) -> String {
        let Self::Row(items) = self else {
            return self.one_line().unwrap_or_default();
        };
        if let Some(text) = self.one_line().filter(|text| text.chars().count() <= room) {
            return text;
        }
        // A single row shares its brackets' lines.
        if let [row @ Self::Row(_)] = items.as_slice() {
            return format!("[{}]", row.layout(depth, 0));
        }
        let indent = " ".repeat(4 * depth + 4);
        let inner = MAX_WIDTH - indent.len();
        let lines = if items.iter().all(Self::is_short) {
            fill(items, inner)
        } else {
            let laid_out = items.iter().map(|item| item.layout(depth + 1, inner - 1));
            laid_out.map(|text| text + ",").collect()
        };
        let lines = lines.iter().map(|line| format!("{indent}{line}\n"));
        format!("[\n{}{}]", lines.collect::<String>(), &indent[4..])
    }

    fn is_short(&self) -> bool {
        matches!(self, Self::Simple(text) if text.chars().count() <= SHORT)
    }
}

/// As many short items in a line as fit.
fn fill(items: &[Array], width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for item in items {
        let text = item.one_line().unwrap_or_default() + ",";
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + text.chars().count() <= width => {
                line.push(' ');
                line.push_str(&text);
            }
            _ => lines.push(text),
        }
    }
    lines
}
