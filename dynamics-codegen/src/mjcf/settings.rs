//! `<compiler>` and `<option>`: what the numbers of all other elements mean, and gravity.

use super::document::Element;
use super::pose::EulerSequence;
use super::reader::{Part, Reader};
use super::schema::{COMPILER, FLAG, OPTION};
use crate::diagnostic::Diagnostic;
use crate::robot::Vector3;
use crate::robot::value::Range;

/// When inertias are those of geoms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FromGeoms {
    /// Where a body states none.
    Missing,
    /// Of every body.
    Always,
    Never,
}

/// What the elements' numbers mean.
#[derive(Debug, Clone)]
pub(super) struct Settings {
    /// Whether angles are in degrees.
    pub degrees: bool,
    pub euler: EulerSequence,
    pub from_geoms: FromGeoms,
    /// The groups of geoms that have a part in inertias.
    pub groups: [f64; 2],
    /// Whether moments that no body has are all replaced by their mean.
    pub balance: bool,
    /// The least mass, kg.
    pub least_mass: f64,
    /// The least principal moment, kg·m².
    pub least_inertia: f64,
    /// m/s².
    pub gravity: Vector3,
    /// Whether equalities hold.
    pub equality: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            degrees: true,
            euler: EulerSequence::default(),
            from_geoms: FromGeoms::Missing,
            groups: [0.0, 5.0],
            balance: false,
            least_mass: 0.0,
            least_inertia: 0.0,
            gravity: [0.0, 0.0, -9.81],
            equality: true,
        }
    }
}

impl Settings {
    /// An angle of the file in rad.
    pub fn angle(&self, stated: f64) -> f64 {
        if self.degrees {
            stated.to_radians()
        } else {
            stated
        }
    }
}

impl<'a, 't> Reader<'_, 'a, 't> {
    /// Reads all sections; what a later one states holds.
    pub fn read_settings(&mut self, root: Element<'a, 't>) {
        let mut weightless = false;
        for section in root.children() {
            let part = Part::new(
                section,
                self.classes.main(),
                format!("<{}>", section.name()),
            );
            match section.name() {
                "compiler" => self.compiler(&part),
                "option" => {
                    self.check_attributes(section, &OPTION, &part.owner);
                    let meaning = "an acceleration in m/s²";
                    if let Some(gravity) = part.vector(self, "gravity", meaning) {
                        self.settings.gravity = gravity;
                    }
                    let flags = section.children().into_iter();
                    for flag in flags.filter(|child| child.name() == "flag") {
                        self.check_attributes(flag, &FLAG, "<flag>");
                        let part = Part::new(flag, part.class, "<flag>".to_string());
                        let words = &["enable", "disable"];
                        let word = part.word(self, "gravity", words);
                        weightless = word.map_or(weightless, |word| word == "disable");
                        if let Some(word) = part.word(self, "equality", words) {
                            self.settings.equality = word == "enable";
                        }
                    }
                }
                _ => {}
            }
        }
        if weightless {
            self.settings.gravity = [0.0; 3];
        }
    }

    fn compiler(&mut self, part: &Part<'a, 't>) {
        self.check_attributes(part.element, &COMPILER, &part.owner);
        if let Some(word) = part.word(self, "angle", &["degree", "radian"]) {
            self.settings.degrees = word == "degree";
        }
        if part.word(self, "coordinate", &["local", "global"]) == Some("global") {
            let at = part.given(self, "coordinate").map(|given| given.span());
            let at = at.unwrap_or(part.element.tag());
            self.report(
                Diagnostic::error(at, "coordinates in the world's frame are not read")
                    .help("MuJoCo does not read them either since version 2.3: save the file anew with an older one, which writes local ones"),
            );
        }
        if let Some(given) = part.given(self, "eulerseq") {
            match EulerSequence::of(given.value()) {
                Some(sequence) => self.settings.euler = sequence,
                None => self.report(
                    Diagnostic::error(given.span(), "`eulerseq` of <compiler> is no sequence of axes")
                        .label("expected three of x, y, z (axes that turn along) and X, Y, Z (axes that stay)")
                        .help("MuJoCo's default is xyz; that of URDF is XYZ"),
                ),
            }
        }
        match part.word(self, "inertiafromgeom", &["auto", "true", "false"]) {
            Some("true") => self.settings.from_geoms = FromGeoms::Always,
            Some("false") => self.settings.from_geoms = FromGeoms::Never,
            Some(_) => self.settings.from_geoms = FromGeoms::Missing,
            None => {}
        }
        let groups = part.numbers(
            self,
            "inertiagrouprange",
            [2, 2],
            "the first and the last group",
        );
        if let Some(&[first, last]) = groups.as_deref() {
            self.settings.groups = [first, last];
        }
        if let Some(balance) = part.truth(self, "balanceinertia") {
            self.settings.balance = balance;
        }
        if let Some(mass) = part.number(self, "boundmass", Range::NotNegative, "a mass in kg") {
            self.settings.least_mass = mass;
        }
        let meaning = "a moment of inertia in kg·m²";
        if let Some(least) = part.number(self, "boundinertia", Range::NotNegative, meaning) {
            self.settings.least_inertia = least;
        }
        self.refuse_total_mass(part);
    }

    /// Scaling all masses needs all of them, those of meshes on the world among them.
    fn refuse_total_mass(&mut self, part: &Part<'a, 't>) {
        let total = part.number(self, "settotalmass", Range::Finite, "a mass in kg");
        if total.is_some_and(|mass| mass > 0.0) {
            let at = part.given(self, "settotalmass").map(|given| given.span());
            let error = Diagnostic::error(
                at.unwrap_or(part.element.tag()),
                "masses scaled to a total are not read",
            );
            self.report(error.help(super::inertia::SAVED));
        }
    }
}
