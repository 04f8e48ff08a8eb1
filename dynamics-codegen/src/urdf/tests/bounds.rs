//! Files that are large, deep, or built to hurt.

use super::{INERTIAL, headlines, robot};
use crate::robot::{JointKind, merge_fixed};
use std::fmt::Write;

const Z: &str = r#"<axis xyz="0 0 1"/>"#;

/// A chain of links in the order from tip to base, the worst for recursion.
fn chain(count: usize, kind: &str) -> String {
    let mut text = String::from("<robot name=\"chain\">\n");
    for i in (0..count).rev() {
        let _ = writeln!(text, "<link name=\"l{i}\">{INERTIAL}</link>");
    }
    for i in (1..count).rev() {
        let _ = writeln!(
            text,
            "<joint name=\"j{i}\" type=\"{kind}\"><parent link=\"l{}\"/><child link=\"l{i}\"/>{Z}</joint>",
            i - 1
        );
    }
    text + "</robot>\n"
}

#[test]
fn a_chain_of_ten_thousand_links_is_read_and_welded() {
    let count = 10_000;
    let moving = robot(&chain(count, "continuous"));
    assert_eq!(moving.bodies.len(), count);
    assert_eq!(moving.degrees_of_freedom(), count - 1);
    assert_eq!(moving.bodies[count - 1].link, format!("l{}", count - 1));
    assert_eq!(merge_fixed(&moving).bodies.len(), count);
    let rigid = merge_fixed(&robot(&chain(count, "fixed")));
    assert_eq!(rigid.bodies.len(), 1);
    assert_eq!(rigid.bodies[0].inertia.mass, count as f64);
    assert_eq!(rigid.frames.len(), count);
}

#[test]
fn a_ring_of_ten_thousand_joints_is_one_error() {
    let ring = chain(10_000, "continuous").replace(
        "</robot>",
        "<joint name=\"j0\" type=\"fixed\"><parent link=\"l9999\"/><child link=\"l0\"/></joint></robot>",
    );
    let found = headlines(&ring);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("form a ring"), "{found:?}");
}

#[test]
fn a_chain_of_ten_thousand_mimics_is_followed() {
    let mut text = String::from("<robot name=\"r\"><link name=\"base\"/>");
    for i in 0..10_000 {
        let mimic = match i {
            0 => String::new(),
            _ => format!("<mimic joint=\"j{}\" multiplier=\"-1\"/>", i - 1),
        };
        let _ = writeln!(
            text,
            "<link name=\"l{i}\">{INERTIAL}</link><joint name=\"j{i}\" type=\"continuous\"><parent link=\"base\"/><child link=\"l{i}\"/>{Z}{mimic}</joint>"
        );
    }
    let robot = robot(&(text + "</robot>"));
    let last = robot.bodies[10_000].joint.as_ref().unwrap();
    assert_eq!(last.mimic.unwrap().multiplier, -1.0);
    assert!(matches!(last.kind, JointKind::Revolute { .. }));
}

#[test]
fn a_chain_of_mimics_that_multiplies_beyond_all_numbers_is_refused() {
    let mut text = String::from("<robot name=\"r\"><link name=\"base\"/>");
    for i in 0..20 {
        let mimic = match i {
            0 => String::new(),
            _ => format!("<mimic joint=\"j{}\" multiplier=\"1e30\"/>", i - 1),
        };
        let _ = writeln!(
            text,
            "<link name=\"l{i}\">{INERTIAL}</link><joint name=\"j{i}\" type=\"continuous\"><parent link=\"base\"/><child link=\"l{i}\"/>{Z}{mimic}</joint>"
        );
    }
    let found = headlines(&(text + "</robot>"));
    let error = "error: joint `j11`: the multipliers of the chain of mimics overflow";
    assert!(found.iter().any(|line| line == error), "{found:?}");
}

#[test]
fn deep_nesting_is_refused() {
    for depth in [70, 100_000] {
        let text = format!(
            "<robot name=\"r\">{}{}</robot>",
            "<link name=\"a\">".repeat(depth),
            "</link>".repeat(depth)
        );
        assert_eq!(
            headlines(&text),
            ["error: elements are nested more than 64 deep"]
        );
    }
}

#[test]
fn a_file_of_seventeen_mebibytes_is_refused() {
    let text = format!("<robot name=\"r\"><!--{}--></robot>", " ".repeat(17 << 20));
    assert_eq!(
        headlines(&text),
        ["error: the file is too large: 17 MiB, at most 16 MiB are read"]
    );
}

#[test]
fn too_many_nodes_are_refused() {
    let text = format!("<robot name=\"r\">{}</robot>", "<a/>".repeat(1_000_001));
    assert_eq!(
        headlines(&text),
        ["error: the file has more than 1000000 XML nodes"]
    );
}

#[test]
fn a_flood_of_attributes_is_refused() {
    let mut text = String::from("<robot ");
    for i in 0..200_000 {
        let _ = write!(text, "a{i}=\"\" ");
    }
    assert_eq!(
        headlines(&(text + "/>")),
        ["error: more than 1000 attributes in one element"]
    );
}

#[test]
fn an_entity_bomb_is_refused() {
    let mut text = String::from("<!DOCTYPE r [<!ENTITY e0 \"x\">\n");
    for i in 1..30 {
        let _ = writeln!(
            text,
            "<!ENTITY e{i} \"{}\">",
            format!("&e{};", i - 1).repeat(10)
        );
    }
    text += "]><robot name=\"&e29;\"/>";
    assert_eq!(
        headlines(&text),
        ["error: a document type declaration is refused"]
    );
}

#[test]
fn ten_thousand_mistakes_are_cut_short() {
    let mut text = String::from("<robot name=\"r\"><link name=\"base\"/>");
    for i in 0..10_000 {
        let _ = writeln!(
            text,
            "<joint name=\"j{i}\" type=\"fixed\"><parent link=\"base\"/><child link=\"nowhere{i}\"/></joint>"
        );
    }
    let found = headlines(&(text + "</robot>"));
    assert_eq!(found.len(), 100);
    assert!(found[0].contains("nowhere0"), "{}", found[0]);
}

#[test]
fn huge_names_make_short_messages() {
    let long = "x".repeat(1 << 20);
    let text = format!(
        "<robot name=\"r\"><link name=\"{long}\"/><{long}/><joint name=\"j\" type=\"{long}\"><parent link=\"{long}y\"/><child link=\"{long}\" {long}=\"\"/></joint></robot>"
    );
    for line in headlines(&text) {
        assert!(line.len() < 300, "{} characters", line.len());
    }
}

/// A name stands in every line of generated code.
#[test]
fn names_are_bounded() {
    let robot = |length: usize| {
        let name = "x".repeat(length);
        format!("<robot name=\"r\"><link name=\"{name}\"/></robot>")
    };
    let refused = |length: usize| {
        let found = headlines(&robot(length));
        found.contains(&"error: `name` of a <link> has more than 256 bytes".to_string())
    };
    assert!(refused(257) && !refused(256));
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    let text = "<robot name=\"r\"><link name=\"a&#9;b&#10;c\"/><joint name=\"j\" type=\"\u{9b}31m\"/></robot>";
    for line in headlines(text) {
        assert!(!line.chars().any(char::is_control), "{line:?}");
    }
}
