//! The rules about names, trees and joints with the messages that they give.

use super::INERTIAL;
use super::messages::{AXIS, check, heavy, jointed};

#[test]
fn names() {
    check(
        "link_twice",
        "<robot name=\"r\">\n  <link name=\"base\"/>\n  <link name=\"base\"/>\n</robot>\n",
    );
    check("link_nameless", "<robot name=\"r\">\n  <link/>\n</robot>\n");
    check(
        "link_empty_name",
        "<robot name=\"r\">\n  <link name=\"\"/>\n</robot>\n",
    );
    check(
        "dangling_world",
        &heavy(INERTIAL).replace("  <link name=\"base\"/>\n", ""),
    );
    check(
        "dangling_misspelt",
        &heavy(INERTIAL).replace("child link=\"arm\"", "child link=\"amr\""),
    );
    check(
        "joint_twice",
        &format!(
            "<robot name=\"r\">\n  <link name=\"a\"/>\n  <link name=\"b\"/>\n  <link name=\"c\"/>\n{}{}</robot>\n",
            fixed("j", "a", "b"),
            fixed("j", "b", "c")
        ),
    );
    check(
        "joint_nameless",
        &heavy(INERTIAL).replace(" name=\"shoulder\"", ""),
    );
    check(
        "joint_without_child",
        &heavy(INERTIAL).replace("    <child link=\"arm\"/>\n", ""),
    );
}

/// A fixed joint.
fn fixed(name: &str, parent: &str, child: &str) -> String {
    format!(
        "  <joint name=\"{name}\" type=\"fixed\">\n    <parent link=\"{parent}\"/>\n    <child link=\"{child}\"/>\n  </joint>\n"
    )
}

/// A robot of fixed joints between massless links.
fn skeleton(links: &[&str], joints: &[(&str, &str, &str)]) -> String {
    let links: String = links
        .iter()
        .map(|l| format!("  <link name=\"{l}\">{INERTIAL}</link>\n"))
        .collect();
    let joints: String = joints.iter().map(|&(n, p, c)| fixed(n, p, c)).collect();
    format!("<robot name=\"r\">\n{links}{joints}</robot>\n")
}

#[test]
fn trees() {
    check(
        "tree_two_parents",
        &skeleton(
            &["a", "b", "c"],
            &[("ab", "a", "b"), ("ac", "a", "c"), ("bc", "b", "c")],
        ),
    );
    check(
        "tree_two_roots",
        &skeleton(&["a", "b", "c"], &[("ab", "a", "b")]),
    );
    check(
        "tree_ring",
        &skeleton(
            &["a", "b", "c"],
            &[("ab", "a", "b"), ("bc", "b", "c"), ("ca", "c", "a")],
        ),
    );
    check(
        "tree_ring_beside_root",
        &skeleton(&["base", "a", "b"], &[("ab", "a", "b"), ("ba", "b", "a")]),
    );
    check(
        "tree_itself",
        &skeleton(&["base", "a"], &[("aa", "a", "a")]),
    );
}

#[test]
fn joints() {
    check("joint_type_misspelt", &jointed("revolut", AXIS));
    check(
        "joint_type_missing",
        &heavy(INERTIAL).replace(" type=\"continuous\"", ""),
    );
    check("axis_zero", &jointed("continuous", "<axis xyz=\"0 0 0\"/>"));
    check("axis_long", &jointed("continuous", "<axis xyz=\"0 1 1\"/>"));
    check("axis_missing", &jointed("continuous", ""));
    check(
        "axis_word",
        &jointed("continuous", "<axis xyz=\"0 one 0\"/>"),
    );
    check(
        "axis_two_numbers",
        &jointed("continuous", "<axis xyz=\"0 1\"/>"),
    );
    check(
        "axis_commas",
        &jointed("continuous", "<axis xyz=\"0, 0, 1\"/>"),
    );
    check(
        "origin_nan",
        &jointed(
            "continuous",
            "<axis xyz=\"0 0 1\"/>\n    <origin xyz=\"0 0 nan\"/>",
        ),
    );
    check(
        "damping_negative",
        &jointed(
            "continuous",
            "<axis xyz=\"0 0 1\"/>\n    <dynamics damping=\"-0.5\"/>",
        ),
    );
}

