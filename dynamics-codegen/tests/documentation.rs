//! Every example in `docs/model-language.md`, and every model on the front page and in the guide, is what
//! it claims to be.
//!
//! A block ```` ```model ```` compiles without a word; ```` ```model,effect ```` is a template
//! that can be applied; with `,error` (or `,warning`, where it compiles), the block behind it,
//! ```` ```message ````, is what is said.

use dynamics_codegen::{Library, Report, compile};

const PAGE: &str = include_str!("../../docs/model-language.md");

/// Other pages with models, and how many there are at least.
const OTHERS: [(&str, &str, usize); 3] = [
    ("README.md", include_str!("../../README.md"), 1),
    (
        "docs/introduction.md",
        include_str!("../../docs/introduction.md"),
        1,
    ),
    ("docs/tracing.md", include_str!("../../docs/tracing.md"), 1),
];

/// A fenced block: what stands behind the fence, the text, and the line it begins in.
struct Block {
    tags: Vec<String>,
    text: String,
    line: usize,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (index, line) in page.lines().enumerate() {
        match (open.take(), line.strip_prefix("```")) {
            (Some(block), Some(_)) => blocks.push(block),
            (Some(mut block), None) => {
                block.text.push_str(line);
                block.text.push('\n');
                open = Some(block);
            }
            (None, Some(tags)) => {
                open = Some(Block {
                    tags: tags.split(',').map(str::to_string).collect(),
                    text: String::new(),
                    line: index + 1,
                });
            }
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a fence is never closed");
    blocks
}

impl Block {
    fn is(&self, tag: &str) -> bool {
        self.tags.iter().any(|found| found == tag)
    }

    /// Compiles a model, or a template applied to something it fits.
    fn compile(&self) -> Result<Report, Report> {
        let mut library = Library::builtin();
        library.look_in(concat!(env!("CARGO_MANIFEST_DIR"), "/../models"));
        if !self.is("effect") {
            return compile("example.model", &self.text, &library).map(|c| c.warnings);
        }
        let heading = self
            .text
            .lines()
            .find(|line| line.starts_with("effect "))
            .unwrap();
        let name = heading["effect ".len()..].split('(').next().unwrap();
        library.add(name, "effect.model", self.text.clone());
        let place = if [": input", ": each input", ": drive"]
            .iter()
            .any(|kind| heading.contains(kind))
        {
            "drive"
        } else if heading.contains(": body") {
            "block"
        } else {
            "x"
        };
        let model = format!(
            "model user;\ncoordinate x: m;\ninput drive: N;\nparameter m: kg = 1;\n\
             body block {{ frame: translate(x, 0, 0); mass: m; }} force x = drive;\neffect {name}({place});\n"
        );
        compile("example.model", &model, &library).map(|c| c.warnings)
    }
}

#[test]
fn every_example_is_what_it_claims_to_be() {
    let blocks = blocks(PAGE);
    let mut examples = 0;
    for (index, block) in blocks
        .iter()
        .enumerate()
        .filter(|(_, block)| block.is("model"))
    {
        examples += 1;
        let said = match (block.compile(), block.is("error")) {
            (Ok(said), false) | (Err(said), true) => said,
            (Ok(_), true) => panic!("line {}: this compiles", block.line),
            (Err(report), false) => panic!("line {}:\n{report}", block.line),
        };
        if !block.is("error") && !block.is("warning") {
            assert!(said.diagnostics.is_empty(), "line {}:\n{said}", block.line);
            continue;
        }
        let message = blocks.get(index + 1).filter(|next| next.is("message"));
        let message = message.unwrap_or_else(|| panic!("line {}: no message", block.line));
        if format!("{said}\n") != message.text {
            panic!("line {}:\n{said}", message.line);
        }
    }
    assert!(examples >= 25, "only {examples} examples were found");
}

#[test]
fn models_on_other_pages_compile() {
    for (name, page, least) in OTHERS {
        let mut examples = blocks(page);
        examples.retain(|block| block.is("model"));
        assert!(examples.len() >= least, "{name}: {} models", examples.len());
        for block in examples {
            match block.compile() {
                Ok(said) => assert!(said.diagnostics.is_empty(), "{name}:{}\n{said}", block.line),
                Err(report) => panic!("{name}:{}\n{report}", block.line),
            }
        }
    }
}

/// The statements of the compiler's own list, and the functions, are all on the page.
#[test]
fn nothing_is_left_out() {
    let say = |text: &str| compile("m", text, &Library::empty()).unwrap_err().render();
    let after = |said: &str, lead: &str| -> Vec<String> {
        let list = said.split(lead).nth(1).unwrap().lines().next().unwrap();
        list.split(", ").map(str::to_string).collect()
    };
    let statements = after(
        &say("model m;\nzzzzzzzzzz;"),
        "a statement begins with one of: ",
    );
    assert!(statements.len() >= 12);
    for word in statements {
        assert!(
            PAGE.contains(&format!("\n### {word}\n")),
            "`{word}` has no section"
        );
        assert!(
            PAGE.contains(&format!("| '{word}' ")) || word == "coordinate",
            "{word}"
        );
    }
    let functions = after(
        &say("model m;\nlet a = zzzzzzzzzz(1);"),
        "the functions are ",
    );
    assert!(functions.len() >= 21);
    for function in functions {
        let named =
            PAGE.contains(&format!("`{function}(")) || PAGE.contains(&format!("`{function}`"));
        assert!(named, "the function `{function}` is not explained");
    }
}
