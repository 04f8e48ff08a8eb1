//! How far effects reach in a machine.

use crate::trace::candidate::Candidate;
use crate::trace::dictionary::Dictionary;

/// How many kinds of reach there are.
pub(super) const REACHES: usize = 3;

/// How far each candidate reaches: none in one coordinate's drive (the force does not depend
/// on positions), one in what two coordinates share, two in the machine's structure.
pub(super) fn reaches(dictionary: &Dictionary) -> Vec<usize> {
    let compiled = &dictionary.machine.compiled;
    let mut model = compiled.model.clone();
    let mut outputs = compiled.system.force.clone();
    outputs.extend(compiled.system.mass_matrix.iter().flatten());
    let positions: Vec<_> = model.coordinates.iter().map(|c| c.position).collect();
    let of = |candidate: &Candidate| {
        let mut in_positions = false;
        for &parameter in &candidate.strengths {
            let symbol = model.parameters[parameter].symbol;
            let seeds = model.parameter_seeds(symbol);
            let slopes = model.graph.directional(&outputs, &seeds);
            let depends = |&slope| {
                positions
                    .iter()
                    .any(|&q| model.graph.depends_on(&[slope], q))
            };
            in_positions |= slopes.iter().any(depends);
        }
        if in_positions {
            REACHES - 1
        } else {
            usize::from(candidate.subject.on().len() != 1)
        }
    };
    dictionary.candidates.iter().map(of).collect()
}
