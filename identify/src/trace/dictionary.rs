//! Everything that might be missing: effects of the library at every place, and
//! every parameter of the model.
//!
//! The candidates are written into a copy of the model as plain text and the
//! whole is compiled once: with its parameters at their defaults an effect does
//! nothing, so the copy moves as the model does, and its derivatives by the
//! candidates' parameters are the columns of the regression.

use super::candidate::Candidate;
use super::described::limited_losses;
use super::focus::Focuses;
use super::nested::Nested;
use super::places::{Place, places};
use super::roles::{Role, Roles};
use super::subject::Subject;
use super::waves::Missing;
use crate::machine::{Instruments, Machine, SensitivityTape, Sensors};
use dynamics_codegen::derive::Variable;
use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::model::{Model, Parameter};
use dynamics_codegen::syntax::{PortKind, written_name};
use dynamics_codegen::{Compiled, Library, Report, compile};
use std::collections::BTreeMap;

/// The model that something may be missing in.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// What messages call it.
    pub name: &'a str,
    /// Its text.
    pub text: &'a str,
    /// The effects that may be missing.
    pub library: &'a Library,
    /// Values that replace nominal ones of its own parameters.
    pub parameters: &'a BTreeMap<String, f64>,
}

impl Source<'_> {
    /// The model as given.
    ///
    /// # Errors
    /// What the compiler says.
    pub fn compile(&self) -> Result<Compiled, Report> {
        compile(self.name, self.text, self.library)
    }

    /// The nominal parameters of a machine of this model, with the values that replace them.
    pub fn values(&self, machine: &Machine) -> Vec<f64> {
        let mut values = machine.nominal_parameters();
        for (value, parameter) in values.iter_mut().zip(&machine.compiled.model.parameters) {
            if let Some(&given) = self.parameters.get(&parameter.name) {
                *value = given;
            }
        }
        values
    }
}

/// The extended model and its candidates.
#[derive(Debug)]
pub struct Dictionary {
    /// The model with all candidates in it.
    pub machine: Machine,
    /// Derivatives by every parameter.
    pub by_parameter: SensitivityTape,
    /// What sensors read, with derivatives by every parameter.
    pub sensors: Sensors,
    /// What the model's own sensors show, with derivatives by every parameter.
    pub instruments: Instruments,
    /// All candidates.
    pub candidates: Vec<Candidate>,
    /// Per further shape, counted from one: the candidates that come in it.
    pub by_shape: Vec<Shape>,
    /// Default values of all parameters.
    pub defaults: Vec<f64>,
    /// Which candidates are one law.
    pub nested: Nested,
    /// Models with some of the candidates.
    pub(super) focuses: Focuses,
    /// The parameters that count waves, with the coordinate along which they do.
    wave_numbers: BTreeMap<usize, usize>,
}

/// The candidates that come in a further shape.
#[derive(Debug)]
pub struct Shape {
    /// Their strengths.
    pub strengths: Vec<usize>,
    /// Derivatives by them.
    pub slopes: SensitivityTape,
    /// What the model's own sensors show, with derivatives by the same.
    pub instruments: Instruments,
}

/// Where a log goes.
#[derive(Debug, Clone)]
pub struct Ranges {
    /// Per coordinate its positions, ascending.
    pub positions: Vec<Vec<f64>>,
    /// Per coordinate the root mean square of its velocity.
    pub speeds: Vec<f64>,
    /// Per coordinate, whether a column shows its position.
    pub measured: Vec<bool>,
    /// Per input its sizes, ascending.
    pub inputs: Vec<Vec<f64>>,
    /// The model's sensors that the log has.
    pub sensors: Vec<String>,
    /// Per coordinate the force that the model lacks along it, where that is known.
    pub missing: Vec<Missing>,
}

/// Characteristic speeds of effects, as shares of the usual speed: the slowest and the
/// fastest to try.
const SPEEDS: (f64, f64) = (0.01, 1.5);

/// How many wave numbers are tried that the missing force shows.
const WAVES: usize = 3;

/// A lone shape parameter is tried at this many values, each of several at fewer.
const SHAPE_VALUES: [usize; 2] = [5, 3];

impl Dictionary {
    /// A candidate's parameters as its template calls them.
    pub fn short_names(&self, candidate: usize) -> Vec<&str> {
        let Candidate {
            subject,
            parameters,
            ..
        } = &self.candidates[candidate];
        let prefix = subject.prefix();
        let whole = |&index: &usize| &self.machine.compiled.model.parameters[index].name;
        let short =
            |name: &'_ String| name.len() - name.strip_prefix(&prefix).unwrap_or(name).len();
        parameters
            .iter()
            .map(|index| {
                let name = whole(index);
                &name[short(name)..]
            })
            .collect()
    }

