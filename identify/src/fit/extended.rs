//! The model with every effect that a fit may add, and what a unit of each strength adds to the
//! forces: the same columns, from the same templates, as a trace has.

use super::groups::{
    Coefficient, Group, Load, Place, Shape, columns_of_body, effect, indices, places,
};
use super::losses::state_losses;
use super::point::Point;
use super::{FitError, Source};
use crate::machine::{Machine, SensitivityTape, States};
use crate::trace::{Role, Roles, Subject};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::model::{Effect, PointMass, Template};
use dynamics_codegen::syntax::written_name;
use dynamics_codegen::{Model, compile};
use std::collections::BTreeMap;

/// The extended model.
#[derive(Debug, Clone)]
pub(super) struct Extended {
    machine: Machine,
    /// Derivatives by the strengths of all groups but loads.
    tape: SensitivityTape,
    values: Vec<f64>,
}

/// What an effect's parameters do: strengths in which its force is linear, and shapes.
struct Parts {
    strengths: Vec<usize>,
    shapes: Vec<usize>,
}

impl Extended {
    /// Of a model with values of its parameters, and the groups of columns: those of loads are
    /// the ones of the bodies that carry them, those of all others stand behind `first`.
    ///
    /// # Errors
    /// If an effect that is part of a term does not compile, or cannot be fitted.
    pub fn new(
        source: &Source<'_>,
        model: &Model,
        parameters: &[f64],
        (bodies, first): (&[String], usize),
    ) -> Result<(Self, Vec<Group>), FitError> {
        let library = source.library;
        let templates = library.names().filter_map(|name| library.describe(name));
        let templates: Vec<Template> = templates.filter(|t| t.term.is_some()).collect();
        let places = places(model, &templates, bodies);
        let text = source.text.to_string() + &statements(model, &places);
        let compiled = compile(source.name, &text, library);
        let compiled = compiled.map_err(|report| FitError::Effects(Box::new(report)))?;
        let mut values = compiled.model.nominal_parameters();
        values[..parameters.len()].copy_from_slice(parameters);
        let mut machine = Machine::new(compiled);
        let known = Known {
            given: model,
            extended: &machine.compiled.model,
            values: &values,
        };
        let parts = known.parts(&machine, &places)?;
        let (mut groups, mut strengths) = (Vec::new(), Vec::new());
        for place in &places {
            let group = match place.templates[0].point_mass {
                Some(mass) => known.load(place, mass, bodies),
                None => Some(known.group(place, &parts, first, &mut strengths)),
            };
            groups.extend(group);
        }
        let tape = machine.sensitivity(&strengths);
        let extended = Self {
            machine,
            tape,
            values,
        };
        state_losses(model, &extended, &mut groups, first);
        Ok((extended, groups))
    }

    /// `∂(M a − Q)/∂s` by every strength, with some parameters (by index) at other values: per
    /// strength, per coordinate, a value per sample.
    pub fn columns(
        &self,
        states: &States,
        a: &[Vec<f64>],
        shapes: &[(usize, f64)],
    ) -> Vec<Vec<Vec<f64>>> {
        let mut values = self.values.clone();
        shapes
            .iter()
            .for_each(|&(index, value)| values[index] = value);
        let states = self.machine.at_rest(states, &values);
        self.tape.forces(&states, &values, a)
    }
}

/// The effects that the model has not yet. How far a load may be stands in its template, so that
/// one on any body says it for all.
fn statements(model: &Model, places: &[Place<'_>]) -> String {
    let mut text = String::new();
    let mut loads: Vec<&str> = Vec::new();
    for place in places {
        for template in &place.templates {
            let name = template.name.as_str();
            let is_known = match template.point_mass {
                Some(_) => {
                    loads.contains(&name) || model.effects.iter().any(|e| e.template == name)
                }
                None => effect(model, name, &place.on).is_some(),
            };
            if is_known {
                continue;
            }
            if template.point_mass.is_some() {
                loads.push(name);
            }
            let on: Vec<String> = place.on.iter().map(|name| written_name(name)).collect();
            text.push_str(&format!("\neffect {name}({});", on.join(", ")));
        }
    }
    text
}

/// Both models, with values of the extended one's parameters.
struct Known<'a> {
    given: &'a Model,
    extended: &'a Model,
    values: &'a [f64],
}

