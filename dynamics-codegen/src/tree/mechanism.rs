//! A tree in the form in which the recursions use it.

use super::check;
use super::frames;
use super::inertia::PseudoInertia;
use super::link;
use super::lumped::Lumped;
use super::placement::{self, Anchor};
use super::regroup;
use super::turn::Stage;
use super::upright::{self, JointAngle};
use super::vector::{Rotation, Vector};
use super::{Tree, TreeError};
use crate::graph::{ExprId, Graph};

/// More coordinates than this: no trials.
const MANY: usize = 64;

/// Share of the operations of the forward dynamics that articulated bodies must save to be used. Saving
/// a third, those of a humanoid take 0.39 of the time.
const WORTH_A_RECURSION: f64 = 0.1;

/// How a tree is prepared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Entries of placement rotations and axes this close to 0 or ±1 are
    /// rounded: files write π/2 with too few digits. `None` keeps every digit.
    pub snap: Option<f64>,
    /// Whether constant inertia that acts the same on the parent is moved there.
    pub regroup: bool,
    /// Where on their axes the link frames sit.
    pub layout: Layout,
}

impl Default for Options {
    /// Snapping at `1e-9`, regrouping, and the cheaper layout.
    fn default() -> Self {
        Self {
            snap: Some(1e-9),
            regroup: true,
            layout: Layout::Cheapest,
        }
    }
}

/// Where on its joint axis the origin of a link frame sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Where the description puts it.
    AsGiven,
    /// Nearest to the parent's axis: distances lie along the parent's axis.
    Distal,
    /// Nearest to the first child's axis (modified Denavit–Hartenberg):
    /// distances lie along the link's own axis.
    Proximal,
    /// The one of these three for which mass matrix and bias force together
    /// cost the fewest operations; above 64 coordinates `Distal`, untried.
    Cheapest,
}

/// A rotation that was rounded.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapped {
    /// Of which body.
    pub body: String,
    /// The largest change of an entry.
    pub change: f64,
}

/// Inertia that was moved to a parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Regrouped {
    /// From which body.
    pub body: String,
    /// How many of its constants became zero.
    pub constants: usize,
}

/// What the preparation did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Rotations that were rounded, and by how much.
    pub snapped: Vec<Snapped>,
    /// Inertias that were regrouped.
    pub regrouped: Vec<Regrouped>,
    /// The layout in use.
    pub layout: Option<Layout>,
}

/// A direction of motion in a link's frame.
#[derive(Debug, Clone, Copy)]
pub(super) enum Axis {
    /// Rotation about a coordinate axis through the origin.
    Angular(usize),
    /// Translation along a unit vector.
    Linear([f64; 3]),
}

/// One velocity variable of the recursions.
#[derive(Debug, Clone)]
pub(super) struct Freedom {
    pub axis: Axis,
    pub rate: ExprId,
    /// `rate = Σ coefficient · v[index]` (and what depends on time alone);
    /// accelerations likewise, plus the drift.
    pub map: Vec<(usize, ExprId)>,
    /// The rates of the coefficients, if they are not those of a quaternion.
    pub map_rate: Vec<(usize, ExprId)>,
    /// Acceleration at `a = 0`.
    pub drift: ExprId,
}

/// A moving link. `x_parent = R x_link + shift`, `R` the product of the stages.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub parent: Option<usize>,
    /// Constant stages first, then that of the joint.
    pub stages: Vec<Stage>,
    /// How many of the stages are constant.
    pub constant_stages: usize,
    /// What its joint turns by, if the last stage is that turn.
    pub turns_by: Option<JointAngle>,
    pub shift: Vector,
    pub freedoms: Vec<Freedom>,
    pub inertia: PseudoInertia,
    /// Whether an expression drives it.
    pub driven: bool,
    /// Whether it moves by a twist whose axes are fixed in itself.
    pub free: bool,
    /// Pose in the world of the frame that stands in for a root's parent.
    pub base: Base,
    /// For a link that turns by a quaternion: its coordinates' indices,
    pub spherical: Option<[usize; 4]>,
    /// values,
    pub quaternion: Option<[ExprId; 4]>,
    /// and rates.
    pub quaternion_rates: Option<[ExprId; 4]>,
}

