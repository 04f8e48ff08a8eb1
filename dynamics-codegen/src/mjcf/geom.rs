//! Masses and inertias of geoms: homogeneous bodies of simple shapes.

use super::pose::{least_turn_to, unit};
use super::reader::{Part, Reader};
use crate::diagnostic::Diagnostic;
use crate::robot::value::Range;
use crate::robot::{Inertia, Matrix3, Placement, Vector3};
use std::f64::consts::PI;

/// kg/m³, unless the geom says otherwise.
const DENSITY: f64 = 1000.0;

const TYPES: [&str; 9] = [
    "sphere",
    "capsule",
    "ellipsoid",
    "cylinder",
    "box",
    "mesh",
    "plane",
    "hfield",
    "sdf",
];

/// A shape with its sizes in m.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Sphere {
        radius: f64,
    },
    /// A cylinder along z with half balls at its ends.
    Capsule {
        radius: f64,
        half_length: f64,
    },
    /// Along z.
    Cylinder {
        radius: f64,
        half_length: f64,
    },
    /// Half its lengths along the axes.
    Ellipsoid(Vector3),
    /// Half its lengths along the axes.
    Box(Vector3),
}

impl Shape {
    /// m³.
    fn volume(self) -> f64 {
        match self {
            Self::Sphere { radius: r } => 4.0 / 3.0 * PI * r * r * r,
            Self::Capsule {
                radius: r,
                half_length: h,
            } => PI * r * r * (2.0 * h + 4.0 / 3.0 * r),
            Self::Cylinder {
                radius: r,
                half_length: h,
            } => 2.0 * PI * r * r * h,
            Self::Ellipsoid([a, b, c]) => 4.0 / 3.0 * PI * a * b * c,
            Self::Box([a, b, c]) => 8.0 * a * b * c,
        }
    }

    /// The principal moments about the centre by the mass, m².
    fn moments(self) -> Vector3 {
        let of_squares = |[a, b, c]: Vector3| [b * b + c * c, a * a + c * c, a * a + b * b];
        match self {
            Self::Sphere { radius: r } => [0.4 * r * r; 3],
            Self::Cylinder {
                radius: r,
                half_length: h,
            } => {
                let across = r * r / 4.0 + h * h / 3.0;
                [across, across, r * r / 2.0]
            }
            Self::Capsule {
                radius: r,
                half_length: h,
            } => {
                // The two half balls are one ball, cut and drawn apart by 2h: the centre of a
                // half ball is 3r/8 from its flat.
                let balls = 4.0 * r / (4.0 * r + 6.0 * h);
                let apart = h * h + 0.75 * r * h;
                let [across, _, along] = Self::Cylinder {
                    radius: r,
                    half_length: h,
                }
                .moments();
                let ball = 0.4 * r * r;
                let mixed = |cylinder: f64, ball: f64| (1.0 - balls) * cylinder + balls * ball;
                let across = mixed(across, ball + apart);
                [across, across, mixed(along, ball)]
            }
            Self::Ellipsoid(halves) => of_squares(halves).map(|x| x / 5.0),
            Self::Box(halves) => of_squares(halves).map(|x| x / 3.0),
        }
    }
}

/// What a geom adds to a body.
pub(super) enum Matter {
    /// Nothing: it only shows or touches.
    None,
    Solid(Inertia),
    /// What only its mesh knows.
    OfMesh,
}

