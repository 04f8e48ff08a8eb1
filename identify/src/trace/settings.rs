//! Every number that steers the search.

/// Nats that a further term costs beside the logarithm of how many there might be: what was
/// tried is paid for, and chance has a bad day once in twenty.
pub const MARGIN: f64 = 3.0;
/// Nats that each number of an effect costs, determined by the log or not, and that the log is not
/// what it seems: of laws that are one here the plain one wins, a force wins over the same force as
/// a fault of its drive, and another value of a parameter of the model, which states nothing new, wins
/// over both.
pub const STATEMENT: f64 = 1.0;
/// Nats against what is possible and unusual: inputs that are held between samples, and a force that
/// brakes all along the log and would drive the machine if it turned back. What needs no source of
/// energy is the simpler explanation.
pub const UNUSUAL: f64 = 6.0;
/// Share of a force's work that must be taken from the machine for it to be a brake there.
pub const BRAKES: f64 = 0.9;
/// Nats within which two hypotheses count as equal.
pub const TIE: f64 = 6.0;
/// Nats within which two fits of one hypothesis are the same, and one hypothesis that was gone on from
/// spares going on from another.
pub const SAME_FIT: f64 = 1.0;
/// Unexplained variance below this many times the smallest is none, and squares of what is left in the balance of forces
/// below this many times what all effects together leave are nearly nothing where columns of inputs carry noise.
pub const NO_EXCESS: f64 = 3.0;
/// Terms at most.
pub const MAX_TERMS: usize = 12;
/// Hypotheses that are gone on from, beside the best, where forces remain.
pub const BEAM: usize = 2;
/// Fitted hypotheses that are kept with the motion that goes with them.
pub const KEPT: usize = 8;

/// Samples that are searched in before the whole log is,
pub const SEARCHED: usize = 1500;
/// with so many readings of the model's sensors at most.
pub const SEARCHED_READINGS: usize = 18_000;
/// Samples that are looked at where a first glance is enough.
pub const GLANCE: usize = 1000;

/// Candidates that are looked at closely, with noise that suits them,
pub const PROFILED: usize = 12;
/// of which so many are fitted. In the balance of forces, terms of least worth that are left out in turn.
pub const SHORTLISTED: usize = 5;
/// Candidates that are looked at two at a time.
pub const PAIRED: usize = 64;
/// Exchanges of one term that are fitted,
pub const EXCHANGED: usize = 3;
/// those among them that lose no more than this share of what the term is worth, to first order.
pub const NEARLY: f64 = 0.05;

/// Hypotheses that gain this share of what the best one gains, now or before, get another start each,
pub const NEAR_MISS: f64 = 0.9;
/// with so much of the unexplained force,
pub const SHARPER: f64 = 0.1;
/// and so many steps before that is adapted, as long as each gains.
pub const SHARP_STEPS: usize = 4;
/// Steps of a search along a shape with everything else fitted anew; each goes one way or
/// halves its length.
pub const SHAPE_STEPS: usize = 10;

/// Times that a sensor may be late by, as shares of the time that the motion of the coordinate
/// takes for a radian of its mean wave.
pub const LATE: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8];
/// Share of what the best fit gains that such a time must bring to be fitted itself.
pub const WORTH_A_FIT: f64 = 0.5;
/// Samples by which other fits of a late input begin later, where something feels its jumps. With none, the
/// held drive of a pendulum that is 13 ms late, at 200 Hz, ends at 17.9 ms.
pub const LATER: [f64; 4] = [-1.0, -0.5, 0.5, 1.0];

/// Share of the squares of missing forces that effects must explain in the balance of forces, which cannot
/// tell forces that last from laws.
pub const WORTH_IT: f64 = 0.5;
/// Share of what the inputs exert below which a term, wherever it acts, is not named in the balance of
/// forces: no torque is measured that exactly.
pub const WORTH_A_NAME: f64 = 1e-3;
/// Share of what is missing that many findings in the balance leave where motion need not be asked.
pub const NEARLY_NOTHING: f64 = 0.1;

/// Standard deviations by which the signed ranks of what the runs of a log gain must lie above chance,
/// where findings must make data likelier that nothing was fitted to.
pub const SURE: f64 = 2.0;

/// Standard errors, of both fits together, by which a value may change where a term that has lost its name is left
/// out. Without it a wrong inertia and a spring were written for a friction that had lost its name.
pub const SAME_VALUE: f64 = 3.0;
