//! What a model may lack, as the library's effects say: place by place the effects of one term
//! together, and what the model states of them already.

use super::neighbours::neighbours;
use super::point::{Point, TEN};
use crate::trace::{carriers, places_of};
use dynamics_codegen::Model;
use dynamics_codegen::model::{Effect, Template};
use dynamics_codegen::syntax::PortKind;
use std::ops::Range;

/// A number that a column corrects: a strength of an effect, or of a load its mass or place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coefficient {
    /// What it is called in the result.
    pub name: String,
    /// The effect's template.
    pub effect: String,
    /// Its name in the template.
    pub parameter: String,
    /// What the model states of it.
    pub stated: f64,
    /// The parameter of the model that holds it; `None` where the model has no such effect, and
    /// for what a robot description says.
    pub holder: Option<String>,
    /// Where the effect does nothing.
    pub default: f64,
    /// What it is not below.
    pub lower: f64,
    /// Its unit, for people.
    pub unit: String,
}

/// A speed over which an effect changes its sign, or another shape, with the value that it has.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shape {
    /// The effect's template.
    pub effect: String,
    /// Its name in the template.
    pub parameter: String,
    /// Its index in the extended model.
    pub index: usize,
    /// What the model or its robot description states.
    pub stated: Option<f64>,
    /// Its bounds.
    pub bounds: (f64, f64),
}

/// A point mass, whose place is found with its mass.
#[derive(Debug, Clone)]
pub(super) struct Load {
    /// What the model states.
    pub carried: Option<Point>,
    /// Where it may be along each axis of the body, m.
    pub bounds: [(f64, f64); 3],
}

/// Columns that come and go together.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// The term that its effects are part of.
    pub term: String,
    /// The coordinates or the body that it acts on.
    pub on: Vec<String>,
    /// What its columns correct; of a load its mass and its place.
    pub coefficients: Vec<Coefficient>,
    /// Speeds that its effects change over.
    pub shapes: Vec<Shape>,
    /// Of a load: the ten of its body.
    pub columns: Range<usize>,
    /// The coordinates' indices; those that a body moves by do not count.
    pub places: Vec<usize>,
    /// What it is of a load.
    pub load: Option<Load>,
}

impl Group {
    /// How far it reaches: what acts in one place is simpler than what two share, and comes first.
    pub fn reach(&self) -> usize {
        usize::from(self.places.len() > 1)
    }

    /// Whether it says something of the machine's structure: what carries what, or drives what.
    pub fn is_bold(&self) -> bool {
        self.load.is_some() || self.reach() > 0
    }
}

/// Effects of one term at one place, before anything is known of their parameters.
#[derive(Debug, Clone)]
pub(super) struct Place<'a> {
    pub term: &'a str,
    pub on: Vec<String>,
    pub templates: Vec<&'a Template>,
}

/// Where the effects of a library that are part of terms may act; loads only on `bodies`, which have mass.
pub(super) fn places<'a>(
    model: &Model,
    templates: &'a [Template],
    bodies: &[String],
) -> Vec<Place<'a>> {
    let coupled = neighbours(model);
    let mut places: Vec<Place<'a>> = Vec::new();
    for template in templates {
        let Some(term) = &template.term else { continue };
        let mut all = match template.point_mass {
            Some(_) => loads(model, &template.name, bodies),
            None => places_of(model, &template.ports, &[]),
        };
        if term.neighbours {
            all.retain(|on| match indices(model, template, on)[..] {
                [i, j] => coupled.contains(&(i.min(j), i.max(j))),
                _ => false,
            });
        }
        for on in all {
            // A load is found by itself.
            let joins = |place: &&mut Place<'_>| {
                let is_load = place.templates[0].point_mass.is_some();
                place.term == term.name
                    && place.on == on
                    && !is_load
                    && template.point_mass.is_none()
            };
            match places.iter_mut().find(joins) {
                Some(place) => place.templates.push(template),
                None => places.push(Place {
                    term: &term.name,
                    on,
                    templates: vec![template],
                }),
            }
        }
    }
    places
}

/// The model's effect of a template at a place.
pub(super) fn effect<'a>(model: &'a Model, template: &str, on: &[String]) -> Option<&'a Effect> {
    let mut effects = model.effects.iter();
    effects.find(|effect| {
        let places = effect.on.iter().map(|(_, name)| name);
        effect.template == template && places.eq(on)
    })
}

/// A load on every group of rigidly connected bodies: where the model has one, else on the heaviest.
fn loads(model: &Model, template: &str, bodies: &[String]) -> Vec<Vec<String>> {
    let is_loaded = |body: &&String| effect(model, template, std::slice::from_ref(*body)).is_some();
    let groups = carriers(model).into_iter();
    let each = groups.filter_map(|mut group| {
        group.retain(|body| bodies.contains(body));
        let carrier = group.iter().find(is_loaded).or(group.first())?;
        Some(vec![carrier.clone()])
    });
    each.collect()
}

/// The coordinates among what a template acts on.
pub(super) fn indices(model: &Model, template: &Template, on: &[String]) -> Vec<usize> {
    let kind = |position: usize| {
        let last = template.ports.len().saturating_sub(1);
        template.ports.get(position.min(last))
    };
    let coordinates = on.iter().enumerate().filter(|(position, _)| {
        matches!(
            kind(*position),
            Some(PortKind::Coordinate | PortKind::Coordinates)
        )
    });
    let index =
        |(_, name): (usize, &String)| model.coordinates.iter().position(|c| c.name == *name);
    coordinates.filter_map(index).collect()
}

/// The columns of a load are those of its body.
pub(super) fn columns_of_body(bodies: &[String], on: &[String]) -> Option<Range<usize>> {
    let index = bodies.iter().position(|body| on == [body.clone()])?;
    Some(TEN * index..TEN * (index + 1))
}
