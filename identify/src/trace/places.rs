//! Where each effect of a library could act in a model.

use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::model::Template;
use dynamics_codegen::syntax::PortKind;
use dynamics_codegen::{Library, Model};

/// A template's name and what it acts on.
pub(super) type Place = (String, Vec<String>);

/// Whether two coordinates have one unit: only then can they share a drive.
fn alike(model: &Model, a: &str, b: &str) -> bool {
    let unit = |name: &str| {
        let mut coordinates = model.coordinates.iter();
        coordinates.find(|c| c.name == name).map(|c| c.dimension)
    };
    unit(a) == unit(b)
}

/// The coordinates of a point that moves: all in metres, if there are two or three.
fn axes(model: &Model) -> Vec<String> {
    let metres = model
        .coordinates
        .iter()
        .filter(|c| c.dimension == Dimension::of_unit("m"));
    let axes: Vec<String> = metres.map(|c| c.name.clone()).collect();
    if (2..=3).contains(&axes.len()) {
        axes
    } else {
        Vec::new()
    }
}

/// Every template at every place that fits, but those the model already has; `sensors` are those
/// that a log has.
pub(super) fn places(model: &Model, library: &Library, sensors: &[String]) -> Vec<Place> {
    let templates = library.names().filter_map(|name| library.describe(name));
    let each = templates.flat_map(|template| {
        let alone = places_of(model, &template.ports, sensors).into_iter();
        let places = alone.chain(all_at_once(model, &template, sensors));
        places.map(move |on| (template.name.clone(), on))
    });
    let is_new = |(template, on): &Place| {
        let mut effects = model.effects.iter();
        !effects.any(|effect| {
            effect.template == *template && effect.on.iter().map(|(_, name)| name).eq(on.iter())
        })
    };
    each.filter(is_new).collect()
}

/// All places of a template that may be applied to each of several, where there are several.
fn all_at_once(model: &Model, template: &Template, sensors: &[String]) -> Option<Vec<String>> {
    let each = template.each?;
    let kind = template.ports[0];
    let all = names(model, kind, sensors);
    let is_of_one_unit = |two: &[String]| match kind {
        PortKind::Input => {
            let mut inputs = model.inputs.iter().filter(|u| two.contains(&u.name));
            inputs.next().map(|u| u.dimension) == inputs.next().map(|u| u.dimension)
        }
        _ => alike(model, &two[0], &two[1]),
    };
    let fits = !each.of_one_unit || all.windows(2).all(is_of_one_unit);
    (all.len() > 1 && fits).then_some(all)
}

/// Every place that fits the ports of a template; `sensors` are those that a log has.
pub(crate) fn places_of(model: &Model, ports: &[PortKind], sensors: &[String]) -> Vec<Vec<String>> {
    let mut choices: Vec<Vec<String>> = vec![Vec::new()];
    for (position, kind) in ports.iter().enumerate() {
        if *kind == PortKind::Coordinates {
            let axes = axes(model);
            choices = choices
                .into_iter()
                .filter(|_| !axes.is_empty())
                .map(|chosen| [chosen, axes.clone()].concat())
                .collect();
            continue;
        }
        let again = position > 0 && ports[position - 1] == *kind;
        choices = choices
            .iter()
            .flat_map(|chosen| longer(model, &names(model, *kind, sensors), chosen, again))
            .collect();
    }
    // A template for inputs has no place in a model without any.
    choices.retain(|on| !on.is_empty() || ports.is_empty());
    choices
}

/// The places with one more of a kind, of which these are `all`; `again`, if the last one is of this
/// kind, too.
fn longer(model: &Model, all: &[String], chosen: &[String], again: bool) -> Vec<Vec<String>> {
    // Two ports of one kind: each pair once.
    let last = chosen.last().filter(|_| again);
    let first = last.and_then(|last| all.iter().position(|name| name == last));
    let begin = first.map_or(0, |first| first + 1);
    let others = all.iter().skip(begin);
    others
        .filter(|name| !chosen.contains(name))
        .filter(|name| last.is_none_or(|last| alike(model, last, name)))
        .map(|name| [chosen, std::slice::from_ref(name)].concat())
        .collect()
}

fn names(model: &Model, kind: PortKind, sensors: &[String]) -> Vec<String> {
    let coordinates = || model.coordinates.iter().map(|c| c.name.clone());
    match kind {
        // A component of a quaternion is a choice of numbers: no force has it for a place.
        PortKind::Coordinate => {
            let all = model.coordinates.iter().enumerate();
            let places = all.filter(|(index, _)| !model.is_of_quaternion(*index));
            places.map(|(_, c)| c.name.clone()).collect()
        }
        PortKind::Reading => coordinates().chain(sensors.iter().cloned()).collect(),
        PortKind::Sensor => sensors.to_vec(),
        // A board whose sensors nobody reads is mounted as it is.
        PortKind::Frame if sensors.is_empty() => Vec::new(),
        PortKind::Frame => model.boards.clone(),
        PortKind::Input => model.inputs.iter().map(|u| u.name.clone()).collect(),
        PortKind::Drive => {
            let drives = model.drives().into_iter();
            drives
                .map(|input| model.inputs[input].name.clone())
                .collect()
        }
        PortKind::Body => model.moving_bodies().map(|b| b.name.clone()).collect(),
        PortKind::Constraint => (0..model.constraints.len())
            .filter(|&index| model.sliding(index).is_some())
            .map(|index| model.constraints[index].name.clone())
            .collect(),
        // Chosen all together.
        PortKind::Coordinates => Vec::new(),
    }
}
