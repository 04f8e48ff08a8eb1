//! What candidates say about channels: inputs and sensors, and their times.

use crate::trace::dictionary::Dictionary;
use crate::trace::remembered::remembers;
use dynamics_codegen::dimension::Dimension;
use dynamics_codegen::syntax::PortKind;

/// The places of a candidate that is about channels, and the unit of its only parameter.
pub fn number_of_channel(
    dictionary: &Dictionary,
    candidate: usize,
) -> Option<(&[(PortKind, String)], Dimension)> {
    let candidate = &dictionary.candidates[candidate];
    let model = &dictionary.machine.compiled.model;
    let [only] = candidate.parameters[..] else {
        return None;
    };
    let parameter = &model.parameters[only];
    let places = &model.effects[parameter.effect?].on[..];
    let is_channel = candidate.channel && !places.is_empty();
    Some((places, parameter.dimension?)).filter(|_| is_channel)
}

/// The coordinate whose sensor a candidate says the time of.
pub fn timed_sensor(dictionary: &Dictionary, candidate: usize) -> Option<usize> {
    let (places, unit) = number_of_channel(dictionary, candidate)?;
    let [place] = places else { return None };
    let mut coordinates = dictionary.machine.compiled.model.coordinates.iter();
    let coordinate = coordinates.position(|c| c.name == place.1);
    coordinate.filter(|_| place.0 == PortKind::Coordinate && unit == Dimension::TIME)
}

/// The parameter by which a candidate says how late inputs are.
pub fn timed_input(dictionary: &Dictionary, candidate: usize) -> Option<usize> {
    let (places, unit) = number_of_channel(dictionary, candidate)?;
    let are_inputs = places.iter().all(|(kind, _)| *kind == PortKind::Input);
    let is_time = are_inputs && unit == Dimension::TIME;
    is_time.then(|| dictionary.candidates[candidate].parameters[0])
}

/// The parameter by which a candidate says how late all inputs are at once.
pub fn clock_of_inputs(dictionary: &Dictionary, candidate: usize) -> Option<usize> {
    let (places, _) = number_of_channel(dictionary, candidate)?;
    let all = dictionary.machine.compiled.model.inputs.len();
    timed_input(dictionary, candidate).filter(|_| places.len() == all)
}

/// The same where they do nothing but come later: what lags has a state.
pub fn delay_of_inputs(dictionary: &Dictionary, candidate: usize) -> Option<usize> {
    clock_of_inputs(dictionary, candidate).filter(|_| !remembers(dictionary, candidate))
}

/// Whether the only parameter of a candidate is a time.
pub fn is_time(dictionary: &Dictionary, candidate: usize) -> bool {
    let parameters = &dictionary.machine.compiled.model.parameters;
    match dictionary.candidates[candidate].parameters[..] {
        [only] => parameters[only].dimension == Some(Dimension::TIME),
        _ => false,
    }
}

/// Whether an input drives a coordinate in the model as given.
pub fn drives(dictionary: &Dictionary, input: &str, coordinate: &str) -> bool {
    let given = dictionary.focus(&[]);
    let model = &given.machine.compiled.model;
    let row = model.coordinates.iter().position(|c| c.name == coordinate);
    let column = model.inputs.iter().position(|u| u.name == input);
    let matrix = &given.machine.compiled.system.input_matrix;
    row.zip(column)
        .is_some_and(|(row, column)| !model.graph.is_zero(matrix[row][column]))
}
