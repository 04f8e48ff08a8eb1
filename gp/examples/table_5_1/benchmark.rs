//! The three systems of Table 5.1 with their data, grids and structures.

use crate::systems::{self, State};
use gp::{Functionals, GaussPoint, GpError, Layout, Quantity, Structure, Tangent};
use serde_json::Value;

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Se,
    Icm,
    Lmc,
    Gp2 { mean: bool, estimate: bool },
}

/// Kind, name, published figures (surface | unicycle | Duffing).
pub const ROWS: [(Kind, &str, &str); 7] = [
    (
        Kind::Se,
        "SE",
        "| .235 [.190, .272] 2.6 | .27 [.20, .40] .22 | .011 [.004, .033] 6.4",
    ),
    (
        Kind::Icm,
        "ICM",
        "| .244 [.223, .277] 1.5 | .21 [.15, .27] .22 | .003 [.002, .005] .5",
    ),
    (
        Kind::Lmc,
        "LMC",
        "| .194 [.159, .233] 1.8 | .21 [.15, .28] .26 | .003 [.001, .006] .023",
    ),
    (
        Kind::Gp2 {
            mean: false,
            estimate: false,
        },
        "GP2",
        "| .058 [.045, .066] 4e-12 | .10 [.06, .20] 2e-12 | .007 [.001, .019] 1e-8",
    ),
    (
        Kind::Gp2 {
            mean: true,
            estimate: false,
        },
        "GP2, mean",
        "| .023 [.018, .032] 1e-13 | .08 [.05, .15] 6e-13 | .005 [.002, .029] 3e-8",
    ),
    (
        Kind::Gp2 {
            mean: false,
            estimate: true,
        },
        "GP2, estimated",
        "| .065 [.056, .071] .12 | .13 [.05, .30] 9e-13 | .009 [.003, .028] .013",
    ),
    (
        Kind::Gp2 {
            mean: true,
            estimate: true,
        },
        "GP2, estimated, mean",
        "| .027 [.020, .037] .09 | .12 [.06, .20] 9e-13 | .020 [.004, .077] .006",
    ),
];

/// A benchmark system.
pub struct System {
    pub name: &'static str,
    state: fn(&[f64], &[f64]) -> State,
    parameters: &'static [f64],
    /// Estimated parameters without and with a mean.
    estimated: [&'static [usize]; 2],
}

pub const SYSTEMS: [System; 3] = [
    System {
        name: "surface",
        state: systems::surface,
        parameters: &[0.08, 0.05, 0.05, 0.0, 0.0, 0.1, 3.0],
        estimated: [&[0, 1, 2, 5, 6], &[0, 1, 2, 5, 6]],
    },
    System {
        name: "unicycle",
        state: unforced_unicycle,
        parameters: &[0.05, 0.02],
        estimated: [&[0, 1], &[0, 1]],
    },
    System {
        name: "duffing",
        state: systems::duffing,
        parameters: &[1.0, 0.3, std::f64::consts::TAU, 10.0, 12.0, 0.1, 0.15],
        estimated: [&[0, 1, 2], &[0, 1, 2, 3, 4, 5, 6]],
    },
];

/// The unicycle observations were made without input.
fn unforced_unicycle(x: &[f64], p: &[f64]) -> State {
    systems::unicycle(&[x[0], x[1], x[2], x[3], 0.0, 0.0], p)
}

fn acceleration(s: &State, force: &[f64]) -> gp::Result<Vec<f64>> {
    let total: Vec<f64> = s.known.iter().zip(force).map(|(k, f)| k + f).collect();
    Ok(GaussPoint::new(&s.mass, &s.a, &s.b, &total)?
        .rows(Quantity::Acceleration, Layout::Force)?
        .mean)
}

impl System {
    /// Noise-free constrained acceleration.
    pub fn truth(&self, x: &[f64]) -> gp::Result<Vec<f64>> {
        let s = (self.state)(x, self.parameters);
        let force = match self.name {
            "surface" => systems::surface_damping(x),
            "unicycle" => {
                let speed = x[0].hypot(x[1]);
                let d = [-0.5 * speed * x[0], -0.5 * speed * x[1], 0.0];
                (0..3)
                    .map(|i| (0..3).map(|j| s.mass[3 * i + j] * d[j]).sum())
                    .collect()
            }
            _ => {
                let cube = (x[0] - x[1]).powi(3);
                vec![-cube, cube - 2.0 * x[1].powi(3)]
            }
        };
        acceleration(&s, &force)
    }

