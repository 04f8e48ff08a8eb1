//! What the model's sensors show along a curve, and what a departure and columns change of it.

use super::mover::Columns;
use crate::machine::{Factorisation, Instruments, Memory, Motion, States};
use nalgebra::DMatrix;

/// Derivatives of accelerations and multipliers at each of some states.
pub(super) type Derivatives = Vec<(DMatrix<f64>, DMatrix<f64>)>;

/// The readings of `s` sensors at one sample, to first order: `y + H δ + G c`, where
/// `δ = (δq, δv, f)` is the departure with a generalised force that nothing explains.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// `H`, `s×3n`: through accelerations and multipliers, too.
    pub slope: DMatrix<f64>,
    /// `y | G`, `s×(1+p)`.
    pub values: DMatrix<f64>,
}

/// A curve's places, where motion and derivatives are known.
pub(super) struct Places<'a> {
    pub states: &'a States,
    pub motions: &'a [Motion],
    /// By positions and velocities.
    pub slopes: &'a Derivatives,
    /// By the columns of each block, and what its machine remembers.
    pub blocks: &'a [(Derivatives, &'a Memory)],
}

/// What `instruments`, made with derivatives by positions and velocities, show at some places.
pub(super) fn shown(
    instruments: &Instruments,
    parameters: &[f64],
    columns: &[Columns<'_>],
    places: &Places<'_>,
) -> Vec<Shown> {
    let (states, motions) = (places.states, places.motions);
    let pushed = with_forces(places.slopes, motions);
    let slopes = instruments.slopes(states, motions, &pushed, parameters);
    let values = instruments.read(states, motions, parameters);
    let of_block = |(block, (derivatives, memory)): (&Columns<'_>, &(Derivatives, &Memory))| {
        let own = States {
            memory: (*memory).clone(),
            ..states.clone()
        };
        let instruments = block.instruments?;
        Some(instruments.slopes(&own, motions, derivatives, block.parameters))
    };
    let blocks: Vec<_> = columns.iter().zip(places.blocks).map(of_block).collect();
    let at = |(sample, slope): (usize, DMatrix<f64>)| {
        let mut all = DMatrix::from_fn(instruments.count(), 1, |row, _| values[row][sample]);
        for (block, (derivatives, _)) in blocks.iter().zip(places.blocks) {
            let (from, width) = (all.ncols(), derivatives[sample].0.ncols());
            all = all.resize_horizontally(from + width, 0.0);
            if let Some(block) = block {
                all.columns_mut(from, width).copy_from(&block[sample]);
            }
        }
        Shown { slope, values: all }
    };
    slopes.into_iter().enumerate().map(at).collect()
}

/// Derivatives by positions and velocities, then by a generalised force on each coordinate.
fn with_forces(slopes: &Derivatives, motions: &[Motion]) -> Derivatives {
    let beside = |known: &DMatrix<f64>, further: DMatrix<f64>| {
        let from = known.ncols();
        let mut both = known
            .clone()
            .resize_horizontally(from + further.ncols(), 0.0);
        both.columns_mut(from, further.ncols()).copy_from(&further);
        both
    };
    let pairs = slopes.iter().zip(motions);
    let each = pairs.map(|((da, dlambda), motion)| {
        let (moved, carried) = by_force(&motion.factorisation, da.nrows(), dlambda.nrows());
        (beside(da, moved), beside(dlambda, carried))
    });
    each.collect()
}

/// `P` and `∂λ/∂Q`: what a generalised force does to accelerations and multipliers.
fn by_force(factorisation: &Factorisation, n: usize, m: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    factorisation.solve(DMatrix::identity(n, n), &DMatrix::zeros(m, n))
}
