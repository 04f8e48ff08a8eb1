//! Linear functionals of the latent process: what is known about a point.
//!
//! Every quantity `s` of the dynamics is an affine map of the latent functions
//! `f` at the same point, `s(x) = H_s(x) f(x) + m_s(x)` (thesis 5.11). A
//! [`Functionals`] holds such rows for many points; it is all this crate is
//! told about a robot.

use crate::error::{GpError, Result, finite, shape};
use crate::inputs::{Inputs, indices_below};
use serde::{Deserialize, Serialize};

/// Rows `H(x_i)` and means `m(x_i)` stacked over `N` points, point-major.
///
/// Points may carry different numbers of rows, so measurements of different
/// quantities can be mixed in one data set. `R` is the total number of rows.
///
/// ```
/// use gp::Functionals;
/// // Two latent forces; at x = 0 we look at their sum plus 3, at x = 1 at the first.
/// let mut f = Functionals::new(1, 2);
/// f.push(&[0.0], &[1.0, 1.0], &[3.0])?;
/// f.push(&[1.0], &[1.0, 0.0], &[0.0])?;
/// assert_eq!((f.n_points(), f.n_rows()), (2, 2));
/// # Ok::<(), gp::GpError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Raw")]
pub struct Functionals {
    points: Vec<Vec<f64>>,
    dims: usize,
    n_latent: usize,
    starts: Vec<usize>,
    /// `H`, `R × n_latent` row-major.
    rows: Vec<f64>,
    mean: Vec<f64>,
    channels: Vec<usize>,
}

/// What a file holds, before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    points: Vec<Vec<f64>>,
    dims: usize,
    n_latent: usize,
    starts: Vec<usize>,
    rows: Vec<f64>,
    mean: Vec<f64>,
    channels: Vec<usize>,
}

impl TryFrom<Raw> for Functionals {
    type Error = GpError;
    fn try_from(raw: Raw) -> Result<Self> {
        let out = Self {
            points: raw.points,
            dims: raw.dims,
            n_latent: raw.n_latent,
            starts: raw.starts,
            rows: raw.rows,
            mean: raw.mean,
            channels: raw.channels,
        };
        out.validate()?;
        Ok(out)
    }
}

impl Functionals {
    /// No rows yet: points with `dims` coordinates, `n_latent` latent functions.
    pub fn new(dims: usize, n_latent: usize) -> Self {
        Self {
            points: Vec::new(),
            dims,
            n_latent,
            starts: vec![0],
            rows: Vec::new(),
            mean: Vec::new(),
            channels: Vec::new(),
        }
    }

    /// The latent functions themselves (`H = I`, `m = 0`) at every point.
    pub fn identity(inputs: &Inputs, n_latent: usize) -> Self {
        let mut out = Self::new(inputs.dims(), n_latent);
        let eye: Vec<f64> = (0..n_latent * n_latent)
            .map(|i| if i % (n_latent + 1) == 0 { 1.0 } else { 0.0 })
            .collect();
        for i in 0..inputs.len() {
            out.append(
                inputs.point(i),
                &eye,
                &vec![0.0; n_latent],
                (0..n_latent).collect(),
            );
        }
        out
    }

    /// Add a point: kernel input `x`, `h` with one row of length `n_latent`
    /// per entry of `mean` (row-major). Row `i` of a point belongs to noise
    /// channel `i`. Errors: shapes, NaN, infinity.
    pub fn push(&mut self, x: &[f64], h: &[f64], mean: &[f64]) -> Result<()> {
        let channels: Vec<usize> = (0..mean.len()).collect();
        self.push_on_channels(x, h, mean, &channels)
    }

    /// As [`Functionals::push`], with the noise channel of every row.
    pub fn push_on_channels(
        &mut self,
        x: &[f64],
        h: &[f64],
        mean: &[f64],
        channels: &[usize],
    ) -> Result<()> {
        let at = self.n_points();
        if x.len() != self.dims {
            return Err(shape(
                format!("input of point {at}"),
                format!("{} coordinates", self.dims),
                x.len(),
            ));
        }
        if h.len() != mean.len().saturating_mul(self.n_latent) {
            return Err(shape(
                format!("H of point {at}"),
                format!("{} rows × {} latent functions", mean.len(), self.n_latent),
                format!("{} numbers", h.len()),
            ));
        }
        if channels.len() != mean.len() {
            return Err(shape(
                format!("channels of point {at}"),
                mean.len(),
                channels.len(),
            ));
        }
        finite(&format!("input of point {at}"), x)?;
        finite(&format!("H of point {at}"), h)?;
        finite(&format!("mean of point {at}"), mean)?;
        self.append(x.to_vec(), h, mean, channels.to_vec());
        Ok(())
    }

    fn append(&mut self, x: Vec<f64>, h: &[f64], mean: &[f64], channels: Vec<usize>) {
        self.points.push(x);
        self.rows.extend_from_slice(h);
        self.mean.extend_from_slice(mean);
        self.channels.extend(channels);
        self.starts.push(self.mean.len());
    }

    /// Point `i` of `other`, which has our dimensions.
    fn append_from(&mut self, other: &Self, i: usize) {
        let r = other.rows_of(i);
        self.append(
            other.points[i].clone(),
            &other.rows[r.start * self.n_latent..r.end * self.n_latent],
            &other.mean[r.clone()],
            other.channels[r].to_vec(),
        );
    }

