//! What a model often lacks, place by place, and what it states of that already.

use super::point::{Point, TEN};
use dynamics_codegen::Model;
use dynamics_codegen::model::{Effect, FRICTION_SPEED};
use dynamics_codegen::tree::Joint;
use std::ops::Range;

/// Coulomb friction is `tanh(v/v_s)` with `v_s` this share of the fastest motion.
const SMOOTH: f64 = 0.01;
/// Bounds of `v_s` in the library's effects `coulomb` and `joint_coupling`.
const WIDTHS: [(f64, f64); 2] = [(0.001, 2.0), (0.001, 0.5)];

/// What a group stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Law {
    /// Coulomb and viscous friction in a joint.
    Friction,
    /// A rotor behind the gear of a joint.
    Armature,
    /// The term that may push either way.
    Constant,
    /// A drive that turns with the sum of two joints.
    Coupling,
    /// A point mass on a body.
    Payload,
}

/// A number of the model that a column corrects.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stated {
    pub value: f64,
    /// The parameter of an effect that holds it; none for what a robot description says.
    pub parameter: Option<String>,
}

/// Columns that come and go together.
#[derive(Debug, Clone)]
pub(super) struct Group {
    pub law: Law,
    /// The coordinates or the body that it acts on.
    pub on: Vec<String>,
    pub names: Vec<&'static str>,
    /// Of a payload: the ten of its body.
    pub columns: Range<usize>,
    /// The coordinates' indices; those that a payload's body moves by do not count.
    pub places: Vec<usize>,
    /// Per name, what the model states of it.
    pub stated: Vec<Stated>,
    /// The speed at which its smooth sign has reached 76 %, if the model states it.
    width: Option<f64>,
    /// The payload that the model states.
    pub carried: Option<Point>,
}

impl Group {
    /// What it is called.
    pub fn term(&self) -> &'static str {
        match self.law {
            Law::Friction => "friction",
            Law::Armature => "armature",
            Law::Constant => "constant_force",
            Law::Coupling => "joint_coupling",
            Law::Payload => "payload",
        }
    }

    /// Whether its coefficients, with what the model states of them, are zero or more by nature.
    pub fn is_signed(&self) -> bool {
        !matches!(self.law, Law::Constant | Law::Payload)
    }

    /// How far it reaches: what acts in one place is simpler than what two share, and comes first.
    pub fn reach(&self) -> usize {
        usize::from(self.law == Law::Coupling)
    }

    /// `v_s` of its dry friction, on a log whose coordinates move so fast at most.
    pub fn width(&self, fastest: &[f64]) -> f64 {
        let speed: f64 = self.places.iter().map(|&i| fastest[i]).sum();
        let (low, high) = WIDTHS[usize::from(self.law == Law::Coupling)];
        // With the digits that it is written into a model with.
        let own = format!("{:.1e}", SMOOTH * speed).parse().unwrap_or(low);
        self.width.unwrap_or(f64::clamp(own, low, high))
    }

    /// Its columns: per column, per coordinate, a value per sample. Those of a payload are its
    /// body's.
    pub fn evaluate(&self, v: &[Vec<f64>], a: &[Vec<f64>], fastest: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let samples = v.first().map_or(0, Vec::len);
        let zeros = vec![vec![0.0; samples]; v.len()];
        let sign = |rate: &[f64]| -> Vec<f64> {
            let smooth = self.width(fastest);
            rate.iter().map(|v| (v / smooth).tanh()).collect()
        };
        let on = |values: Vec<f64>| {
            let mut column = zeros.clone();
            for &i in &self.places {
                column[i].clone_from(&values);
            }
            column
        };
        // What turns with all its places.
        let sum = |x: &[Vec<f64>]| {
            let mut sum = vec![0.0; samples];
            for &i in &self.places {
                sum.iter_mut().zip(&x[i]).for_each(|(s, x)| *s += x);
            }
            sum
        };
        match self.law {
            Law::Friction => vec![on(sign(&sum(v))), on(sum(v))],
            Law::Armature => vec![on(sum(a))],
            Law::Constant => vec![on(vec![1.0; samples])],
            Law::Coupling => vec![on(sign(&sum(v))), on(sum(a)), on(sum(v))],
            Law::Payload => Vec::new(),
        }
    }
}

/// What may be missing of a model whose inertial columns are those of `bodies`; its further
/// columns begin behind these.
pub(super) fn groups(model: &Model, parameters: &[f64], bodies: &[String]) -> Vec<Group> {
    let known = Known { model, parameters };
    let mut groups = Vec::new();
    let mut next = TEN * bodies.len();
    let mut push = |law, places: Vec<usize>, names: Vec<&'static str>| {
        let on = places.iter().map(|&i| model.coordinates[i].name.clone());
        let on: Vec<String> = on.collect();
        let columns = next..next + names.len();
        next = columns.end;
        groups.push(Group {
            law,
            stated: known.stated(law, &on, &places),
            width: known.width(law, &on, &places),
            on,
            names,
            columns,
            places,
            carried: None,
        });
    };
    for i in 0..model.coordinates.len() {
        push(Law::Friction, vec![i], vec!["coulomb", "viscous"]);
        push(Law::Armature, vec![i], vec!["inertia"]);
        push(Law::Constant, vec![i], vec!["force"]);
    }
    for (i, j) in neighbours(model) {
        let names = vec!["coulomb", "inertia", "viscous"];
        push(Law::Coupling, vec![i, j], names);
    }
    for (index, body) in bodies.iter().enumerate() {
        groups.push(Group {
            law: Law::Payload,
            on: vec![body.clone()],
            names: vec!["m", "x", "y", "z"],
            columns: TEN * index..TEN * (index + 1),
            places: Vec::new(),
            stated: known.stated(Law::Payload, std::slice::from_ref(body), &[]),
            width: None,
            carried: known.carried(body),
        });
    }
    groups
}

