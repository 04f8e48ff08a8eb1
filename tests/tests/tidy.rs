//! Rules about the repository itself that are cheap to check.

mod markdown;

use integration_tests::files::root;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Lines of a source file above which it holds more than one idea.
const LONGEST: usize = 600;
/// Lines of the front page: two minutes. What is more belongs into `docs/`.
const FRONT_PAGE: usize = 150;

/// Every file below a folder, in order, without what is hidden or built.
fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let skipped = name.starts_with('.') && name != ".ci";
        if skipped || name == "target" || name == "__pycache__" || path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            walk(&path, found);
        } else {
            found.push(path);
        }
    }
}

/// Every text file, by its path from the workspace's folder.
fn texts() -> Vec<(String, String)> {
    let mut paths = Vec::new();
    walk(&root(), &mut paths);
    let texts = paths.iter().filter_map(|path| {
        let name = path.strip_prefix(root()).unwrap().to_str().unwrap();
        let text = String::from_utf8(std::fs::read(path).unwrap()).ok()?;
        Some((name.to_owned(), text))
    });
    texts.collect()
}

/// Our own source files: under `src`, not generated.
fn sources() -> Vec<(String, String)> {
    let mut texts = texts();
    texts.retain(|(name, _)| {
        name.ends_with(".rs") && name.contains("/src/") && !name.starts_with("generated/")
    });
    assert!(texts.len() > 100, "only {} source files seen", texts.len());
    texts
}

/// Whether a source file holds nothing but tests.
fn is_test(name: &str) -> bool {
    name.ends_with("/tests.rs") || name.contains("/tests/") || name.starts_with("tests/")
}

