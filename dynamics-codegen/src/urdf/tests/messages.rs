//! Every rule with the message that it gives.

use super::{INERTIAL, arm, read_text};
use crate::urdf::Options;

const AXIS: &str = r#"<axis xyz="0 0 1"/>"#;

/// The report about a text, save the remark that the base is massless, which
/// most of the texts share.
fn report(text: &str) -> String {
    let (_, mut report) = read_text(text, Options::default());
    report
        .diagnostics
        .retain(|d| d.message != "link `base` has no <inertial>: it counts as massless");
    report.render()
}

/// One snapshot per rule.
fn check(name: &str, text: &str) {
    insta::with_settings!({ description => text, omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!(name, report(text));
    });
}

/// The arm with this inertial.
fn heavy(inertial: &str) -> String {
    arm("continuous", inertial, AXIS)
}

/// The arm with these elements in its joint.
fn jointed(kind: &str, joint: &str) -> String {
    arm(kind, INERTIAL, joint)
}

/// The arm with this moment of inertia.
fn tensor(diagonal: [&str; 3], ixy: &str) -> String {
    let [ixx, iyy, izz] = diagonal;
    heavy(&format!(
        r#"<inertial>
      <mass value="1"/>
      <inertia ixx="{ixx}" ixy="{ixy}" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/>
    </inertial>"#
    ))
}

#[test]
fn not_xml() {
    check("xml_empty", "");
    check("xml_open", "<robot name=\"r\">\n  <link name=\"base\"/>\n");
    check(
        "xml_crossed",
        "<robot name=\"r\">\n  <link name=\"base\">\n</robot>\n",
    );
    check(
        "xml_garbage",
        "<robot name=\"r\">\n  <link name=base/>\n</robot>\n",
    );
    check(
        "xml_entity",
        "<robot name=\"r\">\n  <link name=\"&hand;\"/>\n</robot>\n",
    );
    check(
        "xml_twice",
        "<robot name=\"r\">\n  <link name=\"base\" name=\"foot\"/>\n</robot>\n",
    );
    check(
        "xml_prefix",
        "<robot name=\"r\">\n  <drake:joint name=\"x\"/>\n</robot>\n",
    );
}

#[test]
fn not_urdf() {
    check(
        "root_mujoco",
        "<mujoco model=\"r\">\n  <worldbody/>\n</mujoco>\n",
    );
    check("root_other", "<html>\n</html>\n");
    check(
        "root_nameless",
        "<robot>\n  <link name=\"base\"/>\n</robot>\n",
    );
    check("root_without_links", "<robot name=\"r\">\n</robot>\n");
    check(
        "root_version",
        "<robot name=\"r\" version=\"one\">\n  <link name=\"base\"/>\n</robot>\n",
    );
}

#[test]
fn doctype() {
    check(
        "doctype",
        r#"<?xml version="1.0"?>
<!DOCTYPE lolz [
  <!ENTITY lol "lol">
  <!ENTITY lol2 "&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;">
]>
<robot name="&lol2;"/>
"#,
    );
}

#[test]
fn xacro() {
    check(
        "xacro_value",
        &heavy(&INERTIAL.replace("value=\"1\"", "value=\"${m}\"")),
    );
    check(
        "xacro_path",
        "<robot name=\"r\">\n  <link name=\"base\">\n    <visual><geometry><mesh filename=\"$(find arm)/base.stl\"/></geometry></visual>\n  </link>\n</robot>\n",
    );
    check(
        "xacro_element",
        "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n  <xacro:include filename=\"arm.xacro\"/>\n</robot>\n",
    );
    check(
        "xacro_undeclared",
        "<robot name=\"r\">\n  <xacro:arm side=\"left\"/>\n</robot>\n",
    );
}

#[test]
fn masses() {
    check(
        "mass_negative",
        &heavy(&INERTIAL.replace("value=\"1\"", "value=\"-1\"")),
    );
    check(
        "mass_nan",
        &heavy(&INERTIAL.replace("value=\"1\"", "value=\"NaN\"")),
    );
    check(
        "mass_comma",
        &heavy(&INERTIAL.replace("value=\"1\"", "value=\"1,5\"")),
    );
    check(
        "mass_missing",
        &heavy(&INERTIAL.replace("<mass value=\"1\"/>", "")),
    );
    check(
        "mass_value_missing",
        &heavy(&INERTIAL.replace("<mass value=\"1\"/>", "<mass>1</mass>")),
    );
    check(
        "mass_misspelt",
        &heavy(&INERTIAL.replace("value=\"1\"", "valeu=\"1\"")),
    );
    check(
        "mass_huge",
        &heavy(&INERTIAL.replace("value=\"1\"", "value=\"1e200\"")),
    );
    check(
        "massless_links",
        &format!(
            "<robot name=\"r\">\n  <link name=\"a\"/>\n  <link name=\"b\">\n    {INERTIAL}\n  </link>\n  <link name=\"tool\"/>\n  <joint name=\"ab\" type=\"fixed\">\n    <parent link=\"a\"/>\n    <child link=\"b\"/>\n  </joint>\n  <joint name=\"bt\" type=\"fixed\">\n    <parent link=\"b\"/>\n    <child link=\"tool\"/>\n  </joint>\n</robot>\n"
        ),
    );
}

