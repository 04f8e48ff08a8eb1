//! The bodies, frames and contacts of a model, and where they are at every state.

use dynamics_codegen::graph::{ExprId, Graph};
use dynamics_codegen::model::{Contact, Shape};
use dynamics_codegen::tree::{Frame, Mechanism};
use dynamics_codegen::{Column, Model, System, Tape};
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};
use serde::Serialize;
use std::collections::BTreeMap;

/// Numbers of a pose: position, then a quaternion `x, y, z, w`.
pub const POSE: usize = 7;
/// Numbers of a pose on the tape: position, then the rotation row by row.
const ON_TAPE: usize = 12;
/// Numbers of a body on the tape: mass, centre, tensor row by row.
const INERTIA: usize = 13;
/// Half edges of a body without an inertia, as a share of the machine.
const SMALL: f64 = 0.02;
/// Half edges at most, as a share of how far the bodies are apart: descriptions have inertias that no such body can have.
const LARGE: f64 = 0.25;

/// What can be seen of a machine.
#[derive(Debug, Serialize)]
pub struct Scene {
    /// What has mass.
    pub bodies: Vec<Body>,
    /// Frames that have a name and are no bodies.
    pub frames: Vec<Named>,
    /// What may touch a plane.
    pub contacts: Vec<Touch>,
    /// Size of the machine, m.
    pub size: f64,
    #[serde(skip)]
    tape: Tape,
    /// Which of the tree's bodies have a pose.
    #[serde(skip)]
    posed: Vec<usize>,
}

/// A body as the box of even density that has its inertia.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Which pose is its frame's.
    pub pose: usize,
    /// Which pose it hangs on: that of the next body towards the world.
    pub parent: Option<usize>,
    /// kg.
    pub mass: f64,
    /// Centre of mass in its frame, m.
    pub center: [f64; 3],
    /// Principal axes in its frame, by columns, row by row.
    pub axes: [[f64; 3]; 3],
    /// Half edges along them, m.
    pub half: [f64; 3],
}

/// A frame by its name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// Which pose is its.
    pub pose: usize,
}

/// A contact.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Touch {
    /// Its name.
    pub name: String,
    /// Which pose is that of what touches.
    pub pose: usize,
    /// `point`, `sphere` or `disc`.
    pub shape: &'static str,
    /// m; nothing of a point.
    pub radius: f64,
    /// Which axis of its frame is a disc's.
    pub axis: usize,
    /// Which pose is that of the plane; `None` stands still in the world's origin.
    pub plane: Option<usize>,
    /// Which axis of that frame is the plane's normal.
    pub normal: usize,
}

impl Scene {
    /// That of a model with bodies, its inertias at some values of the parameters; `None` if it has none.
    pub fn new(model: &mut Model, parameters: &[f64]) -> Option<Self> {
        let mechanism = model.mechanism.clone()?;
        let posed = posed(model);
        if posed.is_empty() {
            return None;
        }
        let massive: Vec<usize> = massive(model);
        let arguments = System::arguments(model);
        let mut outputs = Vec::new();
        for &body in &posed {
            outputs.extend(pose(&mut model.graph, &mechanism, body));
        }
        let mut constants = Vec::new();
        for &body in &massive {
            let inertia = model.tree.bodies[body].inertia;
            constants.push(inertia.mass);
            constants.extend(inertia.center);
            constants.extend(inertia.tensor.concat());
        }
        let radii = model.contacts.iter().filter_map(|c| c.shape.radius());
        constants.extend(radii);
        let tape = Tape::new(&model.graph, &constants, &arguments);
        let count = arguments.len() - parameters.len();
        let nothing = vec![Column::Same(0.0); count];
        let given = parameters.iter().map(|&value| Column::Same(value));
        let columns: Vec<Column<'_>> = nothing.into_iter().chain(given).collect();
        let values = tape.evaluate_all(&columns, 1);
        let values: Vec<f64> = values.iter().map(|column| column[0]).collect();
        let mut scene = Self {
            bodies: bodies(model, &massive, &posed, &values),
            frames: frames(model, &massive, &posed),
            contacts: contacts(model, &posed, &values[INERTIA * massive.len()..]),
            size: 0.0,
            tape: Tape::new(&model.graph, &outputs, &arguments),
            posed,
        };
        let spread = scene.extent(&columns, false);
        let most = if spread > 0.0 {
            LARGE * spread
        } else {
            f64::INFINITY
        };
        for body in &mut scene.bodies {
            body.half = body.half.map(|half| half.min(most));
        }
        scene.size = scene.extent(&columns, true);
        if scene.size <= 0.0 {
            scene.size = 1.0;
        }
        let small = SMALL * scene.size;
        for body in &mut scene.bodies {
            body.half = body.half.map(|half| half.max(small));
        }
        Some(scene)
    }

