//! The page of `dynamics trace`: complete, the same every time, and safe from names.

mod pages;

use identify::report::summary;
use identify::trace::{Nearest, Verdict};
use pages::{Traced, page, pendulum};

#[test]
fn the_page_says_everything_and_needs_nothing() {
    let traced = pendulum();
    let page = page(traced, "dynamics trace pendulum2.model log.csv --seed 1");
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
    let summary = summary(&traced.outcome, &traced.compiled.model);
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
    let series = &pendulum().outcome.details.series;
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
    let once = page(pendulum(), "dynamics trace");
    assert_eq!(once, page(pendulum(), "dynamics trace"));
}

/// A robot description may call a joint anything.
#[test]
fn names_stay_text() {
    const EVIL: &str = "</svg><script>alert('1')</script>&";
    let mut evil = pendulum().clone();
    let Traced {
        compiled, outcome, ..
    } = &mut evil;
    compiled.model.coordinates[1].name = EVIL.into();
    outcome.details.series.coordinates[1].name = EVIL.into();
    outcome.findings[0].on = vec![EVIL.into()];
    outcome.findings[0].effect = EVIL.into();
    outcome.details.considered[0].effect = EVIL.into();
    outcome.split.train_log = EVIL.into();
    outcome.warnings.push(EVIL.into());
    outcome.patched_model.push_str(EVIL);
    let page = page(&evil, EVIL);
    assert!(!page.contains("<script") && !page.contains("alert('1')"));
    assert_eq!(
        page.matches("</svg>").count(),
        page.matches("<svg ").count()
    );
    assert!(page.matches("&lt;script&gt;").count() > 10);
}

/// What explains nothing is no finding: it stands under a name of its own, in the text and on the
/// page, and "after" is nowhere, as nothing was written.
#[test]
fn what_explains_nothing_is_nearest() {
    let mut unknown = pendulum().clone();
    let outcome = &mut unknown.outcome;
    outcome.verdict = Verdict::Unknown;
    let after = std::mem::replace(&mut outcome.after, outcome.before.clone());
    outcome.nearest = Some(Nearest {
        findings: std::mem::take(&mut outcome.findings),
        errors: after.clone(),
        misfit: std::mem::replace(&mut outcome.misfit_after, outcome.misfit_before),
        share: std::mem::replace(
            &mut outcome.remaining.share_after,
            outcome.remaining.share_before,
        ),
    });
    let summary = summary(outcome, &unknown.compiled.model);
    let mut lines = summary.lines();
    assert_eq!(
        lines.next(),
        Some(
            "Something is missing that no effect of the library explains; nearest, but not near: \
             viscous (j2)."
        )
    );
    let header = ["before", "nearest", "noise", "floor"];
    assert!(
        lines.any(|line| line.split_whitespace().eq(header)),
        "{summary}"
    );
    assert!(
        !summary.contains(" after") && !summary.contains("->"),
        "{summary}"
    );
    assert!(
        summary.contains("none of it is written into the model"),
        "{summary}"
    );
    let page = page(&unknown, "dynamics trace");
    assert!(page.contains("<h2>Findings</h2>\n<p>None.</p>"), "{page}");
    assert!(page.contains("<section id=\"nearest\">"));
    assert!(page.contains(">nearest</th>") && !page.contains(">after<"));
    assert!(!page.contains("Nothing else explains"));
    let json = serde_json::to_value(&unknown.outcome).unwrap();
    assert_eq!(json["findings"], serde_json::json!([]));
    assert_eq!(json["after"], json["before"]);
    assert_eq!(json["nearest"]["findings"][0]["effect"], "viscous");
    assert_eq!(
        json["nearest"]["errors"]["acceleration"]["total"],
        after.acceleration.total
    );
}