/// The constant frame that carries a root link, seen from the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Base {
    pub rotation: Rotation,
    pub translation: Vector,
}

/// A tree of links with single-axis joints, ready for the recursions.
#[derive(Debug, Clone)]
pub struct Mechanism {
    pub(super) links: Vec<Link>,
    /// Per body of the tree: which link carries it, and where.
    pub(super) anchors: Vec<Anchor>,
    pub(super) gravity: Vector,
    pub(super) coordinates: usize,
    pub(super) lumped: Choice,
    /// The same links in frames that do not all turn, where that is cheaper.
    pub(super) upright: Upright,
    is_articulated: bool,
    report: Report,
}

/// Which links are lumped with what carries them where forces are computed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choice {
    /// Where nothing else is.
    pub alone: Lumped,
    /// Where the mass matrix is computed as well.
    pub beside_mass: Lumped,
}

/// Copies of a mechanism whose frames do not all turn, for what takes fewer operations there.
#[derive(Debug, Clone, Default)]
pub(super) struct Upright {
    /// For the bias force alone.
    pub alone: Option<Box<Mechanism>>,
    /// For the mass matrix, and the bias force beside it.
    pub beside_mass: Option<Box<Mechanism>>,
}

/// Operations of the bias force, alone and together with the mass matrix.
struct Fewest {
    alone: usize,
    both: usize,
}

impl Mechanism {
    /// Merges fixed joints, chooses link frames and regroups inertias.
    ///
    /// # Errors
    /// If the tree is not one: see [`TreeError`].
    pub fn new(graph: &mut Graph, tree: &Tree, options: Options) -> Result<Self, TreeError> {
        Self::with_frames(graph, tree, options, |_| true)
    }

