//! A bar between two rotors, for tests of what several drives have alike.

use super::wheel::rectangular;
use std::fmt::Write;

pub(super) const BAR: &str = "\
model bar;
coordinate x: m;
coordinate phi: rad;
input left: N;
input right: N;
parameter m: kg = 1 in 0..;
parameter i: kg*m^2 = 0.02 in 0..;
parameter arm: m = 0.2;
kinetic m/2*dot(x)^2 + i/2*dot(phi)^2;
force x = left + right;
force phi = arm*(right - left);
";

/// A bar on ice that two rotors push at its ends, each of which lags its command by so many seconds; a controller
/// at 200 Hz moves it by what noisy sensors say.
pub(super) fn log(lags: [f64; 2]) -> String {
    let mut text = String::from("t,q_x,q_phi,u_left,u_right\n");
    let mut noise = rectangular(5);
    let (mut q, mut v, mut thrust, mut command) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
    let mut known = [0.0; 2];
    for tick in 0..8000 {
        let t = 1e-3 * f64::from(tick);
        if tick % 5 == 0 {
            let read = q.map(|q| q + 6e-4 * noise());
            let rate = [0, 1].map(|i: usize| (read[i] - known[i]) / 5e-3);
            known = read;
            let wanted = [
                0.3 * (2.1 * t).sin() + 0.15 * (5.3 * t).sin(),
                0.3 * (3.1 * t).sin() + 0.2 * (6.7 * t).sin(),
            ];
            let force = 16.0 * (wanted[0] - read[0]) - 6.0 * rate[0];
            let couple = 0.02 * (64.0 * (wanted[1] - read[1]) - 11.0 * rate[1]) / 0.2;
            command = [(force - couple) / 2.0, (force + couple) / 2.0];
            writeln!(
                text,
                "{t:.3},{},{},{},{}",
                read[0], read[1], command[0], command[1]
            )
            .unwrap();
        }
        // Of the thrust its mean over the millisecond, by its law.
        let kept = lags.map(|lag| (-1e-3 / lag).exp());
        let mean = [0, 1].map(|i| (1.0 - kept[i]) * lags[i] / 1e-3);
        let [left, right] = [0, 1].map(|i| command[i] + (thrust[i] - command[i]) * mean[i]);
        thrust = [0, 1].map(|i| command[i] + (thrust[i] - command[i]) * kept[i]);
        let a = [left + right, 0.2 * (right - left) / 0.02];
        for i in 0..2 {
            q[i] += 1e-3 * (v[i] + 0.5e-3 * a[i]);
            v[i] += 1e-3 * a[i];
        }
    }
    text
}
