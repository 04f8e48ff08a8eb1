//! The page of `dynamics trace`: complete, the same every time, and safe from names.

use dynamics_codegen::{Compiled, Library, compile};
use identify::log::Log;
use identify::report::{Page, diff, html, summary};
use identify::trace::{Outcome, Request, trace};
use std::collections::BTreeMap;
use std::sync::OnceLock;

const MODEL: &str = include_str!("../../models/pendulum2.model");

/// A pendulum with friction in its second joint, traced once for all tests.
fn traced() -> &'static (Compiled, Outcome) {
    static TRACED: OnceLock<(Compiled, Outcome)> = OnceLock::new();
    TRACED.get_or_init(|| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/data/scenarios/o01_pendulum2");
        let text = std::fs::read_to_string(format!("{folder}/parameters.json")).unwrap();
        let parameters: BTreeMap<String, f64> = serde_json::from_str(&text).unwrap();
        let read = |name: &str| Log::read(format!("{folder}/{name}")).unwrap();
        let (train, test) = (read("train.csv.gz"), read("test.csv.gz"));
        let library = Library::builtin();
        let outcome = trace(&Request {
            model_name: "pendulum2",
            model_text: MODEL,
            library: &library,
            parameters,
            train: &train,
            test: Some(&test),
            hold: None,
            horizon: 0.5,
            seed: 1,
            progress: &identify::trace::Silent,
        });
        (
            compile("pendulum2", MODEL, &library).unwrap(),
            outcome.unwrap(),
        )
    })
}

fn page(compiled: &Compiled, outcome: &Outcome, command: &str) -> String {
    let file = "pendulum2.model";
    let page = Page {
        outcome,
        model: &compiled.model,
        file,
        diff: &diff(file, MODEL, &outcome.patched_model),
        command,
    };
    html(&page).unwrap()
}

#[test]
fn the_page_says_everything_and_needs_nothing() {
    let (compiled, outcome) = traced();
    let page = page(
        compiled,
        outcome,
        "dynamics trace pendulum2.model log.csv --seed 1",
    );
    let sections = [
        "errors",
        "findings",
        "rivals",
        "remains",
        "residual",
        "predictions",
        "whiteness",
        "candidates",
        "change",
        "run",
    ];
    for section in sections {
        assert!(
            page.contains(&format!("<section id=\"{section}\">")),
            "{section}"
        );
    }
    // Every number of the summary is on the page.
    let summary = summary(outcome, &compiled.model);
    let words = summary.split_whitespace();
    let numbers: Vec<&str> = words
        .map(|word| word.trim_end_matches([',', ';', '.', ':']))
        .filter(|word| word.parse::<f64>().is_ok())
        .collect();
    assert!(numbers.len() > 15, "{summary}");
    for number in numbers {
        assert!(page.contains(number), "{number}");
    }
    assert!(page.contains("<h1>The model lacks viscous (j2).</h1>"));
    assert!(page.contains("<span class=\"plus\">+effect viscous(j2)"));
    assert!(page.contains("dynamics trace pendulum2.model log.csv --seed 1"));
    // One figure for the finding, three per coordinate; every axis has a unit.
    assert_eq!(page.matches("<svg ").count(), 7);
    let axes = [
        ("velocity of j2 [rad/s]", 1),
        ("missing force, j2 [N·m]", 2),
        ("position, j1 [rad]", 1),
        ("autocorrelation, j1 [1]", 1),
        ("time [s]", 4),
        ("lag [s]", 2),
    ];
    for (axis, count) in axes {
        assert_eq!(page.matches(axis).count(), count, "{axis}");
    }
    for outside in [
        "src=", "href=", "<script", "<link", "@import", "url(", "NaN",
    ] {
        let found = page
            .find(outside)
            .map(|at| &page[at..page.len().min(at + 40)]);
        assert!(found.is_none(), "{found:?}");
    }
}

#[test]
fn residuals_are_white_after_and_not_before() {
    let series = &traced().1.details.series;
    for coordinate in &series.coordinates {
        let outside = |values: &[f64]| {
            let count = values
                .iter()
                .filter(|r| r.abs() > series.white_band)
                .count();
            count as f64 / values.len() as f64
        };
        assert!(outside(&coordinate.autocorrelation_before) > 0.9);
        assert!(outside(&coordinate.autocorrelation_after) < 0.25);
        assert!(series.t.len() <= 600 && coordinate.force_before.len() == series.t.len());
    }
}

#[test]
fn the_page_is_the_same_every_time() {
    let (compiled, outcome) = traced();
    let once = page(compiled, outcome, "dynamics trace");
    assert_eq!(once, page(compiled, outcome, "dynamics trace"));
}

/// A robot description may call a joint anything.
#[test]
fn names_stay_text() {
    const EVIL: &str = "</svg><script>alert('1')</script>&";
    let (compiled, outcome) = traced();
    let (mut compiled, mut outcome) = (compiled.clone(), outcome.clone());
    compiled.model.coordinates[1].name = EVIL.into();
    outcome.details.series.coordinates[1].name = EVIL.into();
    outcome.findings[0].on = vec![EVIL.into()];
    outcome.findings[0].effect = EVIL.into();
    outcome.details.considered[0].effect = EVIL.into();
    outcome.split.train_log = EVIL.into();
    outcome.warnings.push(EVIL.into());
    outcome.patched_model.push_str(EVIL);
    let page = page(&compiled, &outcome, EVIL);
    assert!(!page.contains("<script") && !page.contains("alert('1')"));
    assert_eq!(
        page.matches("</svg>").count(),
        page.matches("<svg ").count()
    );
    assert!(page.matches("&lt;script&gt;").count() > 10);
}
