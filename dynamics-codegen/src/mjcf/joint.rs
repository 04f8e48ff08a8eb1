//! What a `<joint>` means: how it moves, and what acts in it.

use super::pose::unit;
use super::reader::{Part, Reader};
use super::schema::{FREEJOINT, JOINT};
use crate::diagnostic::Diagnostic;
use crate::robot::spatial::{apply, rotation_about};
use crate::robot::value::Range;
use crate::robot::{IDENTITY, JointKind, Losses, Placement, Spring, Vector3};

/// A joint in the axes of its body.
pub(super) struct Motion {
    pub kind: JointKind,
    /// What it turns about, from the body's origin; any point of a slide.
    pub anchor: Option<Vector3>,
    /// Where it stands at coordinate zero, seen from where the file draws it.
    pub zero: Placement,
    /// Its coordinate as the file draws it, rad or m.
    pub drawn_at: f64,
    pub losses: Option<Losses>,
    pub armature: f64,
    pub spring: Option<Spring>,
}

const TYPES: [&str; 4] = ["hinge", "slide", "ball", "free"];

impl<'a, 't> Reader<'_, 'a, 't> {
    /// Whether a joint is a free one, whatever it is written as.
    pub fn is_free(&mut self, part: &Part<'a, 't>) -> bool {
        part.element.name() == "freejoint"
            || part
                .given(self, "type")
                .is_some_and(|given| given.value() == "free")
    }

    /// Reads a joint that stands in frames at `outer` in its body; `home` is the body's own place.
    pub fn joint(
        &mut self,
        part: &Part<'a, 't>,
        outer: &Placement,
        home: Placement,
    ) -> Option<Motion> {
        if self.is_free(part) {
            return Some(self.free(part, home));
        }
        self.check_attributes(part.element, &JOINT, &part.owner);
        let kind = match part.given(self, "type") {
            Some(_) => part.word(self, "type", &TYPES)?,
            None => "hinge",
        };
        if kind == "ball" {
            return Some(self.ball(part, outer));
        }
        let turns = kind == "hinge";
        let axis = self.axis(part, outer);
        let anchor = part.vector(self, "pos", "lengths in m").unwrap_or_default();
        let at_zero = part.number(self, "ref", Range::Finite, "a coordinate");
        let at_zero = self.coordinate(turns, at_zero.unwrap_or(0.0));
        let mut zero = Placement::IDENTITY;
        if turns && at_zero != 0.0 {
            zero.rotation = rotation_about(axis, -at_zero);
            self.snapped.rotation(&mut zero.rotation);
        } else if !turns {
            zero.translation = axis.map(|x| -at_zero * x);
        }
        Some(Motion {
            kind: match turns {
                true => JointKind::Revolute { axis },
                false => JointKind::Prismatic { axis },
            },
            anchor: turns.then(|| outer.point(anchor)),
            zero,
            drawn_at: at_zero,
            losses: self.losses(part),
            armature: self.acting(part, "armature", "an inertia in kg·m² or kg"),
            spring: self.spring(part, turns),
        })
    }

    fn ball(&mut self, part: &Part<'a, 't>, outer: &Placement) -> Motion {
        let anchor = part.vector(self, "pos", "lengths in m").unwrap_or_default();
        self.ignore(part, "ball", &["stiffness"]);
        Motion {
            kind: JointKind::Ball,
            anchor: Some(outer.point(anchor)),
            zero: Placement::IDENTITY,
            drawn_at: 0.0,
            losses: self.losses(part),
            armature: self.acting(part, "armature", "an inertia in kg·m² or kg"),
            spring: None,
        }
    }

    /// Counts numbers of a joint that do nothing here among what is ignored.
    fn ignore(&mut self, part: &Part<'a, 't>, kind: &str, names: &[&str]) {
        for name in names {
            if self.acting(part, name, "a number") != 0.0 {
                let what = format!("`{name}` of a {kind} <joint>");
                self.ignored.add(what, 1, part.element.tag());
            }
        }
    }

    fn free(&mut self, part: &Part<'a, 't>, home: Placement) -> Motion {
        let short = part.element.name() == "freejoint";
        let rule = if short { &FREEJOINT } else { &JOINT };
        self.check_attributes(part.element, rule, &part.owner);
        if !short {
            let names = ["armature", "damping", "frictionloss", "stiffness"];
            self.ignore(part, "free", &names);
        }
        Motion {
            kind: JointKind::Floating { home },
            anchor: None,
            zero: Placement::IDENTITY,
            drawn_at: 0.0,
            losses: None,
            armature: 0.0,
            spring: None,
        }
    }

    /// A coordinate of the file in rad or m.
    fn coordinate(&self, turns: bool, stated: f64) -> f64 {
        if turns {
            self.settings.angle(stated)
        } else {
            stated
        }
    }

    /// A number that is zero unless stated, and never negative.
    fn acting(&mut self, part: &Part<'a, 't>, name: &str, meaning: &str) -> f64 {
        let value = part.number(self, name, Range::NotNegative, meaning);
        value.unwrap_or(0.0)
    }

    /// The unit axis in the body's axes.
    fn axis(&mut self, part: &Part<'a, 't>, outer: &Placement) -> Vector3 {
        let stated = part.vector(self, "axis", "a direction in the body's frame");
        let stated = stated.unwrap_or(IDENTITY[2]);
        if stated == [0.0; 3] {
            let at = part.given(self, "axis").map(|given| given.span());
            let message = format!("the axis of {} is zero", part.owner);
            let error = Diagnostic::error(at.unwrap_or(part.element.tag()), message);
            self.report(error.label("expected a direction"));
            return IDENTITY[2];
        }
        let mut axis = unit(apply(&outer.rotation, unit(stated)));
        self.snapped.unit_vector(&mut axis);
        axis
    }

    fn losses(&mut self, part: &Part<'a, 't>) -> Option<Losses> {
        let damping = self.linear(part, "damping", "a damping in N·m·s/rad or N·s/m");
        let friction = self.acting(part, "frictionloss", "a torque in N·m, or a force in N");
        let acts = damping != 0.0 || friction != 0.0;
        let span = part.element.tag();
        acts.then_some(Losses {
            damping,
            friction,
            span,
        })
    }

    fn spring(&mut self, part: &Part<'a, 't>, turns: bool) -> Option<Spring> {
        let stiffness = self.linear(part, "stiffness", "a stiffness in N·m/rad or N/m");
        let rest = part.number(self, "springref", Range::Finite, "a coordinate");
        let rest = self.coordinate(turns, rest.unwrap_or(0.0));
        (stiffness != 0.0).then_some(Spring { stiffness, rest })
    }

    /// The first of up to three coefficients of a polynomial: the others must be zero.
    fn linear(&mut self, part: &Part<'a, 't>, name: &str, meaning: &str) -> f64 {
        let numbers = part
            .numbers(self, name, [1, 3], meaning)
            .unwrap_or_default();
        let at = part.given(self, name).map(|given| given.span());
        let at = at.unwrap_or(part.element.tag());
        if numbers.iter().skip(1).any(|&x| x != 0.0) {
            let message = format!("`{name}` of {} is not linear", part.owner);
            self.report(
                Diagnostic::error(at, message)
                    .label("only the first of these numbers is read")
                    .help("write the law in a model: `mjcf \"…\";` and `force joint = …;`"),
            );
        }
        let first = numbers.first().copied().unwrap_or(0.0);
        if first < 0.0 {
            let message = format!("`{name}` of {} is negative: {first}", part.owner);
            self.report(
                Diagnostic::error(at, message).label(format!("expected {meaning}, not below 0")),
            );
        }
        first
    }
}
