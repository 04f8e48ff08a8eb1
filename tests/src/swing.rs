//! A rod that swings under gravity, and a log of it in closed form.

use std::fmt::Write;

/// The rod as a robot description: 1 kg, 0.3 m below its only joint `j`.
pub const ROD: &str = r#"<robot name="arm"><link name="base"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.3"/><mass value="1"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
  <joint name="j" type="continuous"><parent link="base"/><child link="rod"/>
    <axis xyz="0 1 0"/></joint>
</robot>"#;

/// Rows of `t,q,u`, from a sample on, at `rate` Hz. The torque is what the rod needs for its motion and
/// for viscous friction, as its own equation has it: `u = i q″ + m g l sin q + d q′`.
pub fn swing(rate: u32, first: u32, rows: u32) -> String {
    let (inertia, weight, d) = (0.02 + 0.09, 9.81 * 0.3, 0.05);
    let mut text = String::new();
    for k in first..first + rows {
        let t = f64::from(k) / f64::from(rate);
        let (mut q, mut v, mut a) = (0.0, 0.0, 0.0);
        for (size, rate) in [(0.5, 1.3_f64), (0.3, 3.7), (0.1, 7.1)] {
            let (sin, cos) = (rate * t).sin_cos();
            q += size * sin;
            v += size * rate * cos;
            a -= size * rate * rate * sin;
        }
        let u = inertia * a + weight * q.sin() + d * v;
        writeln!(text, "{t:.3},{q:.6},{u:.6}").expect("text can grow");
    }
    text
}