/// A model with values of its parameters.
struct Known<'a> {
    model: &'a Model,
    parameters: &'a [f64],
}

impl Known<'_> {
    /// The model's effect of a template at a place.
    fn effect(&self, template: &str, on: &[String]) -> Option<&Effect> {
        let mut effects = self.model.effects.iter();
        effects.find(|effect| {
            let places = effect.on.iter().map(|(_, name)| name);
            effect.template == template && places.eq(on)
        })
    }

    /// The value of an effect's parameter.
    fn parameter(&self, effect: &Effect, name: &str) -> Option<Stated> {
        let suffix = format!("_{name}");
        let mut own = effect.parameters.iter();
        let index = own.find(|&&p| self.model.parameters[p].name.ends_with(&suffix))?;
        Some(Stated {
            value: *self.parameters.get(*index)?,
            parameter: Some(self.model.parameters[*index].name.clone()),
        })
    }

    fn stated(&self, law: Law, on: &[String], places: &[usize]) -> Vec<Stated> {
        let of = |template: &str, name: &str, described: f64| {
            let effect = self.effect(template, on);
            let stated = effect.and_then(|effect| self.parameter(effect, name));
            stated.unwrap_or(Stated {
                value: described,
                parameter: None,
            })
        };
        match law {
            Law::Friction => {
                let [friction, damping] = self.described(places);
                vec![of("coulomb", "f_c", friction), of("viscous", "d", damping)]
            }
            Law::Armature => vec![of("armature", "i", 0.0)],
            // The effect pushes; the column holds back.
            Law::Constant => {
                let mut stated = of("constant_force", "f", 0.0);
                stated.value = -stated.value;
                vec![stated]
            }
            Law::Coupling => ["f_c", "i", "d"]
                .map(|name| of("joint_coupling", name, 0.0))
                .to_vec(),
            Law::Payload => ["m", "x", "y", "z"]
                .map(|name| of("payload", name, 0.0))
                .to_vec(),
        }
    }

    /// Coulomb and viscous friction that the robot description states of a joint by itself.
    fn described(&self, places: &[usize]) -> [f64; 2] {
        let robot = self.model.robot.iter();
        let losses = robot.flat_map(|robot| &robot.losses);
        let own = losses.filter(|l| !l.follows && places == [l.coordinate]);
        own.fold([0.0; 2], |[f, d], l| [f + l.friction, d + l.damping])
    }

    fn width(&self, law: Law, on: &[String], places: &[usize]) -> Option<f64> {
        let template = match law {
            Law::Friction => "coulomb",
            Law::Coupling => "joint_coupling",
            _ => return None,
        };
        let effect = self.effect(template, on);
        let stated = effect.and_then(|effect| self.parameter(effect, "v_s"));
        let described = law == Law::Friction && self.described(places)[0] != 0.0;
        let described = described.then_some(FRICTION_SPEED);
        stated.map(|stated| stated.value).or(described)
    }

    fn carried(&self, body: &String) -> Option<Point> {
        let effect = self.effect("payload", std::slice::from_ref(body))?;
        let value = |name| Some(self.parameter(effect, name)?.value);
        Some(Point {
            mass: value("m")?,
            at: [value("x")?, value("y")?, value("z")?],
        })
    }
}

/// Pairs of coordinates that a transmission can couple: of joints of which one carries the other
/// with none between, in one unit. Of a model without bodies, all in one unit.
fn neighbours(model: &Model) -> Vec<(usize, usize)> {
    let alike =
        |&(i, j): &(usize, usize)| model.coordinates[i].dimension == model.coordinates[j].dimension;
    let bodies = &model.tree.bodies;
    let moved: Vec<Vec<usize>> = bodies.iter().map(|body| moved_by(&body.joint)).collect();
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    if moved.iter().all(Vec::is_empty) {
        let n = model.coordinates.len();
        pairs.extend((0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))));
    }
    for (body, own) in moved.iter().enumerate() {
        let ancestors = std::iter::successors(bodies[body].parent, |&p| bodies[p].parent);
        let mut ancestors = ancestors.map(|parent| &moved[parent]);
        let nearest = ancestors.find(|theirs| theirs.iter().any(|i| !own.contains(i)));
        for (&i, &j) in own
            .iter()
            .flat_map(|i| nearest.into_iter().flatten().map(move |j| (i, j)))
        {
            if i != j {
                pairs.push((i.min(j), i.max(j)));
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs.retain(alike);
    pairs
}

/// The coordinates that a joint moves by; of a free body none, as no drive sits there.
fn moved_by(joint: &Joint) -> Vec<usize> {
    match joint {
        Joint::Fixed | Joint::Floating(_) => Vec::new(),
        Joint::Revolute { coordinate, .. } | Joint::Prismatic { coordinate, .. } => {
            vec![coordinate.index]
        }
        Joint::Planar { coordinates, .. } => coordinates.iter().map(|c| c.index).collect(),
        Joint::Driven { displacement, .. } => displacement.map.iter().map(|(i, _)| *i).collect(),
    }
}
