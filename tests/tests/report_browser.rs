//! The page of `dynamics trace` in a real browser: how it is laid out, and what a reader sees.

mod browser;
mod pages;

use browser::{Browser, Problem, Seen};
use identify::trace::{
    Dependence, Outcome, Rival, SeparatingMotion, Unnamed, UnnamedForce, Verdict,
};
use pages::{Traced, machine, page, pendulum};

/// A desk's window and a telephone's, px.
const WIDTHS: [u32; 2] = [1280, 390];
/// Smallest letters in a figure in these windows, px.
const LEGIBLE: [f64; 2] = [12.0, 9.0];

/// In every window nothing overlaps or is cut off, axes have units and the page asks for
/// nothing: what a reader then sees.
fn seen(browser: &Browser, name: &str, page: &str) -> Vec<Seen> {
    let look = |(width, legible)| {
        let (seen, picture) = browser.picture(name, page, width);
        assert_eq!(seen.problems, [], "{name}, {width} px");
        assert!(seen.resources.is_empty(), "{name}: {:?}", seen.resources);
        for figure in &seen.figures {
            assert!(figure.smallest >= legible, "{width} px: {figure:?}");
            assert!(figure.curves > 1, "{figure:?}");
        }
        // The middle of the page, with its figures, and its end are drawn.
        let rows = picture.height;
        assert!(rows >= seen.height as usize && picture.width >= width as usize);
        assert!(picture.colours(0..rows / 2) > 20 && picture.colours(rows / 2..rows) > 20);
        seen
    };
    WIDTHS.into_iter().zip(LEGIBLE).map(look).collect()
}

const SECTIONS: [&str; 10] = [
    "Before and after",
    "Findings",
    "Other explanations",
    "What remains",
    "Residual over time",
    "Predictions against the log",
    "Is the rest noise?",
    "Candidates considered",
    "Change to the model",
    "This run",
];

/// What stands on every page.
fn has_everything(seen: &Seen, outcome: &Outcome) {
    for section in SECTIONS {
        assert!(seen.headings.iter().any(|h| h == section), "{section}");
    }
    let header = ["error", "unit", "before", "after", "noise floor"];
    assert_eq!(seen.errors[0], header);
    let coordinates = outcome.before.acceleration.per_coordinate.len();
    assert_eq!(seen.errors.len(), 1 + 3 * (1 + coordinates));
    for row in &seen.errors[1..] {
        assert_eq!(row.len(), header.len());
        let numbers = row[2..].iter();
        let all = numbers.clone().all(|cell| cell.parse::<f64>().is_ok());
        assert!(all && !row[0].is_empty() && !row[1].is_empty(), "{row:?}");
    }
}

#[test]
fn a_page_with_one_finding() {
    let Some(browser) = Browser::find() else {
        return;
    };
    let page = page(
        pendulum(),
        "dynamics trace pendulum2.model log.csv --seed 1",
    );
    for seen in seen(&browser, "pendulum", &page) {
        has_everything(&seen, &pendulum().outcome);
        assert_eq!(seen.title.as_deref(), Some("The model lacks viscous (j2)."));
        assert_eq!(seen.figures.len(), 7);
        let finding = &seen.figures[0];
        let axes = ["missing force, j2 [N·m]", "velocity of j2 [rad/s]"];
        assert_eq!(finding.axes, axes);
        let [before, after] = [2, 3].map(|cell| seen.errors[1][cell].parse::<f64>().unwrap());
        assert!(after < before / 2.0, "{:?}", seen.errors[1]);
    }
}

#[test]
fn a_page_with_nothing_missing() {
    let Some(browser) = Browser::find() else {
        return;
    };
    let traced = machine("cartpole", "o06_cartpole");
    let page = page(&traced, "dynamics trace cartpole.model log.csv");
    for seen in seen(&browser, "nothing", &page) {
        has_everything(&seen, &traced.outcome);
        let title = "The log agrees with the model: nothing is missing.";
        assert_eq!(seen.title.as_deref(), Some(title));
        assert_eq!(seen.figures.len(), 7);
    }
}

