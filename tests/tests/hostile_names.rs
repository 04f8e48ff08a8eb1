//! Nothing in a model can become code, a path, or a comment that ends early.

use dynamics_codegen::{Compiled, Library, compile, emit};
use integration_tests::compiler::{self, Precision};
use integration_tests::{emitted, models};
use proptest::prelude::*;

/// The items that any module consists of, by kind and name.
fn items(text: &str) -> Vec<String> {
    let file = emitted::check_rust(text);
    assert!(file.attrs.is_empty());
    let name = |item: &syn::Item| match item {
        syn::Item::Use(_) => "use".to_string(),
        syn::Item::Const(item) => format!("const {}", item.ident),
        syn::Item::Struct(item) => format!("struct {}", item.ident),
        syn::Item::Fn(item) => format!("fn {}", item.sig.ident),
        syn::Item::Impl(_) => "impl".to_string(),
        _ => panic!("an item that is not emitted by us:\n{text}"),
    };
    file.items.iter().map(name).collect()
}

fn plain() -> String {
    "model m; coordinate x; parameter k = 2; input u; output o = x;
     constraint c: x == 0; kinetic k*dot(x)^2; force x = u;"
        .to_string()
}

/// The model of `plain` with other names and texts, as a program that builds models
/// (from a URDF, say) could make it.
fn renamed(names: &[String; 6], doc: &str) -> Compiled {
    let mut compiled = compile("m.model", &plain(), &Library::empty()).expect("the model is fine");
    let model = &mut compiled.model;
    model.name.clone_from(&names[0]);
    model.coordinates[0].name.clone_from(&names[1]);
    model.parameters[0].name.clone_from(&names[2]);
    model.inputs[0].name.clone_from(&names[3]);
    model.outputs[0].name.clone_from(&names[4]);
    model.constraints[0].name.clone_from(&names[5]);
    for text in [
        &mut model.doc,
        &mut model.coordinates[0].doc,
        &mut model.parameters[0].doc,
        &mut model.inputs[0].doc,
        &mut model.outputs[0].doc,
        &mut model.constraints[0].doc,
    ] {
        *text = doc.to_string();
    }
    compiled
}

/// The module has the same items as that of the plain model, whatever the names.
fn check(names: &[String; 6], doc: &str, path: &str) {
    let renamed = renamed(names, doc);
    let text = emit::rust(&renamed, path);
    let expected = emit::rust(
        &compile("m", &plain(), &Library::empty()).unwrap(),
        "m.model",
    );
    let (mut found, mut expected) = (items(&text), items(&expected));
    // The type is named after the model.
    let ours = ["struct Parameters", "struct EquationOfMotion"];
    for list in [&mut found, &mut expected] {
        list.retain(|item| !item.starts_with("struct ") || ours.contains(&item.as_str()));
        // Places are called after what stands there.
        for item in list.iter_mut() {
            let places = ["const Q_", "const U_", "const LAMBDA_", "const Y_"];
            if let Some(place) = places.into_iter().find(|place| item.starts_with(place)) {
                *item = place.to_string();
            }
        }
    }
    assert_eq!(found, expected, "{text}");

    let file = emit::rust_file(&renamed, path).name;
    let stem = file.strip_suffix(".rs").expect("a Rust file");
    assert!(
        stem.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'),
        "{file}"
    );

    for file in emit::c(&renamed, path) {
        emitted::check_c(&file.text);
    }

    emitted::check_visible(&emit::review(&renamed, path));
}

const HOSTILE: [&str; 28] = [
    "NAN",
    "linux",
    "sign_of",
    "real",
    "double",
    "REAL",
    "x; unsafe { }",
    "*/",
    "/*",
    "../../etc/passwd",
    "type",
    "self",
    "Self",
    "crate",
    "T",
    "p",
    "x",
    "Parameters",
    "θ",
    "\"",
    "\\",
    "a\nb\rc",
    "\u{202e}evil",
    "\u{2028}fn f() {}",
    "",
    "_",
    "3dof",
    "#![allow(warnings)]\n```\nfn f() {}\n```",
];

#[test]
fn one_hostile_name_everywhere() {
    for text in HOSTILE {
        let names = std::array::from_fn(|_| text.to_string());
        check(&names, text, text);
        let folder = tempfile::tempdir().unwrap();
        let files = emit::c(&renamed(&names, text), text);
        for file in &files {
            std::fs::write(folder.path().join(&file.name), &file.text).unwrap();
        }
        for precision in [Precision::Single, Precision::Double] {
            compiler::check(&folder.path().join(&files[1].name), precision);
        }
    }
}

proptest! {
    #[test]
    fn any_names(
        names in prop::array::uniform6(prop_oneof![".{0,10}", "[_aA1é*/\"\n`]{0,8}"]),
        doc in "(.|\n){0,40}", path in ".{0,20}",
    ) {
        check(&names, &doc, &path);
    }
}

/// Names that differ stay different fields, whatever case or alphabet they are in.
#[test]
fn fields_do_not_meet() {
    let text = "model m; coordinate x;
        parameter a = 1; parameter A = 2; parameter θ = 3; parameter theta = 4;
        parameter fn = 5; parameter fn_ = 6; parameter fn__ = 7; parameter __3b8_ = 8;
        kinetic (a + A + θ + theta + fn + fn_ + fn__ + __3b8_)*dot(x)^2;";
    let compiled = compile("m", text, &Library::empty()).unwrap_or_else(|r| panic!("{r}"));
    let file: syn::File = syn::parse_str(&emit::rust(&compiled, "m")).unwrap();
    let fields = file.items.iter().find_map(|item| match item {
        syn::Item::Struct(item) if item.ident == "Parameters" => Some(&item.fields),
        _ => None,
    });
    let names: std::collections::BTreeSet<String> = fields
        .unwrap()
        .iter()
        .map(|f| f.ident.as_ref().unwrap().to_string())
        .collect();
    assert_eq!(names.len(), 8, "{names:?}");
}

/// Two models of one name are refused, not written over one another.
#[test]
fn models_of_one_name_are_refused() {
    let twice = [("a/m.model", "model M;"), ("b/m.model", "model m;")].map(|(path, heading)| {
        let text = plain().replace("model m;", heading);
        (
            path.to_string(),
            compile(path, &text, &Library::empty()).unwrap(),
        )
    });
    let error = emit::rust_crate(&twice).unwrap_err();
    assert_eq!(
        (error.first.as_str(), error.second.as_str()),
        ("a/m.model", "b/m.model")
    );
}

/// Same model, same text, also through a second compilation.
#[test]
fn emission_is_deterministic() {
    let (first, second) = (models::all(), models::all());
    for ((path, a), (_, b)) in first.iter().zip(&second) {
        assert_eq!(emit::rust(a, path), emit::rust(b, path));
        assert_eq!(emit::review(a, path), emit::review(b, path));
    }
}