    /// Writes every effect of the source's library at every place into its text and compiles it;
    /// `ranges` says where the log goes.
    ///
    /// # Errors
    /// What the compiler says; the text itself is known to compile.
    pub fn new(source: &Source<'_>, ranges: &Ranges) -> Result<Self, Report> {
        let plain = source.compile()?;
        let places = places(&plain.model, source.library, &ranges.sensors);
        Self::with(&plain, places, source, ranges)
    }

    /// The same with the model's own parameters alone.
    ///
    /// # Errors
    /// As of [`Self::new`].
    pub fn of_parameters(source: &Source<'_>, ranges: &Ranges) -> Result<Self, Report> {
        Self::with(&source.compile()?, Vec::new(), source, ranges)
    }

    fn with(
        plain: &Compiled,
        places: Vec<Place>,
        source: &Source<'_>,
        ranges: &Ranges,
    ) -> Result<Self, Report> {
        let mut extended = source.text.to_string();
        for Place { template, on, .. } in &places {
            let on: Vec<String> = on.iter().map(|name| written_name(name)).collect();
            extended.push_str(&format!("\neffect {template}({});", on.join(", ")));
        }
        let compiled = compile(source.name, &extended, source.library)?;
        let mut machine = Machine::new(compiled);
        let wave_numbers = wave_numbers(&machine.compiled);
        limit_waves(&mut machine.compiled.model, &wave_numbers, ranges);
        let defaults = source.values(&machine);
        let losses = limited_losses(&mut machine.compiled.model, &defaults);
        let all: Vec<Variable> = (0..defaults.len()).map(Variable::Parameter).collect();
        let by_parameter = machine.sensitivity(&all);
        let sensors = machine.sensors(&all);
        let instruments = machine.instruments(&all);
        let own = plain.model.parameters.len();
        let mut candidates: Vec<Candidate> = (0..own)
            .map(|index| Candidate {
                strengths: vec![index],
                is_loss: losses.contains(&index),
                ..Candidate::new(
                    Subject::Parameter(plain.model.parameters[index].name.clone()),
                    vec![index],
                )
            })
            .collect();
        let coordinates = &plain.model.coordinates;
        let unmeasured = |name: &String| {
            let pairs = coordinates.iter().zip(&ranges.measured);
            pairs
                .filter(|(c, _)| c.name == *name)
                .any(|(_, measured)| !measured)
        };
        let added = &machine.compiled.model.effects[plain.model.effects.len()..];
        for (effect, place) in added.iter().zip(places) {
            let senses = effect
                .parameters
                .iter()
                .any(|p| sensors.sensing.contains(p));
            // A sensor that is not there reads nothing wrong.
            if senses && effect.on.iter().any(|(_, name)| unmeasured(name)) {
                continue;
            }
            let Place {
                template,
                on,
                same_on,
            } = place;
            let subject = Subject::Effect { template, on };
            candidates.push(Candidate {
                channel: senses || effect.on.iter().any(|(kind, _)| is_channel(*kind)),
                same_on,
                ..Candidate::new(subject, effect.parameters.clone())
            });
        }
        let mut dictionary = Self {
            machine,
            focuses: Focuses::new(source),
            by_parameter,
            sensors,
            instruments,
            candidates,
            by_shape: Vec::new(),
            defaults,
            nested: Nested::default(),
            wave_numbers,
        };
        dictionary.find_shapes(ranges);
        dictionary.nested = Nested::new(&dictionary, ranges);
        Ok(dictionary)
    }

    /// All parameters of some candidates, in their order.
    pub fn parameters_of(&self, candidates: &[usize]) -> Vec<usize> {
        let each = candidates.iter().map(|&c| &self.candidates[c].parameters);
        each.flatten().copied().collect()
    }

    /// Bends a linear step of all parameters of some candidates, or of none, from `values`, see [`Candidate::bend`].
    pub fn bend(&self, candidates: &[usize], values: &[f64], mut step: &mut [f64]) {
        for &candidate in candidates {
            let candidate = &self.candidates[candidate];
            let Some((own, others)) = step.split_at_mut_checked(candidate.size()) else {
                return;
            };
            candidate.bend(own, values, &self.defaults);
            step = others;
        }
    }

