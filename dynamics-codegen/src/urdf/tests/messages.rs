//! Every rule with the message that it gives.

use super::{INERTIAL, arm, read_text};
use crate::robot::Options;

pub(super) const AXIS: &str = r#"<axis xyz="0 0 1"/>"#;

/// The report about a text.
fn report(text: &str) -> String {
    read_text(text, Options::default()).1.render()
}

/// One snapshot per rule.
pub(super) fn check(name: &str, text: &str) {
    insta::with_settings!({ description => text, omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!(name, report(text));
    });
}

/// The arm with this inertial.
pub(super) fn heavy(inertial: &str) -> String {
    arm("continuous", inertial, AXIS)
}

/// The arm with these elements in its joint.
pub(super) fn jointed(kind: &str, joint: &str) -> String {
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
fn names_with_control_characters() {
    let with = |character: &str| {
        jointed("continuous", AXIS)
            .replace(
                "name=\"shoulder\"",
                &format!("name=\"shoul{character}der\""),
            )
            .replace("\"arm\"", &format!("\"a{character}rm\""))
    };
    check("name_line_break", &with("&#10;"));
    check("name_escape", &with("&#x9f;"));
    // What an editor breaks is a blank, in XML; and other characters have no harm in them.
    for harmless in ["\n", ",", "é", "&quot;"] {
        read_text(&with(harmless), Options::default()).0.unwrap();
    }
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
            "<robot name=\"r\">\n  <link name=\"a\"/>\n  <link name=\"b\">\n    {INERTIAL}\n  </link>\n  <link name=\"camera\"/>\n  <link name=\"tool\"/>\n  <joint name=\"ab\" type=\"fixed\">\n    <parent link=\"a\"/>\n    <child link=\"b\"/>\n  </joint>\n  <joint name=\"bt\" type=\"fixed\">\n    <parent link=\"b\"/>\n    <child link=\"tool\"/>\n  </joint>\n  <joint name=\"bc\" type=\"fixed\">\n    <parent link=\"b\"/>\n    <child link=\"camera\"/>\n  </joint>\n</robot>\n"
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
        &heavy(&INERTIAL.replace("mass value=\"1\"", "mass value=\"0\"")),
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
