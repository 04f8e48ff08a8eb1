"""A plain regression: least squares of what the model leaves of the forces on friction and an offset per joint."""

import numpy as np

from machines import residual, scoring
from machines.answer import Answer, clock, number

NAMES = ("viscous", "Coulomb", "offset")
LITTLE = 0.1
"""Of what is left of a joint's force, by its spread: less is not mentioned."""


def features(v):
    """Of one joint: viscous friction, dry friction, a constant."""
    return np.column_stack([-v, -np.sign(v), np.ones_like(v)])


def answer(machine, train, task):
    """The answer of the regression."""
    with clock() as spent:
        left = residual.left(machine, train)
        # a user writes this
        columns = range(left.shape[1])
        fits = [np.linalg.lstsq(features(train.v[:, i]), left[:, i])[0] for i in columns]
        # up to here
    def law(q, v, u):
        return np.column_stack([features(v[:, i]) @ fits[i] for i in columns])

    error = scoring.error(task, residual.predict(machine, task, law))
    return Answer("plain regression", error, spent[0], said(machine.system.coords, train.v, left, fits))


def said(joints, v, left, fits):
    """Coefficients, less those that make up little of what is left."""
    found = []
    for i, (joint, fit) in enumerate(zip(joints, fits)):
        shares = (features(v[:, i]) * fit).std(axis=0) + abs(fit) * [0, 0, 1]
        there = [f"{name} {number(x)}" for name, x, share in zip(NAMES, fit, shares) if share > LITTLE * left[:, i].std()]
        found += [f"{joint}: {', '.join(there)}"] if there else []
    return "; ".join(found) or "little of anything"