    /// `|A a - b|` with the published scaling of the unicycle's row.
    pub fn constraint_error(&self, x: &[f64], a: &[f64]) -> f64 {
        let s = (self.state)(x, self.parameters);
        let residual: f64 = (0..a.len()).map(|j| s.a[j] * a[j]).sum::<f64>() - s.b[0];
        if self.name == "unicycle" {
            (residual * x[2].cos()).abs()
        } else {
            residual.abs()
        }
    }

    /// The published test grid, projected onto the constraint.
    pub fn grid(&self, data: &Data) -> Vec<Vec<f64>> {
        let axes: Vec<Vec<f64>> = (0..data.counts.len())
            .map(|d| {
                let (lo, hi, n) = (data.lower[d], data.upper[d], data.counts[d]);
                if n == 1 {
                    vec![lo]
                } else {
                    (0..n)
                        .map(|i| lo + (hi - lo) * i as f64 / (n - 1) as f64)
                        .collect()
                }
            })
            .collect();
        let mut grid = vec![vec![]];
        for axis in &axes {
            grid = grid
                .iter()
                .flat_map(|p: &Vec<f64>| axis.iter().map(move |v| [&p[..], &[*v]].concat()))
                .collect();
        }
        grid.into_iter().map(|x| self.project(x)).collect()
    }

    fn project(&self, mut x: Vec<f64>) -> Vec<f64> {
        let p = self.parameters;
        match self.name {
            "surface" => {
                x[2] = 0.0;
                x[2] = systems::surface_gap(&x, p);
                let a = (self.state)(&x, p).a;
                x[5] = a[0] * x[3] + a[1] * x[4];
            }
            "unicycle" => {
                let (sin, cos) = x[2].sin_cos();
                (x[0], x[1]) = (x[0] * cos, x[0] * sin);
            }
            _ => {
                let (e, (sin, cos)) = ((-p[1] * x[4]).exp(), (p[2] * x[4]).sin_cos());
                x[1] = x[0] - p[0] * e * sin;
                x[3] = x[2] - p[0] * e * (p[2] * cos - p[1] * sin);
            }
        }
        x
    }
}

/// One set of observations with its normalisation.
pub struct Data {
    pub x: Vec<Vec<f64>>,
    /// Normalised accelerations, point-major.
    pub y: Vec<f64>,
    x_mean: Vec<f64>,
    x_sd: Vec<f64>,
    pub y_mean: Vec<f64>,
    pub y_sd: Vec<f64>,
    /// Standard deviation of the noise, raw units.
    pub noise: f64,
    lower: Vec<f64>,
    upper: Vec<f64>,
    counts: Vec<usize>,
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array()
        .map(|a| a.iter().filter_map(Value::as_f64).collect())
        .unwrap_or_default()
}

fn moments(rows: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>) {
    let (n, dims) = (rows.len() as f64, rows[0].len());
    let mean: Vec<f64> = (0..dims)
        .map(|d| rows.iter().map(|r| r[d]).sum::<f64>() / n)
        .collect();
    let sd = (0..dims)
        .map(|d| (rows.iter().map(|r| (r[d] - mean[d]).powi(2)).sum::<f64>() / n).sqrt())
        .collect();
    (mean, sd)
}

/// The file of published observations, beside the project.
pub fn observations() -> Result<Value, Box<dyn std::error::Error>> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/data/gp2_observations/observations.json"
    );
    let text = std::fs::read_to_string(path)
        .map_err(|e| format!("the published observations are not at {path}: {e}"))?;
    Ok(serde_json::from_str(&text)?)
}

impl Data {
    pub fn read(file: &Value, system: &System, run: usize) -> gp::Result<Self> {
        let entry = &file[system.name];
        let rows = |key: &str| -> gp::Result<Vec<Vec<f64>>> {
            let list = entry["runs"][run][key]
                .as_array()
                .ok_or_else(|| GpError::Saved(format!("no {key} of run {run}")))?;
            Ok(list.iter().map(numbers).collect())
        };
        let (x, y) = (rows("X")?, rows("Y")?);
        let ((x_mean, x_sd), (y_mean, y_sd)) = (moments(&x), moments(&y));
        let y = y
            .iter()
            .flat_map(|r| {
                (0..r.len())
                    .map(|i| (r[i] - y_mean[i]) / y_sd[i])
                    .collect::<Vec<_>>()
            })
            .collect();
        Ok(Self {
            x,
            y,
            x_mean,
            x_sd,
            y_mean,
            y_sd,
            noise: entry["noise_std"].as_f64().unwrap_or(f64::NAN),
            lower: numbers(&entry["lim_min"]),
            upper: numbers(&entry["lim_max"]),
            counts: numbers(&entry["grid_lim_num"])
                .iter()
                .map(|&n| n as usize)
                .collect(),
        })
    }

