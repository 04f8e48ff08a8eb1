//! The feed-forward network that thesis 5.3.3 compares with: one hidden layer of
//! sigmoids, squared error, Adam on random batches.

use crate::arm::N;
use crate::models::{DIMS, channels, measured, scaled};
use crate::record::Sample;
use gp::Scaling;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Sigmoids in the hidden layer, as published.
const HIDDEN: usize = 80;
/// Parameters of the hidden layer: `HIDDEN` rows of weights and a bias.
const INNER: usize = HIDDEN * (DIMS + 1);
/// All parameters; the output layer has `N` rows of weights and a bias.
pub const PARAMETERS: usize = INNER + N * (HIDDEN + 1);
/// Iterations of Adam, as published.
pub const ITERATIONS: u64 = 5000;
/// Samples of one iteration, as published.
const BATCH: usize = 1000;
/// Rate of Adam, as published.
const RATE: f64 = 0.01;

/// A trained network of normalised accelerations over normalised `(q, v, u)`.
pub struct Network {
    parameters: Vec<f64>,
    inputs: Scaling,
    outputs: Scaling,
}

/// A normalised input, and what is to come out.
pub type Pair = (Vec<f64>, [f64; N]);

fn sum(row: &[f64], x: &[f64]) -> f64 {
    // The bias stands behind the weights.
    row[x.len()] + row.iter().zip(x).map(|(w, x)| w * x).sum::<f64>()
}

/// Outputs of the hidden layer and of the network.
fn forward(parameters: &[f64], x: &[f64]) -> ([f64; HIDDEN], [f64; N]) {
    let (inner, outer) = parameters.split_at(INNER);
    let mut hidden = [0.0; HIDDEN];
    for (h, row) in hidden.iter_mut().zip(inner.chunks(DIMS + 1)) {
        *h = 1.0 / (1.0 + (-sum(row, x)).exp());
    }
    let mut out = [0.0; N];
    for (y, row) in out.iter_mut().zip(outer.chunks(HIDDEN + 1)) {
        *y = sum(row, &hidden);
    }
    (hidden, out)
}

/// Adds `scale` times a row's derivatives.
fn add(gradient: &mut [f64], scale: f64, x: &[f64]) {
    gradient
        .iter_mut()
        .zip(x)
        .for_each(|(g, x)| *g += scale * x);
    gradient[x.len()] += scale;
}

/// Half the mean squared error of a batch, and its derivatives.
pub fn loss(parameters: &[f64], batch: &[&Pair]) -> (f64, Vec<f64>) {
    let share = 1.0 / (N * batch.len()) as f64;
    let mut gradient = vec![0.0; PARAMETERS];
    let mut value = 0.0;
    let outer = &parameters[INNER..];
    for (x, y) in batch {
        let (hidden, out) = forward(parameters, x);
        let (inner_gradient, outer_gradient) = gradient.split_at_mut(INNER);
        let mut back = [0.0; HIDDEN];
        let rows = outer.chunks(HIDDEN + 1);
        for (i, (row, g)) in rows.zip(outer_gradient.chunks_mut(HIDDEN + 1)).enumerate() {
            let gap = (out[i] - y[i]) * share;
            value += 0.5 * gap * (out[i] - y[i]);
            back.iter_mut().zip(row).for_each(|(b, w)| *b += gap * w);
            add(g, gap, &hidden);
        }
        for ((g, h), b) in inner_gradient.chunks_mut(DIMS + 1).zip(hidden).zip(back) {
            add(g, b * h * (1.0 - h), x);
        }
    }
    (value, gradient)
}

/// Uniform within `±1/√fan-in`, layer by layer.
pub fn start(rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut layer = |count: usize, fan_in: usize| -> Vec<f64> {
        let width = 1.0 / (fan_in as f64).sqrt();
        (0..count)
            .map(|_| rng.random_range(-width..width))
            .collect()
    };
    [layer(INNER, DIMS), layer(PARAMETERS - INNER, HIDDEN)].concat()
}

/// Adam (Kingma and Ba 2014).
fn adam(parameters: &mut [f64], pairs: &[Pair], iterations: u64, rng: &mut ChaCha8Rng) {
    let (mut first, mut second) = (vec![0.0; PARAMETERS], vec![0.0; PARAMETERS]);
    let (mut decay1, mut decay2) = (1.0f64, 1.0f64);
    for _ in 0..iterations {
        let batch: Vec<&Pair> = if pairs.len() <= BATCH {
            pairs.iter().collect()
        } else {
            (0..BATCH)
                .map(|_| &pairs[rng.random_range(0..pairs.len())])
                .collect()
        };
        let (_, gradient) = loss(parameters, &batch);
        decay1 *= 0.9;
        decay2 *= 0.999;
        for (i, g) in gradient.into_iter().enumerate() {
            first[i] = 0.9 * first[i] + 0.1 * g;
            second[i] = 0.999 * second[i] + 0.001 * g * g;
            let (m, v) = (first[i] / (1.0 - decay1), second[i] / (1.0 - decay2));
            parameters[i] -= RATE * m / (v.sqrt() + 1e-8);
        }
    }
}

impl Network {
    /// Trains on samples; inputs are scaled as those of the other models.
    pub fn new(inputs: &Scaling, samples: &[Sample], iterations: u64) -> gp::Result<Self> {
        let y = measured(samples);
        let all = channels(samples.len());
        let outputs = Scaling::of_outputs(&y, &all)?;
        let y = outputs.outputs(&y, &all)?;
        let pairs: Vec<Pair> = samples
            .iter()
            .zip(y.chunks(N))
            .map(|(s, y)| (scaled(inputs, &s.x), std::array::from_fn(|i| y[i])))
            .collect();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut parameters = start(&mut rng);
        adam(&mut parameters, &pairs, iterations, &mut rng);
        Ok(Self {
            parameters,
            inputs: inputs.clone(),
            outputs,
        })
    }

    /// Accelerations, sample by sample, rad/s².
    pub fn predict(&self, samples: &[Sample]) -> gp::Result<Vec<f64>> {
        let raw: Vec<f64> = samples
            .iter()
            .flat_map(|s| forward(&self.parameters, &scaled(&self.inputs, &s.x)).1)
            .collect();
        self.outputs.restore(&raw, &channels(samples.len()))
    }
}
