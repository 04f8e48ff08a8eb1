//! A pendulum with an inertial sensor, and logs of it without its angle, that tests are made with.

use super::wheel::rectangular;
use std::fmt::Write;

/// A pendulum of 2 kg at 0.5 m with an inertial sensor at 0.3 m, x along the rod.
pub(crate) const SWING: &str = "\
model swing;
coordinate phi: rad;
input motor: N*m;
parameter m: kg = 2;
body rod { frame: rotate_z(-pi/2) * rotate_z(phi); mass: m; center: (0.5, 0, 0); }
gravity (0, -9.81, 0);
force phi = motor;
frame board = rod * translate(0.3, 0, 0);
sensor gyro: rad/s = gyroscope(board);
sensor felt: m/s^2 = accelerometer(board);
";

const WAVES: [(f64, f64); 3] = [(0.8, 1.7), (0.4, 4.1), (0.1, 8.3)];

/// Angle, rate and acceleration at a time.
pub(crate) fn motion(t: f64) -> [f64; 3] {
    let sum = |of: &dyn Fn(f64, f64) -> f64| WAVES.iter().map(|&(a, w)| of(a, w)).sum::<f64>();
    [
        0.5 + sum(&|a, w| a * (w * t).sin()),
        sum(&|a, w| a * w * (w * t).cos()),
        sum(&|a, w| -a * w * w * (w * t).sin()),
    ]
}

/// What the gyroscope and the accelerometer show at a time, along x and y.
pub(crate) fn shown(t: f64) -> [f64; 3] {
    let (r, g) = (0.3, 9.81);
    let [q, v, a] = motion(t);
    [v, -r * v * v - g * q.cos(), r * a + g * q.sin()]
}

/// A log of the pendulum with this much viscous friction, whose sensors are noisy; without the
/// columns in `without`.
pub(crate) fn swing(friction: f64, without: &[&str]) -> String {
    read_as(friction, without, shown)
}

/// The same where sensors read this at a time.
pub(crate) fn read_as(
    friction: f64,
    without: &[&str],
    reading: impl Fn(f64) -> [f64; 3],
) -> String {
    let (m, l, g) = (2.0, 0.5, 9.81);
    let columns = ["t", "u_motor", "gyro_z", "felt_x", "felt_y"];
    let kept: Vec<usize> = (0..5).filter(|&i| !without.contains(&columns[i])).collect();
    let names: Vec<&str> = kept.iter().map(|&i| columns[i]).collect();
    let mut text = names.join(",") + "\n";
    let mut noise = rectangular(3);
    for k in 0..1500 {
        let t = 0.01 * f64::from(k);
        let [q, v, a] = motion(t);
        let u = m * l * l * a + m * g * l * q.sin() + friction * v;
        let [gyro, along, across] = reading(t);
        let mut noisy = |x: f64, sd: f64| x + sd * 12.0_f64.sqrt() * noise();
        let row = [
            t,
            u,
            noisy(gyro, 3e-3),
            noisy(along, 0.03),
            noisy(across, 0.03),
        ];
        let cells: Vec<String> = kept.iter().map(|&i| row[i].to_string()).collect();
        writeln!(text, "{}", cells.join(",")).unwrap();
    }
    text
}