    /// All poses at every state: a row of `7` numbers per pose. `columns` are the tape's arguments, in the order
    /// of [`System::arguments`].
    pub fn poses(&self, columns: &[Column<'_>], count: usize) -> Vec<Vec<[f64; POSE]>> {
        let values = self.tape.evaluate_all(columns, count);
        let pose = |sample: usize, k: usize| {
            let at = |i: usize| values[ON_TAPE * k + i][sample];
            let turn = Matrix3::from_fn(|row, column| at(3 + 3 * row + column));
            let turn =
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
            let [x, y, z, w] = turn.coords.into();
            [at(0), at(1), at(2), x, y, z, w]
        };
        let row = |sample: usize| (0..self.posed.len()).map(|k| pose(sample, k)).collect();
        (0..count).map(row).collect()
    }

    /// How far the bodies' frames are apart where all coordinates are zero, m; with their boxes, if these count. Zero
    /// of nothing that has a size.
    fn extent(&self, columns: &[Column<'_>], boxes: bool) -> f64 {
        let poses = self.poses(columns, 1);
        let nowhere = Vector3::repeat(f64::INFINITY);
        let (mut low, mut high) = (nowhere, -nowhere);
        for body in &self.bodies {
            let [x, y, z, ..] = poses[0][body.pose];
            let reach = Vector3::from(body.half).norm() + Vector3::from(body.center).norm();
            let reach = if boxes && reach.is_finite() {
                reach
            } else {
                0.0
            };
            let origin = Vector3::new(x, y, z);
            if origin.iter().all(|part| part.is_finite()) {
                low = low.inf(&origin.add_scalar(-reach));
                high = high.sup(&origin.add_scalar(reach));
            }
        }
        let size = (high - low).amax();
        if size.is_finite() { size } else { 0.0 }
    }
}

/// The frames that are seen, among the tree's bodies: those of masses and contacts, and those that have a name.
fn posed(model: &Model) -> Vec<usize> {
    let bodies = model.bodies.iter().map(|body| body.frame);
    let touching = model.contacts.iter();
    let touching = touching.flat_map(|c| [c.shape.frame(), c.plane.frame]);
    let mut all: Vec<usize> = bodies.chain(massive(model)).chain(touching).collect();
    all.extend(named(model).into_values());
    all.sort_unstable();
    all.dedup();
    // The world stands still.
    all.retain(|&frame| frame != 0);
    all
}

/// The frames by their names; of a product of transforms that all go by one name, the last.
fn named(model: &Model) -> BTreeMap<&str, usize> {
    let bodies = model.tree.bodies.iter().enumerate().skip(1);
    bodies
        .map(|(frame, body)| (body.name.as_str(), frame))
        .collect()
}

/// What has mass, among the tree's bodies.
fn massive(model: &Model) -> Vec<usize> {
    let weighs = |&body: &usize| {
        let inertia = model.tree.bodies[body].inertia;
        let numbers = [inertia.mass].into_iter().chain(inertia.tensor.concat());
        numbers
            .into_iter()
            .any(|number| !model.graph.is_zero(number))
    };
    (0..model.tree.bodies.len()).filter(weighs).collect()
}

/// The parts of a pose on the tape.
fn pose(graph: &mut Graph, mechanism: &Mechanism, body: usize) -> Vec<ExprId> {
    let frame = Frame::of_body(graph, body);
    let pose = mechanism.pose(graph, &frame);
    pose.position
        .into_iter()
        .chain(pose.rotation.concat())
        .collect()
}

fn bodies(model: &Model, massive: &[usize], posed: &[usize], values: &[f64]) -> Vec<Body> {
    let place = |frame: usize| posed.iter().position(|&p| p == frame);
    let body = |(k, &frame): (usize, &usize)| {
        let numbers = &values[INERTIA * k..INERTIA * (k + 1)];
        let named = model.bodies.iter().find(|body| body.massive == frame);
        let name = named.map_or(&model.tree.bodies[frame].name, |body| &body.name);
        let (axes, half) = equal_box(numbers[0], &numbers[4..]);
        let mut above = model.tree.bodies[frame].parent;
        while let Some(parent) = above.filter(|parent| !massive.contains(parent)) {
            above = model.tree.bodies[parent].parent;
        }
        Some(Body {
            name: name.clone(),
            pose: place(frame)?,
            parent: above.and_then(place),
            mass: numbers[0],
            center: [numbers[1], numbers[2], numbers[3]],
            axes,
            half,
        })
    };
    massive.iter().enumerate().filter_map(body).collect()
}

/// Principal axes and half edges of the box of even density with a mass and a tensor about its centre: with `I₁`
/// about the first axis, `a₁² = 3/(2m) (I₂ + I₃ − I₁)`.
fn equal_box(mass: f64, tensor: &[f64]) -> ([[f64; 3]; 3], [f64; 3]) {
    // Only the upper triangle is said.
    let entry = |i: usize, j: usize| tensor[3 * i.min(j) + i.max(j)];
    let eigen = SymmetricEigen::new(Matrix3::from_fn(entry));
    let moments = eigen.eigenvalues;
    let half = |k: usize| {
        let square = 1.5 / mass * (moments.sum() - 2.0 * moments[k]);
        if square > 0.0 && square.is_finite() {
            square.sqrt()
        } else {
            0.0
        }
    };
    let axes = std::array::from_fn(|i| std::array::from_fn(|j| eigen.eigenvectors[(i, j)]));
    (axes, std::array::from_fn(half))
}

fn frames(model: &Model, massive: &[usize], posed: &[usize]) -> Vec<Named> {
    let others = named(model)
        .into_iter()
        .filter(|(_, frame)| !massive.contains(frame));
    let placed = others.filter_map(|(name, frame)| {
        let pose = posed.iter().position(|&p| p == frame)?;
        Some(Named {
            name: name.to_string(),
            pose,
        })
    });
    placed.collect()
}

fn contacts(model: &Model, posed: &[usize], radii: &[f64]) -> Vec<Touch> {
    let place = |frame: usize| posed.iter().position(|&p| p == frame);
    let mut radii = radii.iter();
    let touch = |contact: &Contact| {
        let radius = match contact.shape.radius() {
            Some(_) => *radii.next()?,
            None => 0.0,
        };
        let (shape, axis) = match contact.shape {
            Shape::Point { .. } => ("point", 2),
            Shape::Sphere { .. } => ("sphere", 2),
            Shape::Disc { axis, .. } => ("disc", axis),
        };
        Some(Touch {
            name: contact.name.clone(),
            pose: place(contact.shape.frame())?,
            shape,
            radius,
            axis,
            plane: place(contact.plane.frame),
            normal: contact.plane.normal,
        })
    };
    model.contacts.iter().filter_map(touch).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics_codegen::{Library, compile};

    /// A box of 2 kg with edges of 0.2, 0.4 and 0.6 m: m/12 (b² + c²).
    #[test]
    fn a_box_has_its_edges() {
        let square = [0.2_f64, 0.4, 0.6].map(|edge| edge * edge);
        let total: f64 = square.iter().sum();
        let [x, y, z] = square.map(|s| 2.0 / 12.0 * (total - s));
        let (axes, mut half) = equal_box(2.0, &[x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z]);
        half.sort_by(f64::total_cmp);
        for (found, edge) in half.iter().zip([0.2, 0.4, 0.6]) {
            assert!((2.0 * found - edge).abs() < 1e-12, "{half:?}");
        }
        assert!(
            axes.iter()
                .flatten()
                .all(|x| x.abs() < 1e-12 || (x.abs() - 1.0).abs() < 1e-12)
        );
    }

    /// A disc on an arm: where it is at a state, and what touches.
    #[test]
    fn bodies_are_where_the_state_puts_them() {
        let text = "model m; coordinate a: rad; parameter r: m = 0.1 in 0..;
            frame arm = rotate_y(a) * translate(0.5, 0, 0);
            body wheel { frame: arm; mass: 1; inertia: diag(1e-3, 2e-3, 1e-3); }
            contact rim: disc_y(wheel, 2*r) on plane_z(world);";
        let mut model = compile("m", text, &Library::builtin()).unwrap().model;
        let scene = Scene::new(&mut model, &[0.1]).unwrap();
        assert_eq!(scene.bodies.len(), 1);
        assert_eq!(scene.contacts[0].radius, 0.2);
        assert_eq!(scene.contacts[0].plane, None);
        let quarter = std::f64::consts::FRAC_PI_2;
        let columns = [0.0, quarter, 0.0, 0.1].map(Column::Same);
        let pose = scene.poses(&columns, 1)[0][scene.bodies[0].pose];
        let turn = quarter / 2.0;
        let expected = [0.0, 0.0, -0.5, 0.0, turn.sin(), 0.0, turn.cos()];
        for (found, expected) in pose.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{pose:?}");
        }
    }
}