#[test]
fn inertias() {
    check(
        "inertia_entries",
        &heavy(&INERTIAL.replace("ixy=\"0\" ixz=\"0\" ", "")),
    );
    check(
        "inertia_missing",
        &heavy("<inertial>\n      <mass value=\"1\"/>\n    </inertial>"),
    );
    check("inertia_triangle", &tensor(["0.01", "0.02", "0.05"], "0"));
    check("inertia_negative", &tensor(["0.01", "-0.02", "0.03"], "0"));
    check("inertia_product", &tensor(["0.01", "0.01", "0.01"], "0.05"));
    check(
        "inertia_rounded",
        &tensor(["0.0102", "0.0497", "0.0600"], "0"),
    );
    check(
        "inertia_without_mass",
        &format!(
            "<robot name=\"r\">\n  <link name=\"base\">\n    {}\n  </link>\n</robot>\n",
            INERTIAL.replace("mass value=\"1\"", "mass value=\"0\"")
        ),
    );
    let camera = INERTIAL
        .replace("mass value=\"1\"", "mass value=\"0.1\"")
        .replace("izz=\"1\"", "izz=\"5\"");
    check(
        "inertia_welded",
        &format!(
            "<robot name=\"r\">\n  <link name=\"base\">\n    {}\n  </link>\n  <link name=\"camera\">\n    {camera}\n  </link>\n  <joint name=\"screws\" type=\"fixed\">\n    <parent link=\"base\"/>\n    <child link=\"camera\"/>\n  </joint>\n</robot>\n",
            INERTIAL.replace("=\"1\"", "=\"100\"")
        ),
    );
}

#[test]
fn immobile_joints() {
    check("immobile_revolute", &arm("continuous", "", AXIS));
    check(
        "immobile_prismatic",
        &arm(
            "prismatic",
            "",
            "<axis xyz=\"0 0 1\"/>\n    <limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/>",
        ),
    );
    check(
        "immobile_point_on_axis",
        &heavy(
            "<inertial>\n      <origin xyz=\"0 0 0.5\"/>\n      <mass value=\"1\"/>\n      <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/>\n    </inertial>",
        ),
    );
}

#[test]
fn spelling() {
    check(
        "element_misspelt",
        &heavy(&INERTIAL.replace("inertial>", "inertail>")),
    );
    check(
        "attribute_misspelt",
        &jointed(
            "continuous",
            "<axis xyz=\"0 0 1\"/>\n    <dynamics dampng=\"0.5\" friction=\"0.1\"/>",
        ),
    );
    check(
        "attribute_unknown",
        &jointed(
            "continuous",
            "<axis xyz=\"0 0 1\"/>\n    <dynamics damping=\"0.5\" mu_viscous=\"16\" K=\"7000\"/>",
        ),
    );
    check(
        "element_unknown",
        &heavy(&format!("{INERTIAL}\n    <self_collision_checking/>")),
    );
    check(
        "element_twice",
        &heavy(&format!("{INERTIAL}\n    {INERTIAL}")),
    );
    check(
        "joint_misspelt",
        "<robot name=\"r\">\n  <link name=\"base\"/>\n  <jiont name=\"shoulder\" type=\"fixed\"/>\n</robot>\n",
    );
    check(
        "stray_text",
        "<robot name=\"r\">\n  <link name=\"base\"/>\n  link name=\"arm\"/>\n</robot>\n",
    );
    check(
        "default_namespace",
        "<robot name=\"r\" xmlns=\"http://www.ros.org\">\n  <link name=\"base\"/>\n  <link name=\"arm\"/>\n</robot>\n",
    );
    check(
        "other_namespace",
        "<robot name=\"r\" xmlns:drake=\"http://drake.mit.edu\">\n  <link name=\"base\"/>\n  <drake:joint name=\"x\"/>\n</robot>\n",
    );
}

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
    check("joint_type_spherical", &jointed("spherical", ""));
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