    /// What is believed of some parameters, seen from `values` of all: the place of each of which
    /// anything is, by how much its mean lies above its value, and the standard deviation.
    pub fn beliefs(&self, parameters: &[usize], values: &[f64]) -> Vec<(usize, f64, f64)> {
        let model = &self.machine.compiled.model;
        let of = |(place, &index): (usize, &usize)| {
            let belief = model.parameters[index].belief?;
            Some((place, belief.mean - values[index], belief.sd))
        };
        parameters.iter().enumerate().filter_map(of).collect()
    }

    /// Values with the parameters of some candidates back where these do nothing.
    pub fn without(&self, candidates: &[usize], values: &[f64]) -> Vec<f64> {
        let mut values = values.to_vec();
        for parameter in self.parameters_of(candidates) {
            values[parameter] = self.defaults[parameter];
        }
        values
    }

    /// Tells strengths from shapes: at its defaults an effect does nothing, so the
    /// derivative by a shape parameter is identically zero there. Where it is so
    /// everywhere, as by an offset out of the plane of a planar machine, the parameter is
    /// nothing to be found.
    fn find_shapes(&mut self, ranges: &Ranges) {
        let roles = self.roles(&ranges.sensors);
        let mut candidates = std::mem::take(&mut self.candidates);
        for candidate in &mut candidates {
            if let Subject::Parameter(_) = candidate.subject {
                if roles[candidate.parameters[0]] == Role::Inert {
                    candidate.strengths.clear();
                }
                continue;
            }
            let strengths = candidate.parameters.iter();
            let has_strength = strengths.clone().any(|&p| roles[p] == Role::Strength);
            let is_tilt = |index: usize| {
                let unit = self.machine.compiled.model.parameters[index].dimension;
                roles[index] == Role::Curved && unit == Some(Dimension::ONE)
            };
            // An angle beside others that does nothing to first order turns what it turns out of
            // the plane of a planar machine: its cosine is nobody's finding.
            candidate
                .parameters
                .retain(|&index| roles[index] != Role::Inert && !(has_strength && is_tilt(index)));
            let inactive = candidate
                .parameters
                .iter()
                .filter(|&&index| roles[index] == Role::Shape)
                .count();
            let count = SHAPE_VALUES[usize::from(inactive > 1)];
            candidate.strengths = candidate
                .parameters
                .iter()
                .copied()
                .filter(|&index| roles[index] == Role::Strength)
                .collect();
            let mut shapes: Vec<Vec<(usize, f64)>> = vec![Vec::new()];
            let of_shape = |&&index: &&usize| roles[index] == Role::Shape;
            for &index in candidate.parameters.iter().filter(of_shape) {
                shapes = shapes
                    .iter()
                    .flat_map(|shape| {
                        self.shape_values(index, count, ranges)
                            .into_iter()
                            .map(move |value| {
                                let mut longer = shape.clone();
                                longer.push((index, value));
                                longer
                            })
                    })
                    .collect();
            }
            candidate.shapes = shapes;
        }
        self.candidates = candidates;
        let most = self
            .candidates
            .iter()
            .map(|c| c.shapes.len())
            .max()
            .unwrap_or(1);
        self.by_shape = (1..most)
            .map(|shape| {
                let strengths: Vec<usize> = self.strengths_with_shape(shape).collect();
                let variables: Vec<Variable> =
                    strengths.iter().copied().map(Variable::Parameter).collect();
                Shape {
                    slopes: self.machine.sensitivity(&variables),
                    instruments: self.machine.instruments(&variables),
                    strengths,
                }
            })
            .collect();
        // Where nothing else is said, an effect has its first shape.
        for (index, value) in self.candidates.iter().flat_map(|c| c.shapes[0].clone()) {
            self.defaults[index] = value;
        }
    }

