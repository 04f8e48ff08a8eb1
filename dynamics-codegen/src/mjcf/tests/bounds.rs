//! Files that are large, deep, or built to hurt.

use super::{INERTIAL, headlines, robot};
use std::fmt::Write;

#[test]
fn a_chain_of_a_thousand_bodies_is_read() {
    let count = 1000;
    let mut text = String::from("<mujoco><worldbody>");
    for i in 0..count {
        let _ = writeln!(text, "<body name=\"b{i}\" pos=\"0 0 1\"><joint/>{INERTIAL}");
    }
    text += &"</body>".repeat(count);
    let robot = robot(&(text + "</worldbody></mujoco>"));
    assert_eq!(robot.degrees_of_freedom(), count);
    assert_eq!(robot.bodies[count].link, format!("b{}", count - 1));
}

#[test]
fn deeper_ones_are_refused() {
    let text = format!(
        "<mujoco><worldbody>{}{}</worldbody></mujoco>",
        "<body>".repeat(100_000),
        "</body>".repeat(100_000)
    );
    let found = headlines(&text);
    assert_eq!(found, ["error: elements are nested more than 1024 deep"]);
}

#[test]
fn classes_in_classes_are_bounded() {
    let mut text = String::from("<mujoco><default>");
    for i in 0..200 {
        let _ = write!(text, "<default class=\"c{i}\">");
    }
    text += &"</default>".repeat(201);
    let found = headlines(&(text + "<worldbody/></mujoco>"));
    assert!(
        found.contains(&"error: classes are nested more than 50 deep".to_string()),
        "{found:?}"
    );
}

#[test]
fn twenty_thousand_bodies_without_names_get_some() {
    let body = format!("<body><joint/>{INERTIAL}</body>");
    let text = format!(
        "<mujoco><worldbody>{}</worldbody></mujoco>",
        body.repeat(20_000)
    );
    let robot = robot(&text);
    assert_eq!(robot.bodies[20_000].link, "body_20000");
}

#[test]
fn ten_thousand_mistakes_are_cut_short() {
    let text = format!(
        "<mujoco><worldbody><body>{}</body></worldbody></mujoco>",
        "<joint type=\"ball\"/>".repeat(10_000)
    );
    assert_eq!(headlines(&text).len(), 100);
}

#[test]
fn huge_names_make_short_messages() {
    let long = "x".repeat(1 << 20);
    let text = format!(
        "<mujoco><{long}/><default><default class=\"{long}\"/></default><worldbody><body name=\"{long}\" childclass=\"{long}y\"><joint name=\"{long}\" {long}=\"\"/></body></worldbody></mujoco>"
    );
    for line in headlines(&text) {
        assert!(line.len() < 400, "{} characters", line.len());
    }
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    let text = "<mujoco><worldbody><body name=\"a&#9;b\"><joint name=\"j&#10;\" type=\"\u{9b}31m\"/></body></worldbody></mujoco>";
    for line in headlines(text) {
        assert!(!line.chars().any(char::is_control), "{line:?}");
    }
}