impl Known<'_> {
    /// What the parameters of each template do, by its first place: positions among its parameters.
    fn parts(
        &self,
        machine: &Machine,
        places: &[Place<'_>],
    ) -> Result<BTreeMap<String, Parts>, FitError> {
        let mut defaults = self.values.to_vec();
        for (default, parameter) in defaults.iter_mut().zip(&self.extended.parameters) {
            if parameter.effect.is_some() {
                *default = parameter.default;
            }
        }
        let mut roles = Roles::new(&machine.compiled, &defaults, |_| false);
        let mut parts = BTreeMap::new();
        for place in places {
            for template in place.templates.iter().filter(|t| t.point_mass.is_none()) {
                if parts.contains_key(&template.name) {
                    continue;
                }
                let Some(effect) = effect(self.extended, &template.name, &place.on) else {
                    continue;
                };
                let own = self.parts_of(effect, &mut roles);
                let own = own.map_err(|why| FitError::Unfit {
                    effect: template.name.clone(),
                    why,
                })?;
                parts.insert(template.name.clone(), own);
            }
        }
        Ok(parts)
    }

    fn parts_of(&self, effect: &Effect, roles: &mut Roles) -> Result<Parts, &'static str> {
        let found = roles.of(&effect.parameters);
        let having = |wanted: &[Role]| -> Vec<usize> {
            let all = found.iter().enumerate();
            let having = all.filter(|(_, role)| wanted.contains(role));
            having.map(|(position, _)| position).collect()
        };
        let parts = Parts {
            strengths: having(&[Role::Strength]),
            shapes: having(&[Role::Shape, Role::Curved]),
        };
        let strengths: Vec<usize> = (parts.strengths.iter())
            .map(|&position| effect.parameters[position])
            .collect();
        let subject = Subject::Effect {
            template: effect.template.clone(),
            on: effect.on.iter().map(|(_, name)| name.clone()).collect(),
        };
        let prefix = subject.prefix();
        let mut states = self.extended.states.iter();
        match strengths.is_empty() {
            true => Err("no parameter of it changes a force from where it does nothing"),
            false if states.any(|state| state.name.starts_with(&prefix)) => {
                Err("it has a state, and a fit looks at each sample by itself")
            }
            false if !roles.is_linear(&strengths) => {
                Err("its force is not linear in its strengths")
            }
            false => Ok(parts),
        }
    }

    /// The group of the effects at a place; their strengths follow those that there are.
    fn group(
        &self,
        place: &Place<'_>,
        parts: &BTreeMap<String, Parts>,
        first: usize,
        strengths: &mut Vec<Variable>,
    ) -> Group {
        let places = indices(self.given, place.templates[0], &place.on);
        let (mut coefficients, mut shapes) = (Vec::new(), Vec::new());
        let begin = first + strengths.len();
        for template in &place.templates {
            let found = effect(self.extended, &template.name, &place.on);
            let Some((effect, parts)) = found.zip(parts.get(&template.name)) else {
                continue;
            };
            let is_one_of_several = place.templates.len() > 1;
            for &position in &parts.strengths {
                strengths.push(Variable::Parameter(effect.parameters[position]));
                let own = &template.parameters[position].name;
                let name = match (is_one_of_several, parts.strengths.len()) {
                    (true, 1) => template.name.clone(),
                    (true, _) => format!("{}.{own}", template.name),
                    (false, _) => own.clone(),
                };
                coefficients.push(self.coefficient(effect, (position, own), name));
            }
            let speeds = parts.shapes.iter().filter_map(|&position| {
                let own = &template.parameters[position].name;
                self.speed(effect, (position, own), *places.first()?)
            });
            shapes.extend(speeds);
        }
        Group {
            term: place.term.to_string(),
            on: place.on.clone(),
            columns: begin..begin + coefficients.len(),
            coefficients,
            shapes,
            places,
            load: None,
        }
    }

    fn coefficient(
        &self,
        effect: &Effect,
        (position, own): (usize, &str),
        name: String,
    ) -> Coefficient {
        let index = effect.parameters[position];
        let parameter = &self.extended.parameters[index];
        Coefficient {
            name,
            effect: effect.template.clone(),
            parameter: own.to_string(),
            stated: self.values[index],
            holder: self.is_given(index).then(|| parameter.name.clone()),
            default: parameter.default,
            lower: parameter.lower,
            unit: parameter.unit.clone(),
        }
    }

    /// The parameters of the given model come first in the extended one.
    fn is_given(&self, index: usize) -> bool {
        index < self.given.parameters.len()
    }

    /// A shape that is a speed of the coordinate that its effect acts on.
    fn speed(
        &self,
        effect: &Effect,
        (position, own): (usize, &str),
        coordinate: usize,
    ) -> Option<Shape> {
        let index = effect.parameters[position];
        let parameter = &self.extended.parameters[index];
        let rate = self.given.coordinates[coordinate].dimension?.rate();
        let is_speed = parameter.dimension == Some(rate) && parameter.lower > 0.0;
        is_speed.then(|| Shape {
            effect: effect.template.clone(),
            parameter: own.to_string(),
            index,
            stated: self.is_given(index).then_some(self.values[index]),
            bounds: (parameter.lower, parameter.upper),
        })
    }

    fn load(&self, place: &Place<'_>, mass: PointMass, bodies: &[String]) -> Option<Group> {
        let template = place.templates[0];
        let given = effect(self.given, &template.name, &place.on);
        let mut all = self.extended.effects.iter();
        let any = given.or_else(|| all.find(|e| e.template == template.name))?;
        let order = [mass.mass, mass.place[0], mass.place[1], mass.place[2]];
        let coefficient = |position: usize| {
            let own = &template.parameters[position].name;
            let mut coefficient = self.coefficient(any, (position, own), own.clone());
            if given.is_none() {
                (coefficient.stated, coefficient.holder) = (0.0, None);
            }
            coefficient
        };
        let coefficients = order.map(coefficient);
        let stated = coefficients.each_ref().map(|c| c.stated);
        let bounds = mass.place.map(|position| {
            let parameter = &self.extended.parameters[any.parameters[position]];
            (parameter.lower, parameter.upper)
        });
        Some(Group {
            term: place.term.to_string(),
            on: place.on.clone(),
            coefficients: coefficients.to_vec(),
            shapes: Vec::new(),
            columns: columns_of_body(bodies, &place.on)?,
            places: Vec::new(),
            load: Some(Load {
                carried: given.map(|_| Point {
                    mass: stated[0],
                    at: [stated[1], stated[2], stated[3]],
                }),
                bounds,
            }),
        })
    }
}