/// Names without ending of the files in a folder that have this ending.
fn stems(folder: &str, ending: &str) -> BTreeSet<String> {
    let entries =
        std::fs::read_dir(root().join(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names
        .filter_map(|name| Some(name.strip_suffix(ending)?.to_owned()))
        .collect()
}

fn none(wrong: &[String], rule: &str) {
    assert!(wrong.is_empty(), "{rule}:\n  {}", wrong.join("\n  "));
}

#[test]
fn no_path_of_a_machine() {
    // In two pieces, so that this file keeps its own rule.
    let places = ["work", "tmp", "home", "root", "Users"].map(|place| format!("/{place}/"));
    let mut wrong = Vec::new();
    for (name, text) in texts() {
        for (number, line) in text.lines().enumerate() {
            let path = places.iter().any(|place| {
                line.match_indices(place.as_str()).any(|(at, _)| {
                    // The middle of a longer path or of an address is none.
                    !line[..at].ends_with(|c: char| c.is_alphanumeric() || "._-/".contains(c))
                })
            });
            if path {
                wrong.push(format!("{name}:{}: {line}", number + 1));
            }
        }
    }
    none(&wrong, "paths that exist on one machine only");
}

#[test]
fn files_are_short() {
    let sources = sources();
    let lengths = sources
        .iter()
        .map(|(name, text)| (name, text.lines().count()));
    let wrong: Vec<String> = lengths
        .filter(|(_, lines)| *lines > LONGEST)
        .map(|(name, lines)| format!("{name}: {lines}"))
        .collect();
    none(&wrong, &format!("longer than {LONGEST} lines"));
}

#[test]
fn files_say_what_they_are() {
    let wrong: Vec<String> = sources()
        .into_iter()
        .filter(|(name, text)| !name.ends_with("/tests.rs") && !text.starts_with("//! "))
        .map(|(name, _)| name)
        .collect();
    none(&wrong, "source files that do not begin with `//! `");
}

/// What an effect is stands in its template, so that a user's own takes part in everything: the code
/// that tries effects knows none by name.
#[test]
fn no_code_names_an_effect() {
    let effects = stems("models/effects", ".model");
    assert!(effects.len() > 20, "{effects:?}");
    let names_one = |literal: &str| {
        let (name, rest) = match literal.find(|c: char| !c.is_alphanumeric() && c != '_') {
            Some(end) => literal.split_at(end),
            None => (literal, ""),
        };
        let is_applied = rest.is_empty() || rest.starts_with('(');
        is_applied && effects.contains(name) || effects.iter().any(|e| name == format!("{e}_"))
    };
    assert!(names_one("coulomb") && names_one("coulomb(x)") && !names_one("coulomb friction"));
    let mut wrong = Vec::new();
    let mut own = sources();
    own.retain(|(name, _)| name.starts_with("identify/src/"));
    for (name, text) in own.iter().filter(|(name, _)| !is_test(name)) {
        // Tests stand at the end of a file.
        let code = text.split("\n#[cfg(test)]\nmod tests").next().unwrap();
        for (number, line) in code.lines().enumerate() {
            let is_comment = line.trim_start().starts_with("//");
            let mut literals = line.split('"').skip(1).step_by(2);
            if !is_comment && literals.any(names_one) {
                wrong.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    none(&wrong, "effects named in code");
}

#[test]
fn nothing_is_unfinished() {
    let marks = ["todo", "unimplemented", "dbg"].map(|mark| format!("{mark}!("));
    let wrong: Vec<String> = texts()
        .into_iter()
        .filter(|(name, text)| {
            name.ends_with(".rs") && marks.iter().any(|mark| text.contains(mark.as_str()))
        })
        .map(|(name, _)| name)
        .collect();
    none(&wrong, "unfinished, or left over from looking for a fault");
}

/// The command line is the only crate that prints, and one of the two doors (the other is the Python
/// package) that read a clock. (What a build script does is to print:
/// `dynamics-codegen/src/build.rs` hands cargo its lines.)
#[test]
fn libraries_are_quiet_and_timeless() {
    let marks = ["println!(", "print!(", "Instant::now", "SystemTime::now"];
    let mut wrong = Vec::new();
    for (name, text) in sources() {
        if is_test(&name) || ["cli/", "examples/"].iter().any(|f| name.starts_with(f)) {
            continue;
        }
        let marks = match name.starts_with("python/") {
            true => &marks[..2],
            false => &marks[..],
        };
        for (number, line) in text.lines().enumerate() {
            let comment = line.trim_start().starts_with("//");
            if !comment && marks.iter().any(|mark| line.contains(mark)) {
                wrong.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    none(&wrong, "a library that prints or reads a clock");
}

#[test]
fn every_model_has_its_files() {
    let mut models = stems("models", ".model");
    models.extend(stems("models", ".urdf"));
    assert!(models.len() >= 14);
    let places = [
        ("generated/src", ".rs"),
        ("generated/c", ".c"),
        ("generated/c", ".h"),
        ("generated/review", ".snap"),
    ];
    for (folder, ending) in places {
        let mut there = stems(folder, ending);
        there.remove("lib");
        assert_eq!(models, there, "models against {folder}/*{ending}");
    }
}

#[test]
fn models_and_effects_say_what_they_are() {
    let wrong: Vec<String> = texts()
        .into_iter()
        .filter(|(name, text)| {
            name.starts_with("models/") && name.ends_with(".model") && !text.starts_with("/// ")
        })
        .map(|(name, _)| name)
        .collect();
    none(&wrong, "models that do not begin with `/// `");
}

/// Names of the dependencies that a manifest states for use outside tests.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let mut inside = false;
    let mut names = BTreeSet::new();
    for line in manifest.lines() {
        if let Some(section) = line.strip_prefix('[') {
            inside = matches!(section, "dependencies]" | "build-dependencies]");
        } else if inside && !line.starts_with('#') {
            let end = line.find(['.', ' ', '=']).unwrap_or(line.len());
            names.insert(line[..end].to_owned());
        }
    }
    names
}

/// The arrows of ARCHITECTURE.md: a crate's folder, and the crates of ours that it depends on.
fn arrows() -> BTreeMap<String, BTreeSet<String>> {
    let map = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let (_, block) = map.split_once("## Arrows").unwrap();
    let block = block.split("```").nth(1).unwrap();
    let arrows = block.lines().filter_map(|line| {
        let (from, to) = line.split_once(" ──▶ ")?;
        let to = to.split_once('(').map_or(to, |(names, _)| names).trim();
        let names = to.split(", ").filter(|_| to != "nothing of ours");
        Some((from.to_owned(), names.map(str::to_owned).collect()))
    });
    arrows.collect()
}

#[test]
fn arrows_are_those_of_the_manifests() {
    let arrows = arrows();
    assert!(arrows.len() >= 10, "{arrows:?}");
    for (name, stated) in &arrows {
        if name == "tests" {
            continue;
        }
        let path = root().join(name).join("Cargo.toml");
        let mut found = dependencies(&std::fs::read_to_string(&path).unwrap());
        found.retain(|dependency| arrows.contains_key(dependency));
        assert_eq!(&found, stated, "what {name} depends on");
    }
}

#[test]
fn every_crate_is_on_the_map_and_under_the_lints() {
    let map = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let workspace = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let (_, members) = workspace.split_once("members = [").unwrap();
    let (members, _) = members.split_once(']').unwrap();
    let members: Vec<&str> = members.split('"').skip(1).step_by(2).collect();
    assert!(members.len() >= 7);
    for member in members {
        assert!(
            map.contains(&format!("`{member}/`")),
            "ARCHITECTURE.md lacks {member}"
        );
        assert!(
            arrows().contains_key(member),
            "ARCHITECTURE.md lacks the arrows of {member}"
        );
        let manifest = std::fs::read_to_string(root().join(member).join("Cargo.toml")).unwrap();
        // `dynamics` states its own: one of its tests implements an unsafe trait.
        let lints = manifest.contains("[lints]\nworkspace = true")
            || manifest.contains("[lints.rust]\nunsafe_code = \"deny\"");
        assert!(lints, "{member} has no lints");
    }
}

/// The parts of `identify`, each of which uses those before it alone.
const PARTS_OF_IDENTIFY: [&str; 10] = [
    "number",
    "robot_options",
    "log",
    "floating",
    "smooth",
    "machine",
    "regression",
    "trace",
    "fit",
    "report",
];

/// Whether a text names a module of its own crate.
fn uses(text: &str, module: &str) -> bool {
    let name = format!("crate::{module}");
    let mut ends = text.split(&name).skip(1).map(|rest| rest.chars().next());
    ends.any(|next| next.is_none_or(|c| !c.is_alphanumeric() && c != '_'))
}

#[test]
fn parts_of_identify_form_no_circle() {
    let front = std::fs::read_to_string(root().join("identify/src/lib.rs")).unwrap();
    let is_part = |line: &&str| line.trim_start_matches("pub ").starts_with("mod ");
    let parts = front.lines().filter(is_part).count();
    assert_eq!(parts, PARTS_OF_IDENTIFY.len());
    let texts = texts();
    for (place, part) in PARTS_OF_IDENTIFY.iter().enumerate() {
        let folder = format!("identify/src/{part}");
        let own = texts.iter().filter(|(name, _)| {
            let rest = name.strip_prefix(&folder);
            rest.is_some_and(|rest| rest.starts_with('/') || rest == ".rs")
        });
        let own: Vec<_> = own.collect();
        assert!(!own.is_empty(), "{folder}");
        for (name, text) in own {
            for later in &PARTS_OF_IDENTIFY[place + 1..] {
                assert!(
                    !uses(text, later),
                    "{name} uses `{later}`, which stands on `{part}`"
                );
            }
        }
    }
}

/// Test functions that the errata lean on exist.
#[test]
fn errata_name_tests_that_exist() {
    let errata = std::fs::read_to_string(root().join("docs/errata.md")).unwrap();
    let tests: String = texts()
        .into_iter()
        .filter(|(name, _)| name.ends_with(".rs"))
        .map(|(_, text)| text)
        .collect();
    let named: BTreeSet<&str> = errata
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|code| code.matches('_').count() >= 2 && !code.contains(['/', ' ']))
        .collect();
    assert!(named.len() >= 7, "{named:?}");
    for name in named {
        assert!(tests.contains(&format!("fn {name}(")), "no test `{name}`");
    }
}

#[test]
fn the_front_page_is_short() {
    let page = std::fs::read_to_string(root().join("README.md")).unwrap();
    let lines = page.lines().count();
    assert!(lines <= FRONT_PAGE, "README.md: {lines} lines");
}

/// Every Markdown page, by its path.
fn pages() -> BTreeMap<String, String> {
    let mut pages: BTreeMap<_, _> = texts().into_iter().collect();
    pages.retain(|name, _| name.ends_with(".md"));
    pages
}

#[test]
fn every_page_is_in_the_book() {
    let mut pages = pages();
    pages.retain(|name, _| name.starts_with("docs/"));
    let summary = pages.remove("docs/SUMMARY.md").unwrap();
    let listed = markdown::links(&summary).into_iter();
    let listed: Vec<String> = listed.map(|(_, page)| format!("docs/{page}")).collect();
    let mut wrong = Vec::new();
    for (k, page) in listed.iter().enumerate() {
        if listed[..k].contains(page) {
            wrong.push(format!("{page}: listed twice"));
        } else if pages.remove(page).is_none() {
            wrong.push(format!("{page}: listed, and not there"));
        }
    }
    wrong.extend(pages.keys().map(|page| format!("{page}: not listed")));
    none(&wrong, "docs/SUMMARY.md against the pages of docs/");
}

/// The path from the workspace's folder of what a page links to; nothing if that lies outside.
fn target(page: &str, link: &str) -> Option<String> {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in link.split('/') {
        match part {
            "." => {}
            ".." => drop(parts.pop()?),
            name => parts.push(name),
        }
    }
    Some(parts.join("/"))
}

/// What is wrong with a link of a page, if anything is. Pages of the book link to one another only: it is
/// read without the rest of the repository.
fn fault(pages: &BTreeMap<String, String>, page: &str, link: &str) -> Option<String> {
    let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
    let there = match file {
        "" => page.to_owned(),
        file => match target(page, file) {
            Some(there) if root().join(&there).exists() => there,
            _ => return Some("leads nowhere".to_owned()),
        },
    };
    if page.starts_with("docs/") && !there.starts_with("docs/") {
        return Some("leads out of the book; name the file by its path".to_owned());
    }
    if anchor.is_empty() {
        return None;
    }
    let anchors = markdown::anchors(pages.get(&there)?);
    (!anchors.contains(anchor)).then(|| format!("{there} has no heading `#{anchor}`"))
}

#[test]
fn links_lead_somewhere() {
    let pages = pages();
    let (mut seen, mut wrong) = (0, Vec::new());
    for (page, text) in &pages {
        for (line, link) in markdown::links(text) {
            if link.contains("://") {
                continue;
            }
            seen += 1;
            if let Some(fault) = fault(&pages, page, &link) {
                wrong.push(format!("{page}:{line}: `{link}` {fault}"));
            }
        }
    }
    assert!(seen > 50, "only {seen} links seen");
    none(&wrong, "links of Markdown pages");
}
