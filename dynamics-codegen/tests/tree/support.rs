//! A robot description straight into a tree: for these tests only, without the
//! checks that a reader for users needs.

use dynamics_codegen::graph::{ExprId, Graph, SymbolId};
use dynamics_codegen::tree::{Body, Coordinate, Inertia, Joint, Placement, Tree};
use serde_json::Value;
use urdf_rs::{JointType, Robot};

/// A tree with its symbols, in the order of the coordinates.
pub struct Loaded {
    pub graph: Graph,
    pub tree: Tree,
    pub q: Vec<SymbolId>,
    pub v: Vec<SymbolId>,
    pub a: Vec<SymbolId>,
    pub u: Vec<SymbolId>,
    /// Body names, in the order of the tree.
    pub names: Vec<String>,
}

impl Loaded {
    pub fn vars(&self, symbols: &[SymbolId]) -> Vec<ExprId> {
        symbols.iter().map(|&s| self.graph.var(s)).collect()
    }

    /// Values of all symbols from states given as blocks `q, v, a, u`.
    pub fn evaluate(&self, outputs: &[ExprId], blocks: [&[f64]; 4]) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.graph.symbol_count()];
        for (symbols, block) in [&self.q, &self.v, &self.a, &self.u].into_iter().zip(blocks) {
            for (symbol, &value) in symbols.iter().zip(block) {
                values[symbol.index()] = value;
            }
        }
        self.graph.evaluate(outputs, &values)
    }

    pub fn body(&self, name: &str) -> usize {
        let found = self.names.iter().position(|n| n == name);
        found.unwrap_or_else(|| panic!("no body {name}"))
    }
}

/// Four symbols per coordinate: `q, v, a, u`.
pub fn symbols(graph: &mut Graph, count: usize) -> [Vec<SymbolId>; 4] {
    ["q", "v", "a", "u"].map(|kind| {
        (0..count)
            .map(|i| graph.symbol(format!("{kind}{i}")))
            .collect()
    })
}

/// Coordinates in the order of `order`, or of the file.
pub fn load(robot: &Robot, order: Option<&[String]>) -> Loaded {
    let mut graph = Graph::new();
    let moving: Vec<String> = (robot.joints.iter())
        .filter(|j| j.joint_type != JointType::Fixed)
        .map(|j| j.name.clone())
        .collect();
    let order = order.map_or(moving, <[String]>::to_vec);
    let [q, v, a, u] = symbols(&mut graph, order.len());
    let root = (robot.links.iter())
        .find(|link| robot.joints.iter().all(|j| j.child.link != link.name))
        .expect("a root");
    let gravity = [0.0, 0.0, -9.81].map(|x| graph.constant(x));
    let mut loaded = Loaded {
        tree: Tree {
            bodies: Vec::new(),
            gravity,
            coordinates: order.len(),
        },
        graph,
        q,
        v,
        a,
        u,
        names: Vec::new(),
    };
    let origin = urdf_rs::Pose::default();
    push(&mut loaded, robot, &root.name, None, &origin, Joint::Fixed);
    let mut next = 0;
    while next < loaded.names.len() {
        let name = loaded.names[next].clone();
        for joint in robot.joints.iter().filter(|j| j.parent.link == name) {
            let motion = motion(&loaded, joint, &order);
            push(
                &mut loaded,
                robot,
                &joint.child.link,
                Some(next),
                &joint.origin,
                motion,
            );
        }
        next += 1;
    }
    loaded
}

fn motion(loaded: &Loaded, joint: &urdf_rs::Joint, order: &[String]) -> Joint {
    let axis = joint.axis.xyz.0;
    let coordinate = || {
        let index = order
            .iter()
            .position(|n| *n == joint.name)
            .expect("a listed joint");
        Coordinate {
            q: loaded.graph.var(loaded.q[index]),
            v: loaded.graph.var(loaded.v[index]),
            index,
            ratio: 1.0,
        }
    };
    match joint.joint_type {
        JointType::Fixed => Joint::Fixed,
        JointType::Revolute | JointType::Continuous => Joint::Revolute {
            axis,
            coordinate: coordinate(),
        },
        JointType::Prismatic => Joint::Prismatic {
            axis,
            coordinate: coordinate(),
        },
        ref other => panic!("joint type {other:?} is not for this loader"),
    }
}

fn push(
    loaded: &mut Loaded,
    robot: &Robot,
    link: &str,
    parent: Option<usize>,
    origin: &urdf_rs::Pose,
    joint: Joint,
) {
    let link = robot.links.iter().find(|l| l.name == link).expect("a link");
    let g = &mut loaded.graph;
    let inertial = &link.inertial;
    let i = &inertial.inertia;
    let tensor = [
        [i.ixx, i.ixy, i.ixz],
        [i.ixy, i.iyy, i.iyz],
        [i.ixz, i.iyz, i.izz],
    ];
    let r = rotation(inertial.origin.rpy.0);
    let turned = multiply(&multiply(&r, &tensor), &transpose(&r));
    let inertia = Inertia {
        mass: g.constant(inertial.mass.value),
        center: inertial.origin.xyz.0.map(|x| g.constant(x)),
        tensor: turned.map(|row| row.map(|x| g.constant(x))),
    };
    let placement = Placement {
        rotation: rotation(origin.rpy.0),
        translation: origin.xyz.0.map(|x| g.constant(x)),
    };
    loaded.names.push(link.name.clone());
    loaded.tree.bodies.push(Body {
        name: link.name.clone(),
        parent,
        placement,
        joint,
        inertia,
    });
}

pub fn rotation([roll, pitch, yaw]: [f64; 3]) -> [[f64; 3]; 3] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

pub fn multiply(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

pub fn transpose(a: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// All numbers of nested lists, in order.
pub fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().expect("a number")],
    }
}

/// The largest difference, relative to the largest entry.
pub fn deviation(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let scale = theirs.iter().fold(1e-12_f64, |s, x| s.max(x.abs()));
    (ours.iter().zip(theirs)).fold(0.0_f64, |worst, (x, y)| {
        let gap = (x - y).abs() / scale;
        if gap.is_nan() {
            f64::INFINITY
        } else {
            worst.max(gap)
        }
    })
}