    /// Strengths of the candidates that come in more than `shape` shapes.
    fn strengths_with_shape(&self, shape: usize) -> impl Iterator<Item = usize> + '_ {
        let with = self
            .candidates
            .iter()
            .filter(move |c| c.shapes.len() > shape);
        with.flat_map(|c| c.strengths.iter().copied())
    }

    /// What each parameter does when it leaves its default, as a log with these of the model's
    /// sensors shows it.
    fn roles(&self, sensors: &[String]) -> Vec<Role> {
        let compiled = &self.machine.compiled;
        let seen = |sensor: usize| sensors.contains(&compiled.model.sensors[sensor].name);
        let mut known = Roles::new(compiled, &self.defaults, seen);
        let mut roles = vec![Role::Inert; self.defaults.len()];
        for candidate in &self.candidates {
            let own = known.of(&candidate.parameters);
            let pairs = candidate.parameters.iter().zip(own);
            pairs.for_each(|(&index, role)| roles[index] = role);
        }
        roles
    }

    /// Wave numbers that the missing force shows, if a shape parameter is one.
    fn waves(&self, index: usize, ranges: &Ranges) -> Vec<f64> {
        let parameter = &self.machine.compiled.model.parameters[index];
        let coordinate = self.wave_numbers.get(&index);
        let missing = coordinate.and_then(|&c| ranges.missing.get(c));
        let waves = missing.map(|missing| missing.waves(parameter.upper, WAVES));
        let waves = waves.unwrap_or_default().into_iter();
        waves.filter(|&n| n > parameter.lower).collect()
    }

    /// Where to look for the value of a shape parameter.
    fn shape_values(&self, index: usize, count: usize, ranges: &Ranges) -> Vec<f64> {
        let model = &self.machine.compiled.model;
        let parameter = &model.parameters[index];
        let (lower, upper) = (parameter.lower, parameter.upper);
        let count = parameter.tries.unwrap_or(count);
        if count == 1 {
            return vec![parameter.nominal];
        }
        let steps = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (0..count)
                .map(|i| f((i as f64 + 0.5) / count as f64))
                .collect()
        };
        // A speed of the coordinate it acts on: shares of its usual speed.
        let moves = parameter.effect.and_then(|effect| {
            let (_, name) = model.effects[effect].on.first()?;
            model.coordinates.iter().position(|c| {
                c.name == *name
                    && c.dimension.is_some()
                    && c.dimension.map(|d| d.rate()) == parameter.dimension
            })
        });
        if let (Some(coordinate), true) = (moves, lower > 0.0) {
            let usual = ranges.speeds[coordinate];
            let (slow, fast) = SPEEDS;
            return steps(&|share| (usual * slow * (fast / slow).powf(share)).clamp(lower, upper));
        }
        if lower > 0.0 && upper.is_finite() && !self.wave_numbers.contains_key(&index) {
            return steps(&|share| lower * (upper / lower).powf(share));
        }
        if lower.is_finite() && upper.is_finite() {
            let mut values = steps(&|share| lower + share * (upper - lower));
            values.extend(self.waves(index, ranges));
            return values;
        }
        // In the unit of the coordinate it acts on: somewhere along the log.
        let place = parameter.effect.and_then(|effect| {
            let (kind, name) = model.effects[effect].on.first()?;
            let same = |unit: Option<Dimension>| unit == parameter.dimension;
            let mut coordinates = model.coordinates.iter();
            let mut inputs = model.inputs.iter();
            match kind {
                PortKind::Input => inputs
                    .position(|u| u.name == *name && same(u.dimension))
                    .map(|input| model.coordinates.len() + input),
                _ => coordinates.position(|c| c.name == *name && same(c.dimension)),
            }
        });
        match place {
            Some(place) => {
                let positions = ranges.positions.len();
                let sorted = match place.checked_sub(positions) {
                    None => &ranges.positions[place],
                    Some(input) => &ranges.inputs[input],
                };
                steps(&|share| {
                    let there = sorted[((sorted.len() - 1) as f64 * share) as usize];
                    there.clamp(lower, upper)
                })
            }
            None => vec![parameter.nominal],
        }
    }
}

/// Whether what acts there is about a channel: an input or a sensor.
fn is_channel(kind: PortKind) -> bool {
    matches!(kind, PortKind::Input | PortKind::Sensor | PortKind::Frame)
}

/// The parameters that may count waves per unit of the coordinate that their effect acts on, to be searched
/// for: what they do depends on where the coordinate is, and their unit is one over its own. An angle
/// has none, so that the unit alone does not tell a wave number from a share.
fn wave_numbers(compiled: &Compiled) -> BTreeMap<usize, usize> {
    let model = &compiled.model;
    let nominal: Vec<f64> = model.parameters.iter().map(|p| p.nominal).collect();
    let mut roles = Roles::new(compiled, &nominal, |_| false);
    let coordinate = |parameter: &Parameter| {
        parameter.tries?;
        let (_, name) = model.effects[parameter.effect?].on.first()?;
        let coordinate = model.coordinates.iter().position(|c| c.name == *name)?;
        let unit = model.coordinates[coordinate].dimension?;
        (parameter.dimension == Some(Dimension::ONE / unit)).then_some(coordinate)
    };
    let parameters = model.parameters.iter().enumerate();
    let of_unit = parameters.filter_map(|(index, p)| Some((index, coordinate(p)?)));
    let waves = of_unit.filter(|&(index, coordinate)| {
        roles.acts_by_place(index, model.coordinates[coordinate].position)
    });
    waves.collect()
}