#[test]
fn limits() {
    check("limit_missing", &jointed("revolute", AXIS));
    check(
        "limit_reversed",
        &jointed(
            "revolute",
            "<axis xyz=\"0 0 1\"/>\n    <limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>",
        ),
    );
    check(
        "limit_empty_range",
        &jointed(
            "revolute",
            "<axis xyz=\"0 0 1\"/>\n    <limit lower=\"0\" upper=\"0\" effort=\"1\" velocity=\"1\"/>",
        ),
    );
    check(
        "limit_partial",
        &jointed(
            "revolute",
            "<axis xyz=\"0 0 1\"/>\n    <limit upper=\"1\" effort=\"1\"/>",
        ),
    );
    check(
        "limit_negative_effort",
        &jointed(
            "revolute",
            "<axis xyz=\"0 0 1\"/>\n    <limit lower=\"-1\" upper=\"1\" effort=\"-1\" velocity=\"1\"/>",
        ),
    );
}

#[test]
fn quaternions() {
    let origin = |attributes: &str| format!("<axis xyz=\"0 0 1\"/>\n    <origin {attributes}/>");
    let quaternion = jointed("continuous", &origin("quat_xyzw=\"0 0 0 1\""));
    check("quaternion_version", &quaternion);
    let newer = |text: &str| text.replace("name=\"r\"", "name=\"r\" version=\"1.1\"");
    check(
        "quaternion_zero",
        &newer(&quaternion.replace("0 0 0 1", "0 0 0 0")),
    );
    check(
        "quaternion_and_rpy",
        &newer(&quaternion.replace("quat", "rpy=\"0 0 0\" quat")),
    );
}

/// Three joints side by side, with these mimics.
fn hand(mimics: [&str; 3]) -> String {
    let mut text = "<robot name=\"hand\">\n  <link name=\"base\"/>\n".to_string();
    for (i, mimic) in mimics.iter().enumerate() {
        text += &format!("  <link name=\"finger{i}\">{INERTIAL}</link>\n");
        text += &format!(
            "  <joint name=\"f{i}\" type=\"continuous\">\n    <parent link=\"base\"/>\n    <child link=\"finger{i}\"/>\n    <axis xyz=\"0 0 1\"/>\n    {mimic}\n  </joint>\n"
        );
    }
    text + "</robot>\n"
}

#[test]
fn mimics() {
    check("mimic_unknown", &hand(["", "<mimic joint=\"f00\"/>", ""]));
    check("mimic_itself", &hand(["", "<mimic joint=\"f1\"/>", ""]));
    check(
        "mimic_chain",
        &hand([
            "",
            "<mimic joint=\"f0\"/>",
            "<mimic joint=\"f1\" multiplier=\"-1\"/>",
        ]),
    );
    check(
        "mimic_ring",
        &hand([
            "<mimic joint=\"f2\"/>",
            "<mimic joint=\"f0\"/>",
            "<mimic joint=\"f1\"/>",
        ]),
    );
    check(
        "mimic_fixed",
        &hand(["", "<mimic joint=\"f0\"/>", ""]).replacen("continuous", "fixed", 1),
    );
    check(
        "mimic_by_planar",
        &hand(["<mimic joint=\"f1\"/>", "", ""]).replacen("continuous", "planar", 1),
    );
    check(
        "mimic_by_fixed",
        &hand(["<mimic joint=\"f1\"/>", "", ""]).replacen("continuous", "fixed", 1),
    );
}

#[test]
fn several_mistakes_are_shown_at_once() {
    let text = jointed(
        "continuous",
        "<axis xyz=\"0 0 0\"/>\n    <mimic joint=\"elbow\"/>",
    )
    .replace("parent link=\"base\"", "parent link=\"bse\"")
    .replace("izz=\"1\"", "izz=\"3\"");
    check("several", &text);
}
