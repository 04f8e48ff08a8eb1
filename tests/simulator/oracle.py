"""What the true and the nominal model reach on a log, and what looks like the truth.

States: Savitzky-Golay (order 4, 0.15 s). Measured acceleration: ddq if logged, else
the filter's derivative of dq, else its second derivative of q. Predictions are smoothed
with the same filter unless ddq is logged. nrmse = sqrt(mean_i (rmse_i / sd_i)^2).
"""

import math

import numpy as np

import rollout

WINDOW_S = 0.15
ORDER = 4


def smoother(rate, derivative):
    """Filter weights of the given derivative at the window's centre."""
    half = max(ORDER // 2 + 1, round(WINDOW_S * rate / 2))
    x = np.arange(-half, half + 1)
    fit = np.linalg.pinv(np.vander(x / half, ORDER + 1, increasing=True))
    return fit[derivative] * math.factorial(derivative) * (rate / half)**derivative


def filtered(signal, rate, derivative=0):
    """The filter applied to each column; loses half a window at both ends."""
    weights = smoother(rate, derivative)[::-1]
    return np.stack([np.convolve(column, weights, mode="valid") for column in signal.T], axis=1)


class Log:
    """A simulated log with what an estimator would make of it."""

    def __init__(self, machine, run, measured, torques):
        self.torques = torques
        rate, self.machine, self.run = machine.rate, machine, run
        blank, count = machine.margin(), len(run.q)
        q, dq, ddq = (None if k not in measured else measured[k][blank:count - blank] for k in ("q", "dq", "ddq"))
        self.half = (len(smoother(rate, 0)) - 1) // 2
        self.inner = slice(blank + self.half, count - blank - self.half)
        self.t = np.arange(count) / rate
        self.q = filtered(q, rate)
        self.v = filtered(dq, rate) if dq is not None else filtered(q, rate, 1)
        if ddq is not None:
            self.a = ddq[self.half:-self.half]
        else:
            self.a = filtered(dq, rate, 1) if dq is not None else filtered(q, rate, 2)
        self.smooth = ddq is None
        self.scale = self.a.std(axis=0)

    def prediction(self, p, effects, z):
        """Accelerations of a model at the estimated states, at the samples of `a`."""
        m = self.machine
        kinds, targets, numbers = effects
        u = rollout.input_series(self.torques, 1 / m.rate, m.first_order, *effects)
        if not m.first_order and self.smooth:
            u = (u + np.vstack([u[:1], u[:-1]])) / 2  # a sample sees both halves of a held input
        found = rollout.predict(m.system.code, p, m.system.constraints, m.driven, kinds, targets, numbers,
                                self.q, self.v, self.t[self.inner], u[self.inner], z[self.inner])
        return found

    def error(self, p, effects, z):
        """(nrmse, rmse per coordinate) of a model on this log."""
        residual = self.a - self.prediction(p, effects, z)
        if self.smooth:
            residual = filtered(self.a - residual, self.machine.rate)
            residual = self.a[self.half:-self.half] - residual
        rmse = np.sqrt((residual**2).mean(axis=0))
        return float(np.sqrt(np.mean((rmse / self.scale)**2))), rmse


def signature(machine, run, p, effects, z, every=5):
    """Accelerations of a model along the noise-free states, scaled by each one's spread."""
    u = rollout.input_series(run.command, 1 / machine.rate, machine.first_order, *effects)
    t = np.arange(len(run.q)) / machine.rate
    pick = slice(0, None, every)
    found = rollout.predict(machine.system.code, p, machine.system.constraints, machine.driven, *effects,
                            run.q[pick], run.v[pick], t[pick], u[pick], z[pick])
    return (found / run.a.std(axis=0)).ravel()


def similarity(x, y):
    """(share of x that a multiple of y explains, its sign)."""
    size = (x @ x) * (y @ y)
    return (0.0, 0.0) if size == 0 else ((x @ y)**2 / size, float(np.sign(x @ y)))