/// The pendulum, as if no effect of the library described what it lacks.
fn unnamed() -> Traced {
    let mut traced = pendulum().clone();
    let variables = ["q_j1", "dq_j1", "q_j2", "dq_j2", "u_j1", "u_j2", "past_j2"];
    let force = |coordinate: &str| UnnamedForce {
        coordinate: coordinate.into(),
        size: 0.0123,
        depends_on: variables
            .map(|variable| Dependence {
                variable: variable.into(),
                length_scale: 1.0,
            })
            .into(),
        tried: Vec::new(),
        lasts: 0.2,
        explained: 0.9,
        dissipation: 0.8,
        odd_in_velocity: 0.7,
        remembers: true,
        saved: String::new(),
    };
    traced.outcome.unnamed = Some(Unnamed {
        forces: vec![force("j1"), force("j2")],
        acceleration_after: traced.outcome.after.acceleration.clone(),
        recovered: 0.9,
    });
    traced.outcome.verdict = Verdict::Unknown;
    traced.outcome.findings.clear();
    traced.outcome.patched_model.clone_from(&traced.text);
    traced
}

#[test]
fn a_page_without_a_name_for_what_is_missing() {
    let Some(browser) = Browser::find() else {
        return;
    };
    let unnamed = unnamed();
    let page = page(&unnamed, "dynamics trace pendulum2.model log.csv --seed 1");
    for seen in seen(&browser, "unknown", &page) {
        has_everything(&seen, &unnamed.outcome);
        let title = seen.title.unwrap();
        assert!(
            title.starts_with("Something is missing that no effect"),
            "{title}"
        );
        assert_eq!(seen.figures.len(), 7);
    }
}

const EVIL: &str = "</svg><script>document.body.textContent = ''</script>&";
const NAMES: [&str; 7] = [
    "shoulder_pan_joint_of_left_arm",
    "shoulder_lift_joint_of_left_arm",
    "elbow_joint_of_left_arm",
    "wrist_1_joint_of_left_arm_behind_the_force_torque_sensor_that_was_added_in_spring",
    "WWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWWW",
    EVIL,
    "x",
];
/// Sizes of what the coordinates and their forces are.
const SCALES: [f64; 7] = [1e-9, 1e6, 1.0, 3e-300, 0.02, 8e4, 0.0];

/// Something else that is about a coordinate, and how one would know.
fn rival(name: &str) -> Rival {
    Rival {
        effect: "asymmetric_coulomb".into(),
        on: vec![name.into()],
        evidence_difference: -1.5,
        separating_motion: Some(SeparatingMotion {
            motion: "twice as fast".into(),
            coordinate: name.into(),
            apart: 2.5,
            apart_in_log: 1e-9,
            unit: "rad/s²".into(),
        }),
    }
}

/// A machine with seven coordinates of long names, sizes apart, and three times as many
/// findings as it has: laid out, not true.
fn crowded() -> Traced {
    let mut crowded = pendulum().clone();
    let Traced {
        compiled, outcome, ..
    } = &mut crowded;
    let (coordinate, series) = (&compiled.model.coordinates[1], &outcome.details.series);
    let curves = &series.coordinates[1];
    let mut coordinates = Vec::new();
    let mut all_curves = Vec::new();
    for (name, scale) in NAMES.into_iter().zip(SCALES) {
        let (mut coordinate, mut curves) = (coordinate.clone(), curves.clone());
        coordinate.name = name.into();
        curves.name = name.into();
        let scaled = [
            &mut curves.force_before,
            &mut curves.force_after,
            &mut curves.velocity,
            &mut curves.prediction.measured,
            &mut curves.prediction.before,
            &mut curves.prediction.after,
        ];
        for values in scaled {
            values.iter_mut().for_each(|value| *value *= scale);
        }
        coordinates.push(coordinate);
        all_curves.push(curves);
    }
    compiled.model.coordinates = coordinates;
    outcome.details.series.coordinates = all_curves;
    // Seconds since 1970.
    let series = &mut outcome.details.series;
    for stamps in [&mut series.t, &mut series.prediction_t] {
        stamps.iter_mut().for_each(|t| *t += 1.7e9);
    }
    for score in [
        &mut outcome.before,
        &mut outcome.after,
        &mut outcome.noise_floor,
    ] {
        let rollout = &mut score.rollout.errors;
        for errors in [&mut score.acceleration, &mut score.force, rollout] {
            let error = errors.per_coordinate["j2"];
            let scaled = NAMES.into_iter().zip(SCALES);
            errors.per_coordinate = scaled.map(|(n, scale)| (n.into(), error * scale)).collect();
        }
    }
    let mut finding = outcome.findings[0].clone();
    finding.confounded_with = NAMES.map(rival).into();
    let about = |name: &str| {
        let mut finding = finding.clone();
        finding.on = vec![name.into()];
        finding
    };
    outcome.findings = NAMES.iter().map(|name| about(name)).collect();
    outcome.findings[0].on = NAMES[..3].iter().map(ToString::to_string).collect();
    for weighed in &mut outcome.details.considered {
        weighed.on = vec![NAMES[3].into(), NAMES[4].into()];
    }
    let path = format!("{}/log.csv.gz", NAMES[..5].join("/"));
    outcome.split.train_log.clone_from(&path);
    outcome.split.test_log.clone_from(&path);
    outcome.warnings.push(format!("{path}: {EVIL}"));
    outcome.patched_model.push_str(&path);
    crowded.file = path;
    crowded
}