/// A wave is one if it comes back along the log. What does not is whatever a part of a wave looks
/// like: a spring, or a constant force.
fn limit_waves(model: &mut Model, wave_numbers: &BTreeMap<usize, usize>, ranges: &Ranges) {
    for (&index, &coordinate) in wave_numbers {
        let positions = &ranges.positions[coordinate];
        if let Some((least, most)) = positions.first().zip(positions.last()) {
            let parameter = &mut model.parameters[index];
            let longest = (std::f64::consts::TAU / (most - least)).min(parameter.upper);
            parameter.lower = parameter.lower.max(longest);
            parameter.nominal = parameter.nominal.max(longest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::States;

    /// A link whose mass lies on the joint's axis: its inertia about the axis grows with the
    /// square of what its centre leaves it by, so that no slope at the default shows it.
    const ON_THE_AXIS: &str = "model on_the_axis;
        coordinate a: rad; coordinate b: rad;
        input a: N*m; input b: N*m;
        constant l: m = 0.4;
        body upright { frame: rotate_z(a); mass: 3; inertia: diag(0.1, 0.1, 0.1); }
        body out { frame: rotate_z(a)*translate(l, 0, 0)*rotate_y(b); mass: 1; center: (0.2, 0, 0);
                   inertia: diag(0.01, 0.02, 0.02); }
        gravity (0, 0, -9.81);
        force a = input(a); force b = input(b);";

    fn dictionary() -> Dictionary {
        let ranges = Ranges {
            positions: vec![vec![-1.0, 0.0, 1.0]; 2],
            speeds: vec![1.0; 2],
            inputs: vec![vec![0.0, 1.0, 2.0]; 2],
            measured: vec![true; 2],
            sensors: Vec::new(),
            missing: Vec::new(),
        };
        let (library, none) = (Library::builtin(), BTreeMap::new());
        let source = Source {
            name: "on_the_axis",
            text: ON_THE_AXIS,
            library: &library,
            parameters: &none,
        };
        Dictionary::new(&source, &ranges).unwrap()
    }

    /// A load where the template's default puts it, at the link's axis, does nothing to first
    /// order; its mass is a strength all the same, and where it is its shape.
    #[test]
    fn a_load_on_the_first_link_has_a_strength() {
        let dictionary = dictionary();
        for body in ["upright", "out"] {
            let subject = Subject::Effect {
                template: "payload".to_string(),
                on: vec![body.to_string()],
            };
            let mut all = dictionary.candidates.iter();
            let load = all.position(|c| c.subject == subject).unwrap();
            let names = dictionary.short_names(load);
            let load = &dictionary.candidates[load];
            let mass = names.iter().position(|&name| name == "m").unwrap();
            assert_eq!(load.strengths, [load.parameters[mass]], "{body}: {names:?}");
            assert!(load.shapes.len() > 1);
        }
    }

    /// How much friction rises towards standstill has the unit of a wave number of an angle: none.
    #[test]
    fn a_share_counts_no_waves() {
        let dictionary = dictionary();
        let model = &dictionary.machine.compiled.model;
        let named = |index: &usize| model.parameters[*index].name.as_str();
        let waves: Vec<&str> = dictionary.wave_numbers.keys().map(named).collect();
        assert_eq!(waves, ["cogging_a_n", "cogging_b_n"]);
        let rise = model.parameters.iter().find(|p| p.name == "lugre_a_rise");
        assert_eq!(rise.map(|p| p.lower), Some(0.0));
    }

    #[test]
    fn candidates_do_nothing_at_their_defaults() {
        let dictionary = dictionary();
        let states = States {
            t: vec![0.0],
            q: vec![vec![0.3], vec![-0.8]],
            v: vec![vec![1.1], vec![-0.7]],
            u: vec![vec![2.0], vec![-1.0]],
            ..States::default()
        };
        let extended = &dictionary
            .machine
            .motion(&states, &dictionary.defaults)
            .unwrap()[0];
        let focus = dictionary.focus(&[]);
        let plain = focus.values(&dictionary.defaults);
        let plain = &focus.machine.motion(&states, &plain).unwrap()[0];
        let apart = &extended.terms.mass_matrix - &plain.terms.mass_matrix;
        assert!(apart.amax() < 1e-12, "{apart}");
        assert!((&extended.acceleration - &plain.acceleration).amax() < 1e-10);
    }
}
