"""One definition of error for all: open-loop predictions of the held-out log over one second.

A prediction starts every half second from the state that a smoothing filter makes of the measured positions, the same
for all, and sees nothing after that but the logged inputs, before its start too. Its error is the difference from the
measured positions. Errors of a coordinate are divided by its spread over the log; what is stated is the root mean square
over all samples of all predictions and over the coordinates. The floor is the error of the true machine, with the same
starting states.
"""

from dataclasses import dataclass

import numpy as np

from machines import eight
from compiled import njit
from oracle import filtered, smoother
from plant import acceleration, terms
import effects as fx
from systems import no_effects

SECOND, EVERY = 1.0, 0.5
STEP = 2.5e-3
"""Integration step, s."""


@dataclass
class Task:
    """A log with what a filter makes of it."""

    log: eight.Log
    rate: float
    half: int
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray

    @property
    def u(self):
        """Inputs at the samples of q, v, a."""
        return self.log.u[self.half:len(self.log.u) - self.half]

    @property
    def t(self):
        """Times of the samples of q, v, a."""
        return self.log.t[self.half:len(self.log.t) - self.half]

    def starts(self, length=SECOND, every=EVERY):
        """Numbers of samples of `q` that predictions start from, and how many samples they take."""
        count = round(length * self.rate)
        return np.arange(0, len(self.q) - count, round(every * self.rate)), count


def prepare(machine, which):
    """A log and its smoothed states: Savitzky-Golay, order 4, 0.15 s."""
    log, rate = eight.read(machine, which), machine.simulated.rate
    half = (len(smoother(rate, 0)) - 1) // 2
    return Task(log, rate, half, filtered(log.q, rate), filtered(log.q, rate, 1), filtered(log.q, rate, 2))


def error(task, predicted):
    """The error of predictions, an array of (starts, samples, coordinates)."""
    starts, count = task.starts()
    measured = task.log.q[task.half:]
    gaps = np.stack([predicted[k, 1:] - measured[s + 1:s + count + 1] for k, s in enumerate(starts)])
    gaps = np.where(np.isfinite(gaps), gaps, 1e6) / task.log.q.std(axis=0)
    return float(np.sqrt(np.mean(gaps**2)))


def integrate(task, rates, late=0.0):
    """Predictions by the classical Runge-Kutta method; `rates(q, v, u)` gives accelerations of many states at once."""
    starts, count = task.starts()
    finer = max(1, round(1 / (task.rate * STEP)))
    h = 1 / task.rate / finer
    q, v = task.q[starts].copy(), task.v[starts].copy()
    found = [q.copy()]
    column = range(task.log.u.shape[1])

    def inputs(time):
        return np.stack([np.interp(time - late, task.log.t, task.log.u[:, j]) for j in column], axis=1)

    t = task.t[starts]
    for k in range(count):
        for s in range(finer):
            now = t + (k * finer + s) * h
            u1, u2, u3 = inputs(now), inputs(now + h / 2), inputs(now + h)
            a1 = rates(q, v, u1)
            a2 = rates(q + h / 2 * v, v + h / 2 * a1, u2)
            a3 = rates(q + h / 2 * (v + h / 2 * a1), v + h / 2 * a2, u2)
            a4 = rates(q + h * (v + h / 2 * a2), v + h * a3, u3)
            q = q + h * v + h * h / 6 * (a1 + a2 + a3)
            v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        found.append(q.copy())
    return np.stack(found, axis=1)


@njit()
def _terms(system, p, q, v, kinds, targets, numbers):
    """Mass matrix and force at rest of the inputs, of many states."""
    count, n = q.shape
    mass, force = np.zeros((count, n, n)), np.zeros((count, n))
    A, b, c, rate = np.zeros((0, n)), np.zeros(0), np.zeros(0), np.zeros(0)
    for k in range(count):
        terms(system, p, q[k], v[k], 0.0, kinds, targets, numbers, mass[k], force[k], A, b, c, rate)
    return mass, force


def nominal_terms(machine, q, v):
    """M and Q of `M a = Q + B u`, of the machine's model at many states."""
    p = machine.system.vector(machine.nominal)
    return _terms(machine.system.code, p, q, v, *no_effects())


def spread(machine, u):
    """B u: inputs at the coordinates that they drive."""
    found = np.zeros((len(u), len(machine.system.coords)))
    found[:, list(machine.system.driven)] = u
    return found


@njit()
def _accelerations(system, p, driven, kinds, targets, numbers, q, v, u):
    found, none, z = np.empty_like(q), np.zeros(q.shape[1]), np.zeros(len(kinds))
    for k in range(len(q)):
        found[k] = acceleration(system, p, 0, driven, kinds, targets, numbers, q[k], v[k], 0.0, u[k], z, none)[0]
    return found


def of_simulator(machine, task, effects):
    """Predictions of the simulator's own machine with these effects; none: of the model."""
    p = machine.system.vector(machine.simulated.true_parameters(effects))
    late = sum(e.parameters()["tau"] for e in effects if e.kind.name == "input_delay")
    acting = fx.encode([e for e in effects if e.kind.name != "input_delay"])
    driven = machine.simulated.driven
    return integrate(task, lambda q, v, u: _accelerations(machine.system.code, p, driven, *acting, q, v, u), late)


def before(machine, task):
    """The model's error."""
    return error(task, of_simulator(machine, task, []))


def floor(machine, task):
    """The true machine's error."""
    return error(task, of_simulator(machine, task, machine.simulated.effects))