#[test]
fn a_crowded_page() {
    if left_out::too_slow() {
        return;
    }
    let Some(browser) = Browser::find() else {
        return;
    };
    let crowded = crowded();
    let page = page(
        &crowded,
        &format!("dynamics trace {} log.csv", crowded.file),
    );
    for seen in seen(&browser, "crowded", &page) {
        has_everything(&seen, &crowded.outcome);
        assert_eq!(seen.figures.len(), 4 * NAMES.len());
        let title = seen.title.unwrap();
        assert!(NAMES.iter().all(|name| title.contains(name)), "{title}");
        let shown = |axis: &str| seen.figures.iter().any(|f| f.axes[0] == axis);
        assert!(shown("missing force, elbow_joint_of_left_arm [N·m]"));
        assert!(shown("position, x [rad]"));
        assert!(shown(
            "position, shoulder_pan_joint_of_left_arm [10⁻⁹\u{a0}rad]"
        ));
        assert!(shown(
            "position, shoulder_lift_joint_of_left_arm [10⁶\u{a0}rad]"
        ));
    }
}

/// What the page must not be, and the rule that says so.
const FAULTS: [(&str, &str); 14] = [
    ("figure text overlaps", "“first” and “second”"),
    ("figure text leaves", "“outside”"),
    ("figure text is drawn over", "“first”"),
    ("axis without unit", "second”"),
    ("empty figure", ""),
    ("axes without numbers", ""),
    ("not a number", "NaN"),
    ("page scrolls sideways", ""),
    ("block leaves the window", "<p#wide>"),
    ("text is cut off", "<div#cut>"),
    (
        "blocks overlap",
        "<div#under> “under” and <div#over> “over”",
    ),
    ("text overlaps", "“under” and “over”"),
    ("cell is squeezed", "<td>"),
    ("request", "example.invalid/picture.png"),
];
const FAULTY: &str = r#"<!DOCTYPE html><html><head><meta charset="utf-8"></head><body><h1></h1>
<svg viewBox="0 0 400 200" width="400" height="200"><rect x="10" y="150" width="90" height="40"/>
<text x="20" y="180">first</text><text x="24" y="182">second</text>
<text x="380" y="40">outside</text></svg>
<p id="wide" style="width: 3000px">wide</p>
<div id="cut" style="width: 60px; overflow: hidden; white-space: nowrap">longer than its box</div>
<div id="under">under</div><div id="over" style="margin-top: -12px">over</div>
<table style="width: 20px; overflow-wrap: anywhere"><tr><td>longer than it is wide</td></tr></table>
<p>NaN</p><img src="http://example.invalid/picture.png" alt="">
</body></html>"#;

/// The measure itself: it says of a page with faults what they are, and nothing of one
/// without; a fault put into the real page is found there too.
#[test]
fn faults_are_seen() {
    let Some(browser) = Browser::find() else {
        return;
    };
    let found = browser.look(FAULTY, 1280).problems;
    for (rule, what) in FAULTS.into_iter().chain([("heading is hidden", "<h1>")]) {
        let about = |p: &&Problem| p.rule == rule && p.what.contains(what);
        assert!(found.iter().find(about).is_some(), "{rule}: {found:#?}");
    }
    let page = page(pendulum(), "dynamics trace");
    let twice = page.replacen("</svg>", "<text x=\"20\" y=\"40\">8888</text></svg>", 1);
    let found = browser.look(&twice, 1280).problems;
    let [problem] = &found[..] else {
        panic!("{found:#?}");
    };
    assert_eq!(problem.rule, "figure text overlaps");
    assert!(problem.what.contains("“8888”"), "{problem:?}");
}
