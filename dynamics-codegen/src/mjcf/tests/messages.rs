//! Every rule with the message that it gives.

use super::{INERTIAL, arm, read_text};
use crate::robot::Options;

/// One snapshot per rule.
fn check(name: &str, text: &str) {
    check_with(name, text, &[]);
}

fn check_with(name: &str, text: &str, files: &[(&str, &str)]) {
    check_read(name, text, files, Options::default());
}

fn check_read(name: &str, text: &str, files: &[(&str, &str)], options: Options) {
    let report = read_text(text, files, options).1.render();
    insta::with_settings!({ description => text, omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!(name, report);
    });
}

/// The arm with an inertia, a hinge and what else stands in it.
fn hinged(inner: &str) -> String {
    arm(
        "",
        &format!("<joint name=\"hinge\"/>\n      {INERTIAL}\n      {inner}"),
    )
}

/// The arm with this joint.
fn jointed(joint: &str) -> String {
    arm("", &format!("{joint}\n      {INERTIAL}"))
}

/// The arm with this inertial.
fn heavy(inertial: &str) -> String {
    arm("", &format!("<joint name=\"hinge\"/>\n      {inertial}"))
}

/// The arm with this line in front of the bodies.
fn under(outer: &str) -> String {
    arm(outer, &format!("<joint name=\"hinge\"/>\n      {INERTIAL}"))
}

#[test]
fn the_outermost_element() {
    check("root_urdf", "<robot name=\"r\"/>\n");
    check("root_part", "<mujocoinclude/>\n");
    check("root_none", "");
    check("root_empty", "<mujoco/>\n");
    check("root_open", "<mujoco>\n  <worldbody>\n");
    check("root_unknown", &under("<compilr angle=\"radian\"/>"));
}

#[test]
fn settings() {
    check("compiler_angle", &under("<compiler angle=\"deg\"/>"));
    check("compiler_sequence", &under("<compiler eulerseq=\"xyw\"/>"));
    check("compiler_misspelt", &under("<compiler angel=\"radian\"/>"));
    check(
        "compiler_global",
        &under("<compiler coordinate=\"global\"/>"),
    );
    check("compiler_total", &under("<compiler settotalmass=\"12\"/>"));
    check("option_gravity", &under("<option gravity=\"0 0\"/>"));
}

#[test]
fn classes() {
    let class = "<default><default class=\"leg\"><joint axis=\"0 1 0\"/></default></default>";
    let of = |name: &str| {
        let joint = format!("<joint name=\"hinge\" class=\"{name}\"/>");
        arm(class, &format!("{joint}\n      {INERTIAL}"))
    };
    check("class_misspelt", &of("legs"));
    check("class_unknown", &of("wheel"));
    let nameless = "<default><default><joint axis=\"0 1 0\"/></default></default>";
    check("class_nameless", &under(nameless));
    let twice = "<default><default class=\"a\"/><default class=\"a\"/></default>";
    check("class_twice", &under(twice));
    // The message points at the default, which is where the mistake is.
    check(
        "class_axis",
        &under("<default><joint axis=\"0 1\"/></default>"),
    );
}

#[test]
fn joints() {
    check(
        "joint_type",
        &jointed("<joint name=\"hip\" type=\"revolute\"/>"),
    );
    check(
        "joint_axis",
        &jointed("<joint name=\"hip\" axis=\"0 0 0\"/>"),
    );
    check(
        "joint_misspelt",
        &jointed("<joint name=\"hip\" dampng=\"1\"/>"),
    );
    check(
        "joint_damping",
        &jointed("<joint name=\"hip\" damping=\"-1\"/>"),
    );
    check(
        "joint_polynomial",
        &jointed("<joint name=\"hip\" damping=\"1 0.2\"/>"),
    );
    check(
        "joint_armature",
        &jointed("<joint name=\"hip\" armature=\"1,5\"/>"),
    );
    check(
        "joint_twice",
        &jointed("<joint name=\"hip\"/><joint name=\"hip\" axis=\"1 0 0\"/>"),
    );
    check(
        "joint_free_and_other",
        &jointed("<freejoint/>\n      <joint name=\"hip\"/>"),
    );
    check(
        "joint_on_world",
        &under("<worldbody><joint name=\"j\"/></worldbody>"),
    );
    check("joint_immobile", &arm("", "<joint name=\"hinge\"/>"));
    check(
        "joint_free_losses",
        &jointed("<joint name=\"base\" type=\"free\" damping=\"0.1\"/>"),
    );
}

