//! Links and joints by name, with their places.

use crate::robot::xml::Places;
use crate::source::Span;
use roxmltree::{Document, Node};

/// A `<link>`.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkRecord<'a, 'd> {
    pub name: &'a str,
    pub span: Span,
    pub inertial: Option<Node<'a, 'd>>,
}

/// A `<joint>`.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointRecord<'a, 'd> {
    pub name: &'a str,
    pub span: Span,
    /// `type`, possibly none that we know.
    pub kind: &'a str,
    pub parent: Option<Reference<'a>>,
    pub child: Option<Reference<'a>>,
    pub mimic: Option<Reference<'a>>,
    pub node: Node<'a, 'd>,
}

/// A name that refers to a link or a joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reference<'a> {
    pub name: &'a str,
    pub span: Span,
}

impl<'a, 'd> JointRecord<'a, 'd> {
    /// The child element with this name.
    pub fn element(&self, name: &str) -> Option<Node<'a, 'd>> {
        child(self.node, name)
    }

    /// Whether the joint has one coordinate.
    pub fn has_one_coordinate(&self) -> bool {
        matches!(self.kind, "revolute" | "continuous" | "prismatic")
    }
}

/// Whether a node is an element of URDF with this name: one in the namespace of
/// `<robot>`, which is none as a rule, but some files declare a default.
pub(super) fn is_element(node: Node, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name && is_own(node)
}

/// Whether an element is in the namespace of `<robot>`.
pub(super) fn is_own(element: Node) -> bool {
    let robot = element.document().root_element();
    element.tag_name().namespace() == robot.tag_name().namespace()
}

/// The first child element with this name.
pub(super) fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|child| is_element(*child, name))
}

/// All links and all joints, each in the order of the file; exactly those that
/// urdf-rs will see.
pub(super) fn collect<'a, 'd>(
    places: Places,
    document: &'a Document<'d>,
) -> (Vec<LinkRecord<'a, 'd>>, Vec<JointRecord<'a, 'd>>) {
    let parts = document.root_element().children();
    let links = parts.clone().filter(|n| is_element(*n, "link"));
    let joints = parts.filter(|n| is_element(*n, "joint"));
    (
        links.map(|node| link(places, node)).collect(),
        joints.map(|node| joint(places, node)).collect(),
    )
}

fn link<'a, 'd>(places: Places, node: Node<'a, 'd>) -> LinkRecord<'a, 'd> {
    LinkRecord {
        name: node.attribute("name").unwrap_or(""),
        span: places.value_or_tag(node, "name"),
        inertial: child(node, "inertial"),
    }
}

fn joint<'a, 'd>(places: Places, node: Node<'a, 'd>) -> JointRecord<'a, 'd> {
    let reference = |element: &str, attribute: &str| {
        let element = child(node, element)?;
        Some(Reference {
            name: element.attribute(attribute)?,
            span: places.value_or_tag(element, attribute),
        })
    };
    JointRecord {
        name: node.attribute("name").unwrap_or(""),
        span: places.value_or_tag(node, "name"),
        kind: node.attribute("type").unwrap_or(""),
        parent: reference("parent", "link"),
        child: reference("child", "link"),
        mimic: reference("mimic", "joint"),
        node,
    }
}