    pub fn dims(&self) -> usize {
        self.x_sd.len()
    }

    fn kernel_input(&self, x: &[f64]) -> Vec<f64> {
        (0..x.len())
            .map(|d| (x[d] - self.x_mean[d]) / self.x_sd[d])
            .collect()
    }
}

/// What one row of the table knows about one data set.
pub struct Benchmark<'a> {
    kind: Kind,
    pub system: &'a System,
    pub data: &'a Data,
}

impl<'a> Benchmark<'a> {
    pub fn new(kind: Kind, system: &'a System, data: &'a Data) -> Self {
        Self { kind, system, data }
    }

    fn estimated(&self) -> &'static [usize] {
        match self.kind {
            Kind::Gp2 {
                mean,
                estimate: true,
            } => self.system.estimated[usize::from(mean)],
            _ => &[],
        }
    }

    /// True values, where the search starts unless told otherwise.
    pub fn start(&self) -> Vec<f64> {
        self.estimated()
            .iter()
            .map(|&i| self.system.parameters[i])
            .collect()
    }

    /// ±0.02 around the truth; `I_c` stays above `m R²`.
    pub fn theta_bounds(&self) -> Vec<(f64, f64)> {
        let unicycle = self.system.name == "unicycle";
        let bound = |i: usize, p: f64| {
            if unicycle && i == 1 {
                (0.005, p + 0.02)
            } else {
                (p - 0.02, p + 0.02)
            }
        };
        self.estimated()
            .iter()
            .map(|&i| bound(i, self.system.parameters[i]))
            .collect()
    }

    fn point(&self, x: &[f64], theta: &[f64]) -> gp::Result<(State, GaussPoint)> {
        let mut p = self.system.parameters.to_vec();
        self.estimated()
            .iter()
            .zip(theta)
            .for_each(|(&i, &t)| p[i] = t);
        let s = (self.system.state)(x, &p);
        let s = if matches!(self.kind, Kind::Gp2 { mean: true, .. }) {
            s
        } else {
            s.without_known()
        };
        let point = GaussPoint::new(&s.mass, &s.a, &s.b, &s.known)?;
        Ok((s, point))
    }

    /// Functionals of the normalised acceleration at raw states.
    pub fn at(&self, states: &[Vec<f64>], theta: &[f64]) -> gp::Result<Functionals> {
        let (n, data) = (self.data.y_sd.len(), self.data);
        let mut out = Functionals::new(data.dims(), n);
        let eye: Vec<f64> = (0..n * n)
            .map(|i| if i % (n + 1) == 0 { 1.0 } else { 0.0 })
            .collect();
        for x in states {
            let input = data.kernel_input(x);
            if let Kind::Gp2 { .. } = self.kind {
                let r = self
                    .point(x, theta)?
                    .1
                    .rows(Quantity::Acceleration, Layout::Acceleration)?;
                out.push(&input, &r.h, &r.mean)?;
            } else {
                out.push(&input, &eye, &data.y_mean)?;
            }
        }
        // Baselines come out as H = I, m = 0 in normalised units.
        out.with_latent_scale(&data.y_sd)?
            .normalised(&data.y_mean, &data.y_sd)
    }
}

impl Structure for Benchmark<'_> {
    fn n_theta(&self) -> usize {
        self.estimated().len()
    }

    fn functionals(&self, theta: &[f64]) -> gp::Result<Functionals> {
        self.at(&self.data.x, theta)
    }

    fn tangents(&self, theta: &[f64]) -> gp::Result<Vec<Tangent>> {
        let (n, sd) = (self.data.y_sd.len(), &self.data.y_sd);
        let mut out = vec![Tangent::default(); theta.len()];
        for x in self.data.x.iter().filter(|_| !theta.is_empty()) {
            let (s, point) = self.point(x, theta)?;
            for (out, &i) in out.iter_mut().zip(self.estimated()) {
                let t =
                    point.tangent(&s.tangents[i], Quantity::Acceleration, Layout::Acceleration)?;
                out.mean.extend((0..n).map(|r| t.mean[r] / sd[r]));
                out.rows
                    .extend((0..n * n).map(|e| t.rows[e] * sd[e % n] / sd[e / n]));
            }
        }
        Ok(out)
    }
}