    /// The points of `other` after ours. Errors: different input or latent dimensions.
    pub fn extend(&mut self, other: &Self) -> Result<()> {
        if (other.dims, other.n_latent) != (self.dims, self.n_latent) {
            return Err(shape(
                "functionals to append",
                format!("{} inputs, {} latent functions", self.dims, self.n_latent),
                format!("{} inputs, {} latent functions", other.dims, other.n_latent),
            ));
        }
        (0..other.n_points()).for_each(|i| self.append_from(other, i));
        Ok(())
    }

    /// The points with the given indices, in that order. Errors: an index that is not below `N`.
    pub fn subset(&self, indices: &[usize]) -> Result<Self> {
        indices_below(self.n_points(), indices)?;
        Ok(self.pick(indices))
    }

    /// [`Functionals::subset`] of indices known to exist.
    pub(crate) fn pick(&self, indices: &[usize]) -> Self {
        let mut out = Self::new(self.dims, self.n_latent);
        indices.iter().for_each(|&i| out.append_from(self, i));
        out
    }

    /// Number of points `N`.
    pub fn n_points(&self) -> usize {
        self.points.len()
    }

    /// Total number of rows `R`.
    pub fn n_rows(&self) -> usize {
        self.mean.len()
    }

    /// Number of latent functions.
    pub fn n_latent(&self) -> usize {
        self.n_latent
    }

    /// Number of coordinates of a kernel input.
    pub fn dims(&self) -> usize {
        self.dims
    }

    /// Rows that belong to point `i`. Panics unless `i < N`, like indexing a slice.
    pub fn rows_of(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i]..self.starts[i + 1]
    }

    /// Row `r` of `H` (length `n_latent`). Panics unless `r < R`, like indexing a slice.
    pub fn row(&self, r: usize) -> &[f64] {
        &self.rows[r * self.n_latent..(r + 1) * self.n_latent]
    }

    /// Means `m`, length `R`.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Noise channel of each row, length `R`.
    pub fn channels(&self) -> &[usize] {
        &self.channels
    }

    /// First row of each point and, at the end, `R` (length `N + 1`).
    pub(crate) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// Kernel inputs of all points.
    pub fn inputs(&self) -> Inputs {
        Inputs::from_checked_rows(&self.points, self.dims)
    }

    /// Same rows at other kernel inputs, for example standardised ones.
    pub fn with_inputs(mut self, inputs: &Inputs) -> Result<Self> {
        if inputs.len() != self.n_points() {
            return Err(shape("replacement inputs", self.n_points(), inputs.len()));
        }
        self.dims = inputs.dims();
        self.points = (0..inputs.len()).map(|i| inputs.point(i)).collect();
        Ok(self)
    }

    /// Row `r` becomes `(H_r f + m_r - shift_c)/scale_c` with `c` its channel:
    /// the functional of a normalised output.
    pub fn normalised(mut self, shift: &[f64], scale: &[f64]) -> Result<Self> {
        self.check_channels(shift.len().min(scale.len()))?;
        for r in 0..self.n_rows() {
            let c = self.channels[r];
            self.mean[r] = (self.mean[r] - shift[c]) / scale[c];
            for h in &mut self.rows[r * self.n_latent..(r + 1) * self.n_latent] {
                *h /= scale[c];
            }
        }
        finite("normalised mean", &self.mean)?;
        finite("normalised H", &self.rows)?;
        Ok(self)
    }

    /// Latent function `d` replaced by `scale_d` times a latent function of unit order.
    pub fn with_latent_scale(mut self, scale: &[f64]) -> Result<Self> {
        if scale.len() != self.n_latent {
            return Err(shape("latent scale", self.n_latent, scale.len()));
        }
        finite("latent scale", scale)?;
        for row in self.rows.chunks_mut(self.n_latent.max(1)) {
            row.iter_mut().zip(scale).for_each(|(h, s)| *h *= s);
        }
        Ok(self)
    }

    /// Same rows with the mean replaced: Baumgarte's `b̃` changes only the mean (thesis 5.32).
    pub fn with_mean(mut self, mean: Vec<f64>) -> Result<Self> {
        if mean.len() != self.n_rows() {
            return Err(shape("mean", self.n_rows(), mean.len()));
        }
        finite("mean", &mean)?;
        self.mean = mean;
        Ok(self)
    }

    /// Fails when a row belongs to a channel that is not below `n`.
    pub(crate) fn check_channels(&self, n: usize) -> Result<()> {
        match self.channels.iter().find(|&&c| c >= n) {
            None => Ok(()),
            Some(c) => Err(shape("channel of a row", format!("below {n}"), c)),
        }
    }

    /// Everything [`Functionals::push`] checks, for a value read from a file.
    fn validate(&self) -> Result<()> {
        let n = self.points.len();
        let r = self.mean.len();
        let ok = self.starts.len() == n + 1
            && self.starts[0] == 0
            && self.starts[n] == r
            && self.starts.windows(2).all(|w| w[0] <= w[1])
            && Some(self.rows.len()) == r.checked_mul(self.n_latent)
            && self.channels.len() == r
            && self.points.iter().all(|p| p.len() == self.dims);
        if !ok {
            return Err(GpError::Saved(
                "the functionals have inconsistent shapes".into(),
            ));
        }
        self.points.iter().try_for_each(|p| finite("input", p))?;
        finite("H", &self.rows)?;
        finite("mean", &self.mean)
    }

    /// `H`, column-major: column `d` is `[d*R..(d+1)*R]`.
    pub(crate) fn columns(&self) -> Vec<f64> {
        let (r, n) = (self.n_rows(), self.n_latent);
        let mut out = vec![0.0; r * n];
        for (i, row) in self.rows.chunks(n.max(1)).enumerate() {
            for (d, &h) in row.iter().enumerate() {
                out[d * r + i] = h;
            }
        }
        out
    }
}
