//! Torques ahead of the feedback that turn the robot about its vertical axis.

/// Both wheels swing in step. Where the robot leans forward while its reaction wheel is driven, and to
/// the side while its rolling wheel is, the torques have parts about the vertical axis that do not
/// cancel over a period: [6.21] has no yaw, the nonlinear model does. In the second half the rolling
/// wheel swings against the reaction wheel, which stops the turn.
#[derive(Debug, Clone, Copy)]
pub struct Excitation {
    /// When it begins, s.
    pub at: f64,
    /// How long it lasts, s.
    pub seconds: f64,
    /// Of the swing, Hz.
    pub frequency: f64,
    /// By how much of a turn the rolling wheel's swing is ahead of the reaction wheel's, rad.
    pub phase: f64,
    /// Of reaction wheel and rolling wheel, N·m.
    pub torque: [f64; 2],
    /// Share of the time after which it is to stop the turn.
    pub turning_point: f64,
}

impl Excitation {
    /// Torques of reaction wheel and rolling wheel at a time, N·m.
    pub fn torques(&self, t: f64) -> [f64; 2] {
        let since = t - self.at;
        if !(0.0..self.seconds).contains(&since) {
            return [0.0; 2];
        }
        let angle = std::f64::consts::TAU * self.frequency * since;
        let sign = match since < self.turning_point * self.seconds {
            true => 1.0,
            false => -1.0,
        };
        let [reaction, rolling] = self.torque;
        [
            reaction * angle.sin(),
            sign * rolling * (angle + self.phase).sin(),
        ]
    }
}