    /// As [`new`](Self::new), for a tree of which only some bodies' poses will be
    /// asked for. A wheel that spins about its axis of symmetry then costs no sine
    /// and cosine: how far it has turned makes no difference.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_frames(
        graph: &mut Graph,
        tree: &Tree,
        options: Options,
        is_read: impl Fn(usize) -> bool,
    ) -> Result<Self, TreeError> {
        check::tree(graph, tree)?;
        let read: Vec<bool> = (0..tree.bodies.len()).map(is_read).collect();
        let layouts = match options.layout {
            // A trial derives everything: not for what is large anyway.
            Layout::Cheapest if tree.coordinates > MANY => vec![Layout::Distal],
            Layout::Cheapest => vec![Layout::Distal, Layout::Proximal, Layout::AsGiven],
            layout => vec![layout],
        };
        let mut best: Option<(usize, Self)> = None;
        for layout in layouts {
            let mut mechanism = Self::with_layout(graph, tree, options, layout, &read);
            // The count is of a scratch copy: rejected layouts leave few nodes.
            let cost = mechanism.choose_lumped(&mut graph.clone()).both;
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, mechanism));
            }
        }
        let (_, mut mechanism) = best.expect("at least one layout was tried");
        mechanism.choose_upright(graph);
        mechanism.is_articulated = mechanism.is_cheaper_articulated(&mut graph.clone());
        Ok(mechanism)
    }

    fn with_layout(
        graph: &mut Graph,
        tree: &Tree,
        options: Options,
        layout: Layout,
        read: &[bool],
    ) -> Self {
        let mut report = Report {
            layout: Some(layout),
            ..Report::default()
        };
        let skeleton = placement::merge_fixed(graph, tree, options.snap, &mut report.snapped);
        let frames = frames::choose(graph, &skeleton.joints, layout);
        let turns = skeleton.joints_whose_turn_matters(read);
        let mut links = link::links(graph, &skeleton.joints, &frames, &turns);
        if options.regroup {
            report.regrouped = regroup::regroup(graph, &mut links, &skeleton.joints);
        }
        let anchors = link::anchors(graph, &skeleton.anchors, &frames);
        Self {
            links,
            anchors,
            gravity: tree.gravity,
            coordinates: tree.coordinates,
            lumped: Choice {
                alone: Lumped::NOTHING,
                beside_mass: Lumped::NOTHING,
            },
            upright: Upright::default(),
            is_articulated: false,
            report,
        }
    }

    /// Chooses how forces are computed such that operations are fewest, and returns how many.
    fn choose_lumped(&mut self, graph: &mut Graph) -> Fewest {
        let mass: Vec<ExprId> = self.mass_matrix(graph).concat();
        let mut fewest = |beside: &[ExprId]| {
            let costs = Lumped::CHOICES.map(|lumped| {
                let outputs = [beside, &self.bias_force_by(graph, lumped)].concat();
                (graph.operation_count(&outputs), lumped)
            });
            let costs = costs.into_iter();
            costs
                .min_by_key(|&(cost, _)| cost)
                .expect("there are choices")
        };
        let ((alone, first), (both, second)) = (fewest(&[]), fewest(&mass));
        self.lumped = Choice {
            alone: first,
            beside_mass: second,
        };
        Fewest { alone, both }
    }

    /// Chooses where frames that do not turn with their joints are used.
    fn choose_upright(&mut self, graph: &mut Graph) {
        // The counts are of scratch copies, as those of layouts: what is not used leaves nothing behind.
        let scratch = &mut graph.clone();
        let Some(links) = upright::upright(scratch, &self.links) else {
            return;
        };
        let mut other = Self {
            links,
            ..self.clone()
        };
        let own = self.choose_lumped(&mut graph.clone());
        let its = other.choose_lumped(scratch);
        let (alone, both) = (its.alone < own.alone, its.both < own.both);
        if alone || both {
            let links = upright::upright(graph, &self.links).expect("as in the copy");
            let other = Box::new(Self { links, ..other });
            self.upright = Upright {
                alone: alone.then(|| other.clone()),
                beside_mass: both.then_some(other),
            };
        }
    }

    /// Whether articulated-body inertias save [`WORTH_A_RECURSION`] of the operations of the forward
    /// dynamics: less does not pay, as each operation waits for the one before it. Large trees
    /// are not tried: there it grows with the number of links, the factors with its square.
    fn is_cheaper_articulated(&self, graph: &mut Graph) -> bool {
        if !self.has_own_coordinates(graph) {
            return false;
        }
        if self.coordinates > MANY {
            return true;
        }
        let symbols: Vec<_> = (0..self.coordinates).map(|_| graph.symbol("")).collect();
        let force: Vec<ExprId> = symbols.iter().map(|&symbol| graph.var(symbol)).collect();
        let articulated = self.articulated_forward_dynamics(graph, &force);
        let factored = self.constrained_forward_dynamics(graph, &force, &[], &[]);
        let [articulated, factored] =
            [articulated, factored.acceleration].map(|outputs| graph.operation_count(&outputs));
        articulated as f64 <= (1.0 - WORTH_A_RECURSION) * factored as f64
    }

    /// Whether [`forward_dynamics`](Self::forward_dynamics) goes by articulated-body inertias,
    /// because these take far fewer operations than the mass matrix and its factors.
    pub fn is_articulated(&self) -> bool {
        self.is_articulated
    }

    /// What the preparation did.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// How many generalised coordinates there are.
    pub fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// Whether every joint follows one coordinate in a fixed ratio (or is a
    /// floating body's): what the recursive derivatives are written for.
    pub fn is_simple(&self) -> bool {
        self.links.iter().all(|link| !link.driven)
    }

    /// Whether every coordinate moves a link: what the straight-line solutions are
    /// written for, as a coordinate that moves none has no inertia of the tree.
    pub fn moves_all(&self) -> bool {
        self.elimination_order().len() + self.quaternions().count() == self.coordinates
    }

    /// Whether a quaternion is among the coordinates.
    pub fn is_floating(&self) -> bool {
        self.quaternions().next().is_some()
    }

    /// Each quaternion's places among the coordinates, and its values.
    pub fn quaternions(&self) -> impl Iterator<Item = ([usize; 4], [ExprId; 4])> + '_ {
        let links = self.links.iter();
        links.filter_map(|link| link.spherical.zip(link.quaternion))
    }
}
