//! Gears between motors and joints.

use super::file::Transmission;
use super::{Channel, MapError, Reader, Term, Wrap, unit};
use nalgebra::DMatrix;
use toml::Spanned;

/// Ratios whose matrix is worse conditioned than this tell one joint from another by noise.
const WORST_CONDITION: f64 = 1e8;

impl Reader<'_> {
    /// With `q_m = R q`: `q = R⁻¹ q_m + offset`, rates likewise, and `u = Rᵀ u_m`.
    pub(super) fn transmission(
        &self,
        stated: &Spanned<Transmission>,
    ) -> Result<Vec<Channel>, MapError> {
        let place = || Some(stated.span());
        let gear = stated.get_ref();
        let n = gear.coordinates.len();
        let fault = |message: String, mend: &str| Err(self.fault(place(), message, mend));
        let square = gear.ratio.len() == n && gear.ratio.iter().all(|row| row.len() == n);
        if n == 0 || !square {
            let shown: Vec<usize> = gear.ratio.iter().map(Vec::len).collect();
            let message = format!(
                "`ratio` has rows of {shown:?} numbers; expected {n} rows of {n}, one per coordinate"
            );
            return fault(
                message,
                "row i says how far motor i turns per turn of each coordinate",
            );
        }
        let ratio = DMatrix::from_fn(n, n, |i, j| gear.ratio[i][j]);
        let inverse = invert(&ratio);
        let Some(inverse) = inverse else {
            return fault(
                "`ratio` cannot be inverted: the motors do not determine the coordinates"
                    .to_owned(),
                "check for a zero, or for two rows that are multiples of each other",
            );
        };
        let offset = match &gear.offset {
            None => vec![0.0; n],
            Some(offset) if offset.len() == n && offset.iter().all(|x| x.is_finite()) => {
                offset.clone()
            }
            Some(_) => {
                return fault(
                    format!("`offset` does not have {n} finite numbers"),
                    "one per coordinate",
                );
            }
        };
        let zeros = vec![0.0; n];
        let inputs = gear.inputs.as_ref().unwrap_or(&gear.coordinates);
        let transposed = ratio.transpose();
        let parts = [
            (
                "q_",
                &gear.coordinates,
                &gear.position,
                &gear.position_unit,
                &inverse,
                &offset,
            ),
            (
                "dq_",
                &gear.coordinates,
                &gear.velocity,
                &gear.velocity_unit,
                &inverse,
                &zeros,
            ),
            (
                "ddq_",
                &gear.coordinates,
                &gear.acceleration,
                &gear.acceleration_unit,
                &inverse,
                &zeros,
            ),
            (
                "u_",
                inputs,
                &gear.torque,
                &gear.torque_unit,
                &transposed,
                &zeros,
            ),
        ];
        let mut channels = Vec::new();
        for (prefix, names, columns, stated_unit, matrix, offset) in parts {
            let Some(columns) = columns else { continue };
            if columns.len() != n || names.len() != n {
                let message = format!(
                    "{} columns and {} names for `{prefix}`; expected {n} of each",
                    columns.len(),
                    names.len()
                );
                return fault(
                    message,
                    "one column per motor, in the order of the rows of `ratio`",
                );
            }
            let own = match stated_unit {
                Some(unit) => self.unit(unit)?,
                None => 1.0,
            };
            let turn = unit::turn(stated_unit.as_ref().map_or("rad", |unit| unit.get_ref()));
            let wrap = match prefix {
                "q_" => self.wrap(&gear.wraps, turn)?,
                _ => Wrap::None,
            };
            for (row, name) in names.iter().enumerate() {
                let terms = columns.iter().enumerate().map(|(column, source)| Term {
                    column: source.0.clone(),
                    factor: own * matrix[(row, column)],
                    wrap,
                    fill: None,
                });
                channels.push(Channel {
                    name: format!("{prefix}{name}"),
                    terms: terms.filter(|term| term.factor != 0.0).collect(),
                    offset: offset[row],
                });
            }
        }
        if channels.is_empty() {
            return fault(
                "the transmission names no columns".to_owned(),
                "state `position`, `velocity`, `acceleration` or `torque`: one column per motor",
            );
        }
        Ok(channels)
    }
}

fn invert(ratio: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    if !ratio.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let values = ratio.singular_values();
    let sound = values.max() > 0.0 && values.max() < WORST_CONDITION * values.min();
    let inverse = ratio.clone().try_inverse().filter(|_| sound)?;
    // Zeros of a coupling are zeros, not rounding.
    let largest = inverse.amax();
    Some(inverse.map(|entry| {
        if entry.abs() < 1e-14 * largest {
            0.0
        } else {
            entry
        }
    }))
}
