//! In which band forces are fitted.

use super::columns::Columns;
use super::equations::Equations;
use super::select::weighed_by_all;
use crate::regression::{Told, Uncertainty};

/// How well equations whose columns no acceleration enters tell coefficients.
pub(super) fn uncertainty(columns: &Columns, equations: Equations) -> Uncertainty {
    let weighed = weighed_by_all(columns, equations, false);
    Told {
        window: weighed.window,
        samples: weighed.log_samples(),
        left: &weighed.scale,
        exerted: &weighed.exerted(),
        columns: weighed.moving_columns(),
    }
    .uncertainty()
}
