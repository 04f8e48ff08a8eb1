//! The inertia of a body: what `<inertial>` states, or that of its geoms.

use super::geom::Matter;
use super::reader::{Part, Reader};
use super::schema::INERTIAL;
use super::settings::FromGeoms;
use crate::diagnostic::Diagnostic;
use crate::robot::spatial::{congruent, principal_axes};
use crate::robot::value::Range;
use crate::robot::{Format, Impossible, Inertia, Matrix3, Placement, Vector3, excuse};
use crate::source::Span;

/// How what only MuJoCo computes gets into the file.
pub(super) const SAVED: &str = "let MuJoCo write the inertias out: with `<compiler saveinertial=\"true\"/>`, read the file and save it by `mujoco.mj_saveLastXML`";

/// An element with the placement of the frames that it stands in.
pub(super) type Placed<'a, 't> = (Part<'a, 't>, Placement);

/// The body whose inertia is read.
pub(super) struct Owner<'s> {
    pub name: &'s str,
    /// Its opening tag.
    pub tag: Span,
    /// `pos` as written.
    pub pos: Vector3,
}

impl<'a, 't> Reader<'_, 'a, 't> {
    /// The inertia of a body in its own axes, and where it is stated.
    pub fn inertia(
        &mut self,
        owner: &Owner<'_>,
        inertial: Option<&Placed<'a, 't>>,
        geoms: &[Placed<'a, 't>],
    ) -> (Inertia, Option<Span>) {
        let from_geoms = match self.settings.from_geoms {
            FromGeoms::Always => true,
            FromGeoms::Never => false,
            FromGeoms::Missing => inertial.is_none(),
        };
        let (stated, at) = match inertial {
            Some((part, placement)) if !from_geoms => {
                let stated = self.stated(part).unwrap_or(Inertia::ZERO);
                (stated.placed(placement), Some(part.element.tag()))
            }
            _ if from_geoms => {
                let first = geoms.first().map(|(part, _)| part.element.tag());
                (self.of_geoms(owner.name, geoms), first)
            }
            _ => (Inertia::ZERO, None),
        };
        let mut inertia = self.bounded(stated);
        if stated.mass == 0.0 && inertia.mass != 0.0 {
            // The mass that MuJoCo gives to a body without any is not at its origin, but at its
            // `pos` from there.
            inertia.center = owner.pos;
        }
        self.check_possible(owner.name, &inertia, at.unwrap_or(owner.tag));
        (inertia, at)
    }

    fn stated(&mut self, part: &Part<'a, 't>) -> Option<Inertia> {
        self.check_attributes(part.element, &INERTIAL, &part.owner);
        let at = part.element.tag();
        let placement = self.pose(part);
        let mass = part.number(self, "mass", Range::NotNegative, "a mass in kg");
        let meaning = "the principal moments of inertia in kg·m²";
        let diagonal = part.vector(self, "diaginertia", meaning);
        let meaning = "ixx iyy izz ixy ixz iyz in kg·m²";
        let full = part.numbers(self, "fullinertia", [6, 6], meaning);
        let has = |name: &str| part.element.given(name).is_some();
        if !has("mass") {
            let error = Diagnostic::error(at, format!("{} has no `mass`", part.owner));
            self.report(error.label("expected mass=\"…\": a mass in kg"));
        }
        let turned = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];
        let turned = turned.into_iter().find(|name| has(name));
        match (has("diaginertia"), has("fullinertia"), turned) {
            (false, false, _) if self.settings.least_inertia == 0.0 => {
                let error =
                    Diagnostic::error(at, format!("{} has no moments of inertia", part.owner));
                self.report(error.label("expected `diaginertia` or `fullinertia`: moments about the centre of mass in kg·m²"));
            }
            (true, true, _) => {
                let message = format!("{} has both `diaginertia` and `fullinertia`", part.owner);
                self.report(Diagnostic::error(at, message).help("keep one of the two"));
            }
            (_, true, Some(turned)) => {
                let message = format!("{} has both `fullinertia` and `{turned}`", part.owner);
                let error = Diagnostic::error(at, message);
                self.report(
                    error.help("`fullinertia` is along the axes of the body: leave the other out"),
                );
            }
            _ => {}
        }
        let tensor: Matrix3 = match full.as_deref() {
            Some(&[xx, yy, zz, xy, xz, yz]) => [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
            _ => diagonal_matrix(diagonal.unwrap_or_default()),
        };
        let own = Inertia {
            mass: mass?,
            center: [0.0; 3],
            tensor,
        };
        Some(own.placed(&placement))
    }

    fn of_geoms(&mut self, name: &str, geoms: &[Placed<'a, 't>]) -> Inertia {
        let mut whole = Inertia::ZERO;
        for (part, placement) in geoms {
            match self.matter(part) {
                Matter::Solid(inertia) => whole = whole.plus(&inertia.placed(placement)),
                Matter::None => {}
                Matter::OfMesh => {
                    let kind = Format::Mjcf.body();
                    let message = format!("the inertia of {kind} `{name}` is that of a mesh");
                    let error = Diagnostic::error(part.element.tag(), message)
                        .label("meshes are not read")
                        .help("give the body an <inertial>, or the mesh mass=\"0\"");
                    self.report(error.help(SAVED));
                    return Inertia::ZERO;
                }
            }
        }
        whole
    }

    /// With `boundmass`, `boundinertia` and `balanceinertia`.
    fn bounded(&self, inertia: Inertia) -> Inertia {
        let settings = &self.settings;
        let mass = inertia.mass.max(settings.least_mass);
        let (mut moments, axes) = principal_axes(&inertia.tensor);
        let least = settings.least_inertia;
        let small = moments.iter().any(|&moment| moment < least);
        if small {
            moments = moments.map(|moment| moment.max(least));
        }
        let [a, b, c] = moments;
        let largest = a.max(b).max(c);
        let unbalanced = settings.balance && 2.0 * largest > a + b + c;
        if unbalanced {
            moments = [(a + b + c) / 3.0; 3];
        }
        let tensor = match small || unbalanced {
            true => congruent(&axes, &diagonal_matrix(moments)),
            false => inertia.tensor,
        };
        Inertia {
            mass,
            tensor,
            ..inertia
        }
    }

    /// Reports an inertia that no body can have.
    fn check_possible(&mut self, name: &str, inertia: &Inertia, at: Span) {
        if let Some(impossible) = Impossible::of(&inertia.tensor) {
            let mut found = [impossible.finding(at, Format::Mjcf, name, false)];
            if self.impossible {
                excuse(&mut found);
            }
            self.findings.extend(found);
        }
    }
}

fn diagonal_matrix(entries: [f64; 3]) -> Matrix3 {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { entries[i] } else { 0.0 }))
}
