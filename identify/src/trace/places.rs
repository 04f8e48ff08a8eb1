//! Where each effect of a library could act in a model.

use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::model::Template;
use dynamics_codegen::syntax::PortKind;
use dynamics_codegen::{Library, Model};

/// A template at a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Place {
    /// The template's name.
    pub template: String,
    /// What it acts on.
    pub on: Vec<String>,
    /// Bodies on which it would be the same law.
    pub same_on: Vec<String>,
}

impl Place {
    fn new(template: &Template, on: Vec<String>) -> Self {
        Self {
            template: template.name.clone(),
            on,
            same_on: Vec::new(),
        }
    }
}

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

/// Every template at every place that fits, but those the model already has; `sensors` are those that
/// a log has.
pub(super) fn places(model: &Model, library: &Library, sensors: &[String]) -> Vec<Place> {
    let templates = library.names().filter_map(|name| library.describe(name));
    let driven = driven(model);
    let each = templates.flat_map(|template| {
        if template.point_mass.is_some() {
            return loads(model, &template);
        }
        let mut alone = places_of(model, &template.ports, sensors);
        if template.term.as_ref().is_some_and(|term| term.neighbours) {
            alone.retain(|on| on.iter().all(|name| driven.contains(&name.as_str())));
        }
        let alone = alone.into_iter();
        let places = alone.chain(all_at_once(model, &template, sensors));
        places.map(|on| Place::new(&template, on)).collect()
    });
    let is_new = |place: &Place| {
        let mut effects = model.effects.iter();
        !effects.any(|effect| {
            effect.template == place.template
                && effect.on.iter().map(|(_, name)| name).eq(&place.on)
        })
    };
    each.filter(is_new).collect()
}

/// The coordinates that inputs drive: others have no part in a drive that two share.
fn driven(model: &Model) -> Vec<&str> {
    let mut graph = model.graph.clone();
    let inputs = model.inputs.iter();
    let each: Vec<_> = inputs
        .map(|input| graph.derivatives(&model.forces, input.symbol))
        .collect();
    let is_driven = |row: usize| each.iter().any(|ratios| !graph.is_zero(ratios[row]));
    let coordinates = model.coordinates.iter().enumerate();
    coordinates
        .filter(|(row, _)| is_driven(*row))
        .map(|(_, coordinate)| coordinate.name.as_str())
        .collect()
}

/// A point mass on every group of rigidly connected bodies that the model has none on.
fn loads(model: &Model, template: &Template) -> Vec<Place> {
    let loads = model.effects.iter().filter(|e| e.template == template.name);
    let mut groups = carriers(model);
    groups.retain(|group| {
        let is_on = |(_, body): &(PortKind, String)| group.contains(body);
        !loads.clone().any(|load| load.on.iter().any(is_on))
    });
    let place = |mut group: Vec<String>| {
        let same_on = group.split_off(1);
        Place {
            same_on,
            ..Place::new(template, group)
        }
    };
    groups.into_iter().map(place).collect()
}

/// The groups of rigidly connected bodies that move, each with its heaviest body first: a load on one body of a group is
/// the same law on any other. In the model's order of the heaviest.
pub(crate) fn carriers(model: &Model) -> Vec<Vec<String>> {
    let masses = model.masses();
    let mut groups: Vec<(usize, Vec<usize>)> = Vec::new();
    for (index, body) in model.bodies.iter().enumerate() {
        let Some(moved_with) = model.moved_with(body) else {
            continue;
        };
        match groups.iter_mut().find(|(joint, _)| *joint == moved_with) {
            Some((_, group)) => group.push(index),
            None => groups.push((moved_with, vec![index])),
        }
    }
    let mut groups: Vec<Vec<usize>> = groups.into_iter().map(|(_, group)| group).collect();
    for group in &mut groups {
        group.sort_by(|&a, &b| masses[b].total_cmp(&masses[a]));
    }
    groups.sort_unstable();
    let names = |group: Vec<usize>| {
        let names = group.iter().map(|&index| model.bodies[index].name.clone());
        names.collect()
    };
    groups.into_iter().map(names).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics_codegen::compile;

    /// A wrist with a hand on it, whose flange has no mass, and a finger that slides.
    const HAND: &str = r#"<robot name="hand">
  <link name="base"><inertial><mass value="9"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="wrist"><inertial><mass value="0.5"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <link name="flange"/>
  <link name="palm"><inertial><mass value="0.7"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <link name="finger"><inertial><mass value="0.1"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="wrist"/>
    <axis xyz="0 1 0"/></joint>
  <joint name="bolts" type="fixed"><parent link="wrist"/><child link="flange"/></joint>
  <joint name="more_bolts" type="fixed"><parent link="flange"/><child link="palm"/></joint>
  <joint name="slide" type="prismatic"><parent link="palm"/><child link="finger"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.1" effort="9" velocity="9"/></joint>
</robot>"#;

    #[test]
    fn a_load_is_tried_once_on_what_is_rigidly_connected() {
        let mut library = Library::builtin();
        library.add_file("hand.urdf", "hand.urdf", HAND);
        let loads = |text: &str| -> Vec<[Vec<String>; 2]> {
            let model = compile("hand.model", text, &library).unwrap().model;
            let all = places(&model, &library, &[]).into_iter();
            let loads = all.filter(|place| place.template == "payload");
            loads.map(|place| [place.on, place.same_on]).collect()
        };
        let model = "model hand; urdf \"hand.urdf\" { base: fixed; }";
        let [palm, finger] = &loads(model)[..] else {
            panic!("the hand and the finger");
        };
        assert_eq!(palm[0], ["palm"]);
        assert_eq!(palm[1], ["wrist", "flange"]);
        assert_eq!(finger, &[vec!["finger".to_string()], Vec::new()]);
        // A load that is there may have another mass; there is no second one beside it.
        let loaded = format!("{model} effect payload(wrist) {{ m = 0.2 }}");
        assert_eq!(loads(&loaded), std::slice::from_ref(finger));
        let locked = "model hand; urdf \"hand.urdf\" { base: fixed; lock: slide; }";
        assert_eq!(loads(locked)[0][1], ["wrist", "finger", "flange"]);
    }

    /// Of a double pendulum nothing couples joints that hang free, and no drive is shared with one of these.
    #[test]
    fn joints_share_a_drive_where_inputs_drive_both() {
        let library = Library::builtin();
        let couplings = |forces: &str| -> usize {
            let text = format!(
                "model two; coordinate a: rad; coordinate b: rad; input u: N*m; input w: N*m;
                 parameter i: kg*m^2 = 1 in 0..;
                 kinetic i/2*dot(a)^2 + i/2*(dot(a) + dot(b))^2; {forces}"
            );
            let model = compile("two.model", &text, &library).unwrap().model;
            let all = places(&model, &library, &[]).into_iter();
            all.filter(|place| place.template == "joint_coupling")
                .count()
        };
        assert_eq!(couplings("force a = input(u); force b = input(w);"), 1);
        assert_eq!(couplings("force a = input(u) + input(w);"), 0);
    }
}
