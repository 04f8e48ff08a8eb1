"""What a model leaves of the forces, and predictions with a law for it."""

import numpy as np

from machines import scoring
from oracle import filtered


def left(machine, task):
    """M a − Q − B u along a log: the force that the model lacks. Inputs are smoothed as the states are."""
    mass, force = scoring.nominal_terms(machine, task.q, task.v)
    applied = scoring.spread(machine, filtered(task.log.u, task.rate))
    return np.einsum("kij,kj->ki", mass, task.a) - force - applied


def predict(machine, task, law):
    """Predictions of the model with a force `law(q, v, u)` of many states at once."""

    def rates(q, v, u):
        mass, force = scoring.nominal_terms(machine, q, v)
        force = force + scoring.spread(machine, u) + law(q, v, u)
        return np.linalg.solve(mass, force[:, :, None])[:, :, 0]

    return scoring.integrate(task, rates)