impl<'a, 't> Reader<'_, 'a, 't> {
    /// The inertia of a geom in the frame of what it stands in.
    pub fn matter(&mut self, part: &Part<'a, 't>) -> Matter {
        let group = part.number(self, "group", Range::Finite, "the number of a group");
        let [first, last] = self.settings.groups;
        if !(first..=last).contains(&group.unwrap_or(0.0)) {
            return Matter::None;
        }
        let mass = part.number(self, "mass", Range::NotNegative, "a mass in kg");
        let density = part.number(self, "density", Range::NotNegative, "a density in kg/m³");
        let density = density.unwrap_or(DENSITY);
        let kind = part.word(self, "type", &TYPES).unwrap_or("sphere");
        if matches!(kind, "plane" | "hfield") || mass.unwrap_or(density) == 0.0 {
            return Matter::None;
        }
        if matches!(kind, "mesh" | "sdf") || part.given(self, "mesh").is_some() {
            return Matter::OfMesh;
        }
        if part.truth(self, "shellinertia") == Some(true) {
            let at = part.given(self, "shellinertia").map(|given| given.span());
            let at = at.unwrap_or(part.element.tag());
            let message = format!("the inertia of a shell is not read: {}", part.owner);
            self.report(Diagnostic::error(at, message).help(super::inertia::SAVED));
            return Matter::None;
        }
        let Some((shape, placement)) = self.shape(part, kind) else {
            return Matter::None;
        };
        let mass = mass.unwrap_or(density * shape.volume());
        let moments = shape.moments();
        let tensor: Matrix3 =
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { mass * moments[i] } else { 0.0 }));
        let own = Inertia {
            mass,
            center: [0.0; 3],
            tensor,
        };
        Matter::Solid(own.placed(&placement))
    }

    fn shape(&mut self, part: &Part<'a, 't>, kind: &str) -> Option<(Shape, Placement)> {
        let ends = part.numbers(self, "fromto", [6, 6], "two ends");
        let long = matches!(kind, "capsule" | "cylinder" | "ellipsoid" | "box");
        let between = ends.filter(|_| long);
        let size = part.numbers(self, "size", [1, 3], "lengths in m");
        let (size, placement) = match between {
            Some(ends) => {
                let (half_length, placement) = self.between(part, &ends)?;
                let radius = *size.unwrap_or_default().first()?;
                let size = match kind {
                    "capsule" | "cylinder" => vec![radius, half_length],
                    _ => vec![radius, radius, half_length],
                };
                (size, placement)
            }
            None => (size.unwrap_or_default(), self.pose(part)),
        };
        let needed = match kind {
            "sphere" => 1,
            "capsule" | "cylinder" => 2,
            _ => 3,
        };
        let usable = size.iter().take(needed).filter(|x| **x > 0.0).count();
        if usable < needed {
            self.unsized_geom(part, kind, needed);
            return None;
        }
        let shape = match (kind, &size[..]) {
            ("sphere", &[radius, ..]) => Shape::Sphere { radius },
            ("capsule", &[radius, half_length, ..]) => Shape::Capsule {
                radius,
                half_length,
            },
            ("cylinder", &[radius, half_length, ..]) => Shape::Cylinder {
                radius,
                half_length,
            },
            ("ellipsoid", &[a, b, c]) => Shape::Ellipsoid([a, b, c]),
            ("box", &[a, b, c]) => Shape::Box([a, b, c]),
            _ => return None,
        };
        Some((shape, placement))
    }

    fn unsized_geom(&mut self, part: &Part<'a, 't>, kind: &str, needed: usize) {
        let at = part.given(self, "size").map(|given| given.span());
        let at = at.unwrap_or(part.element.tag());
        let message = format!("{} is a {kind} and has no size", part.owner);
        let expected = match needed {
            1 => "expected `size`: its radius in m, above 0",
            2 => "expected `size`: its radius and half its length in m, above 0",
            _ => "expected `size`: half its lengths along x, y and z in m, above 0",
        };
        let error = Diagnostic::error(at, message).label(expected);
        self.report(error.help(
            "the body's inertia is that of its geoms; one without a mass says so: mass=\"0\"",
        ));
    }

    /// Half the distance of two ends, and the frame between them whose z joins them.
    fn between(&mut self, part: &Part<'a, 't>, ends: &[f64]) -> Option<(f64, Placement)> {
        let &[a, b, c, d, e, f] = ends else {
            return None;
        };
        let along = [a - d, b - e, c - f];
        let scale = along.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if scale == 0.0 {
            let at = part.given(self, "fromto").map(|given| given.span());
            let at = at.unwrap_or(part.element.tag());
            let message = format!("both ends of {} are one point", part.owner);
            self.report(Diagnostic::error(at, message).label("expected two points"));
            return None;
        }
        let square: f64 = along.iter().map(|x| (x / scale).powi(2)).sum();
        let mut rotation = least_turn_to(unit(along));
        self.snapped.rotation(&mut rotation);
        let middle = [(a, d), (b, e), (c, f)].map(|(from, to)| 0.5 * (from + to));
        let placement = Placement {
            rotation,
            translation: middle,
        };
        Some((0.5 * scale * square.sqrt(), placement))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume and moments by summing over a grid of small cubes.
    fn summed(inside: impl Fn(Vector3) -> bool, halves: Vector3) -> (f64, Vector3) {
        let steps = 120;
        let at = |i: usize, half: f64| half * ((2 * i + 1) as f64 / f64::from(steps as u32) - 1.0);
        let (mut count, mut sums) = (0.0, [0.0; 3]);
        for i in 0..steps {
            for j in 0..steps {
                for k in 0..steps {
                    let p = [at(i, halves[0]), at(j, halves[1]), at(k, halves[2])];
                    if inside(p) {
                        count += 1.0;
                        let [x, y, z] = p.map(|x| x * x);
                        sums = [sums[0] + y + z, sums[1] + x + z, sums[2] + x + y];
                    }
                }
            }
        }
        let cell: f64 = halves
            .iter()
            .map(|half| 2.0 * half / steps as f64)
            .product();
        (count * cell, sums.map(|sum| sum / count))
    }

    #[test]
    fn shapes_have_the_moments_of_their_points() {
        let (r, h) = (0.3, 0.5);
        let round = |[x, y, _]: Vector3| x * x + y * y < r * r;
        let cylinder = Shape::Cylinder {
            radius: r,
            half_length: h,
        };
        let capsule = Shape::Capsule {
            radius: r,
            half_length: h,
        };
        let in_capsule = |[x, y, z]: Vector3| {
            let beyond = (z.abs() - h).max(0.0);
            x * x + y * y + beyond * beyond < r * r
        };
        let halves = [0.2, 0.3, 0.4];
        let in_ellipsoid = |p: Vector3| {
            let parts = p.iter().zip(halves);
            parts.map(|(x, half)| (x / half).powi(2)).sum::<f64>() < 1.0
        };
        let cases = [
            (cylinder, summed(round, [r, r, h])),
            (capsule, summed(in_capsule, [r, r, r + h])),
            (Shape::Ellipsoid(halves), summed(in_ellipsoid, halves)),
            (Shape::Box(halves), summed(|_| true, halves)),
        ];
        for (shape, (volume, moments)) in cases {
            let relative = |a: f64, b: f64| (a - b).abs() / b;
            assert!(
                relative(shape.volume(), volume) < 2e-3,
                "{shape:?} {volume}"
            );
            for (own, sum) in shape.moments().into_iter().zip(moments) {
                assert!(relative(own, sum) < 2e-3, "{shape:?} {own} {sum}");
            }
        }
        let ball = Shape::Sphere { radius: 0.7 };
        let same = Shape::Ellipsoid([0.7; 3]);
        assert!((ball.volume() - same.volume()).abs() < 1e-15);
        assert!((ball.moments()[1] - same.moments()[1]).abs() < 1e-15);
    }
}
