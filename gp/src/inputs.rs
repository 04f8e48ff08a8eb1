//! Kernel inputs: a set of points stored dimension by dimension.

use crate::error::{Result, finite, shape};
use serde::{Deserialize, Serialize};

/// `N` points with `D` coordinates each.
///
/// Stored dimension-major (all first coordinates, then all second ones), so a
/// kernel walks contiguous memory.
///
/// ```
/// let x = gp::Inputs::from_rows(&[vec![0.0, 1.0], vec![2.0, 3.0]])?;
/// assert_eq!((x.len(), x.dims()), (2, 2));
/// assert_eq!(x.dim(1), &[1.0, 3.0]);
/// # Ok::<(), gp::GpError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawInputs", into = "RawInputs")]
pub struct Inputs {
    points: usize,
    dims: usize,
    columns: Vec<f64>,
}

#[derive(Clone, Serialize, Deserialize)]
struct RawInputs {
    points: usize,
    columns: Vec<Vec<f64>>,
}

impl TryFrom<RawInputs> for Inputs {
    type Error = crate::GpError;
    fn try_from(raw: RawInputs) -> Result<Self> {
        let dims = raw.columns.len();
        if let Some(c) = raw.columns.iter().find(|c| c.len() != raw.points) {
            return Err(shape("input column", raw.points, c.len()));
        }
        let columns: Vec<f64> = raw.columns.concat();
        finite("inputs", &columns)?;
        Ok(Self {
            points: raw.points,
            dims,
            columns,
        })
    }
}

impl From<Inputs> for RawInputs {
    fn from(x: Inputs) -> Self {
        let columns = (0..x.dims).map(|d| x.dim(d).to_vec()).collect();
        Self {
            points: x.points,
            columns,
        }
    }
}

impl Inputs {
    /// From one slice per point. Errors: ragged rows, NaN, infinity.
    pub fn from_rows<R: AsRef<[f64]>>(rows: &[R]) -> Result<Self> {
        let dims = rows.first().map_or(0, |r| r.as_ref().len());
        for (i, row) in rows.iter().enumerate() {
            let row = row.as_ref();
            if row.len() != dims {
                return Err(shape(
                    format!("input point {i}"),
                    format!("{dims} coordinates"),
                    row.len(),
                ));
            }
            finite(&format!("input point {i}"), row)?;
        }
        Ok(Self::from_checked_rows(rows, dims))
    }

    /// From rows known to be finite and `dims` long.
    pub(crate) fn from_checked_rows<R: AsRef<[f64]>>(rows: &[R], dims: usize) -> Self {
        let columns = (0..dims)
            .flat_map(|d| rows.iter().map(move |r| r.as_ref()[d]))
            .collect();
        Self {
            points: rows.len(),
            dims,
            columns,
        }
    }

    /// An empty set of points with `dims` coordinates.
    pub fn empty(dims: usize) -> Self {
        Self {
            points: 0,
            dims,
            columns: Vec::new(),
        }
    }

    /// Number of points `N`.
    pub fn len(&self) -> usize {
        self.points
    }

    /// True when there is no point.
    pub fn is_empty(&self) -> bool {
        self.points == 0
    }

    /// Number of coordinates `D`.
    pub fn dims(&self) -> usize {
        self.dims
    }

    /// Coordinate `d` of all points (length `N`). Panics unless `d < D`, like indexing a slice.
    pub fn dim(&self, d: usize) -> &[f64] {
        &self.columns[d * self.points..(d + 1) * self.points]
    }

    /// All coordinates of point `i` (length `D`). Panics unless `i < N`, like indexing a slice.
    pub fn point(&self, i: usize) -> Vec<f64> {
        (0..self.dims).map(|d| self.dim(d)[i]).collect()
    }

    /// The points with the given indices, in that order. Errors: an index that is not below `N`.
    pub fn subset(&self, indices: &[usize]) -> Result<Self> {
        indices_below(self.points, indices)?;
        Ok(self.pick(indices))
    }

    /// [`Inputs::subset`] of indices known to exist.
    pub(crate) fn pick(&self, indices: &[usize]) -> Self {
        let columns = (0..self.dims)
            .flat_map(|d| indices.iter().map(move |&i| self.dim(d)[i]))
            .collect();
        Self {
            points: indices.len(),
            dims: self.dims,
            columns,
        }
    }

    /// Each coordinate shifted and scaled: `(x_d - shift_d) / scale_d`.
    pub fn standardised(&self, shift: &[f64], scale: &[f64]) -> Result<Self> {
        if shift.len() != self.dims || scale.len() != self.dims {
            return Err(shape(
                "shift and scale of the inputs",
                self.dims,
                format!("{} and {}", shift.len(), scale.len()),
            ));
        }
        let mut out = self.clone();
        for d in 0..self.dims {
            for v in &mut out.columns[d * self.points..(d + 1) * self.points] {
                *v = (*v - shift[d]) / scale[d];
            }
        }
        finite("standardised inputs", &out.columns)?;
        Ok(out)
    }

    /// Pairs of points with bitwise equal coordinates (each with its first twin).
    pub(crate) fn coincident(&self) -> Vec<(usize, usize)> {
        let mut order: Vec<usize> = (0..self.points).collect();
        // Adding zero makes -0 and 0 one.
        let key = |i: usize| -> Vec<f64> { self.point(i).iter().map(|v| v + 0.0).collect() };
        let cmp = |a: &Vec<f64>, b: &Vec<f64>| {
            a.iter()
                .zip(b)
                .map(|(x, y)| x.total_cmp(y))
                .find(|o| o.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        };
        order.sort_by(|&i, &j| cmp(&key(i), &key(j)).then(i.cmp(&j)));
        order
            .windows(2)
            .filter(|w| key(w[0]) == key(w[1]))
            .map(|w| (w[0].min(w[1]), w[0].max(w[1])))
            .collect()
    }
}

/// Fails with the first index that is not below `n`.
pub(crate) fn indices_below(n: usize, indices: &[usize]) -> Result<()> {
    match indices.iter().find(|&&i| i >= n) {
        None => Ok(()),
        Some(i) => Err(shape("index of a point", format!("below {n}"), i)),
    }
}
