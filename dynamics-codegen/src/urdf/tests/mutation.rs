//! No text, however damaged, leads to a panic, and every message has its place.

use super::{INERTIAL, arm, read_text};
use crate::urdf::{Options, merge_fixed};
use proptest::prelude::*;

/// A robot that uses every element.
fn original() -> String {
    arm(
        "revolute",
        INERTIAL,
        r#"<origin xyz="1 2 3" rpy="1.57079632679 0 -0.5"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
    <dynamics damping="0.1" friction="0.2"/>"#,
    )
    .replace(
        "</robot>",
        &format!(
            r#"  <link name="größe">{INERTIAL}</link>
  <joint name="ellbow" type="prismatic">
    <parent link="arm"/><child link="größe"/>
    <axis xyz="0 1 0"/>
    <mimic joint="shoulder" multiplier="2" offset="0.5"/>
  </joint>
  <gazebo/>
</robot>"#
        ),
    )
}

/// One damage to a text.
#[derive(Debug, Clone)]
enum Damage {
    Delete(usize, usize),
    Duplicate(usize, usize),
    Move(usize, usize, usize),
    Insert(usize, &'static str),
}

const SCRAPS: [&str; 22] = [
    "\"",
    "<",
    ">",
    "/>",
    "</link>",
    "<joint",
    "&lt;",
    "&#0;",
    "${x}",
    "NaN",
    "-",
    "1e999",
    "inf",
    " 0",
    "<!--",
    "]]>",
    "<inertial>",
    "\u{feff}",
    "ß",
    "fixed",
    "xmlns=\"u\"",
    "<!DOCTYPE",
];

fn damage() -> impl Strategy<Value = Damage> {
    let at = || 0..4000_usize;
    prop_oneof![
        (at(), 1..80_usize).prop_map(|(a, n)| Damage::Delete(a, n)),
        (at(), 1..400_usize).prop_map(|(a, n)| Damage::Duplicate(a, n)),
        (at(), 1..200_usize, at()).prop_map(|(a, n, b)| Damage::Move(a, n, b)),
        (at(), proptest::sample::select(&SCRAPS[..])).prop_map(|(a, s)| Damage::Insert(a, s)),
    ]
}

/// A character boundary of `text` that depends on `at` alone.
fn boundary(text: &str, at: usize) -> usize {
    let mut at = at % (text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

fn apply(mut text: String, damage: &Damage) -> String {
    let range = |text: &str, at: usize, length: usize| {
        let start = boundary(text, at);
        let end = boundary(text, (start + length).min(text.len()));
        start..end.max(start)
    };
    match *damage {
        Damage::Delete(at, length) => {
            let range = range(&text, at, length);
            text.replace_range(range, "");
        }
        Damage::Duplicate(at, length) => {
            let range = range(&text, at, length);
            let chunk = text[range.clone()].to_string();
            text.insert_str(range.end, &chunk);
        }
        Damage::Move(at, length, to) => {
            let range = range(&text, at, length);
            let chunk = text[range.clone()].to_string();
            text.replace_range(range, "");
            let to = boundary(&text, to);
            text.insert_str(to, &chunk);
        }
        Damage::Insert(at, scrap) => {
            let at = boundary(&text, at);
            text.insert_str(at, scrap);
        }
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_text_is_read_or_refused(damages in proptest::collection::vec(damage(), 1..4)) {
        let text = damages.iter().fold(original(), apply);
        let (robot, report) = read_text(&text, Options::default());
        for diagnostic in &report.diagnostics {
            let span = diagnostic.primary.span;
            prop_assert!(span.start <= span.end && span.end <= text.len());
        }
        prop_assert_eq!(report.render().is_empty(), report.diagnostics.is_empty());
        if let Some(robot) = robot {
            let merged = merge_fixed(&robot);
            for body in merged.bodies.iter().chain(&robot.bodies) {
                let numbers = body.inertia.tensor.as_flattened();
                prop_assert!(numbers.iter().chain(&body.inertia.center).all(|x| x.is_finite()));
                prop_assert!(body.inertia.mass.is_finite() && body.inertia.mass >= 0.0);
            }
        }
    }
}

/// proptest draws its seed from the machine; this one is the same everywhere.
#[test]
fn every_single_deletion_is_read_or_refused() {
    let text = original();
    for start in (0..text.len()).filter(|&i| text.is_char_boundary(i)) {
        for length in [1, 7, 30] {
            let end = boundary(&text, (start + length).min(text.len()));
            let mut damaged = text.clone();
            damaged.replace_range(start..end.max(start), "");
            let (_, report) = read_text(&damaged, Options::default());
            let _ = report.render();
        }
    }
}

#[test]
fn the_original_is_right() {
    let (robot, report) = read_text(&original(), Options::default());
    assert!(robot.is_some(), "{report}");
}