#[test]
fn bodies() {
    check("body_pos", &hinged("<body name=\"hand\" pos=\"0 0 x\"/>"));
    check(
        "body_quat",
        &hinged("<body name=\"hand\" quat=\"0 0 0 0\"/>"),
    );
    check(
        "body_both",
        &hinged("<body name=\"hand\" quat=\"1 0 0 0\" euler=\"1 0 0\"/>"),
    );
    check(
        "body_axes",
        &hinged("<body name=\"hand\" xyaxes=\"0 0 1 0 0 2\"/>"),
    );
    check(
        "body_zaxis",
        &hinged("<body name=\"hand\" zaxis=\"0 0 0\"/>"),
    );
    check("body_twice", &hinged("<body name=\"arm\"/>"));
    check("body_world", &hinged("<body name=\"world\"/>"));
    check("body_misspelt", &hinged("<bdy name=\"hand\"/>"));
    check(
        "body_replicate",
        &hinged("<replicate count=\"3\"><body/></replicate>"),
    );
}

#[test]
fn inertias() {
    check(
        "inertial_massless",
        &heavy("<inertial pos=\"0 0 0\" diaginertia=\"1 1 1\"/>"),
    );
    check(
        "inertial_momentless",
        &heavy("<inertial pos=\"0 0 0\" mass=\"1\"/>"),
    );
    check(
        "inertial_impossible",
        &heavy("<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 3\"/>"),
    );
    check(
        "inertial_both",
        &heavy(
            "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\" fullinertia=\"1 1 1 0 0 0\"/>",
        ),
    );
    check(
        "inertial_turned",
        &heavy("<inertial pos=\"0 0 0\" quat=\"1 1 0 0\" mass=\"1\" fullinertia=\"1 1 1 0 0 0\"/>"),
    );
    check(
        "inertial_twice",
        &heavy(&format!("{INERTIAL}\n      {INERTIAL}")),
    );
    check("geom_mesh", &heavy("<geom type=\"mesh\" mesh=\"arm\"/>"));
    check(
        "geom_sizeless",
        &heavy("<geom type=\"capsule\" size=\"0.1\"/>"),
    );
    check(
        "geom_point",
        &heavy("<geom type=\"capsule\" fromto=\"0 0 1 0 0 1\" size=\"0.1\"/>"),
    );
    check(
        "geom_shell",
        &heavy("<geom size=\"0.1\" shellinertia=\"true\"/>"),
    );
}

#[test]
fn equalities() {
    let pin = "<equality><connect body1=\"arm\" anchor=\"0 0 0\"/></equality>";
    check("equality_off", &under(pin));
    let options = Options {
        equalities: true,
        ..Options::default()
    };
    let check = |name: &str, equality: &str| {
        let text = under(&format!("<equality>{equality}</equality>"));
        check_read(name, &text, &[], options);
    };
    check(
        "equality_body",
        "<connect body1=\"arms\" anchor=\"0 0 0\"/>",
    );
    check("equality_anchor", "<connect name=\"pin\" body1=\"arm\"/>");
    check(
        "equality_joint",
        "<joint joint1=\"hinge\" joint2=\"hing\"/>",
    );
    check("equality_nothing", "<joint/>");
    check("equality_kind", "<conect body1=\"arm\" anchor=\"0 0 0\"/>");
    check(
        "equality_ignored",
        "<weld body1=\"arm\"/><connect site1=\"a\" site2=\"b\"/>",
    );
}

#[test]
fn actuators() {
    let drive = |actuator: &str| {
        hinged(&format!(
            "</body></worldbody><actuator>{actuator}</actuator><worldbody><body>"
        ))
    };
    check("actuator_joint", &drive("<motor joint=\"hing\"/>"));
    check(
        "actuator_twice",
        &drive("<motor name=\"a\" joint=\"hinge\"/><motor name=\"a\" joint=\"hinge\"/>"),
    );
    check(
        "actuator_gear",
        &drive("<motor name=\"a\" joint=\"hinge\" gear=\"\"/>"),
    );
    check(
        "actuator_laws",
        &drive("<position joint=\"hinge\"/><position joint=\"hinge\"/><velocity joint=\"hinge\"/>"),
    );
    check(
        "actuator_elsewhere",
        &drive("<motor tendon=\"cable\"/><motor joint=\"hinge\"/>"),
    );
}

#[test]
fn what_is_ignored_is_said_once() {
    let text = arm(
        "<asset><mesh file=\"a.stl\"/><mesh file=\"b.stl\"/></asset><contact/><option density=\"1.2\"/><sensor/>",
        &format!(
            "<joint name=\"hinge\" range=\"-1 1\" group=\"1\"/>\n      {INERTIAL}\n      <geom size=\"1\"/><geom size=\"2\"/><site/><camera/><wing/>"
        ),
    );
    check("ignored", &text);
}

#[test]
fn files_that_are_included() {
    let text = under("<include file=\"parts.xml\"/>");
    check("include_missing", &text);
    check("include_nameless", &under("<include/>"));
    let wrong = "<mujocoinclude>\n  <compiler angle=\"degrees\"/>\n</mujocoinclude>\n";
    check_with("include_wrong", &text, &[("parts.xml", wrong)]);
    check_with("include_broken", &text, &[("parts.xml", "<mujoco>\n")]);
    let itself = "<mujocoinclude>\n  <include file=\"parts.xml\"/>\n</mujocoinclude>\n";
    check_with("include_itself", &text, &[("parts.xml", itself)]);
}
