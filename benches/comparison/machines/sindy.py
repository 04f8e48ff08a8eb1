"""PySINDy: a sparse law for what the model leaves of the forces, from polynomials, sines, cosines and signs.

The whole motion, without a model, is out of reach of a library: it is the inverse of a mass matrix. So PySINDy is
given what its users give it where a model is at hand, the residual force. The threshold is swept, as its authors
advise; the last third of the log says which is best.
"""

import warnings

import numpy as np
import pysindy as ps

from machines import residual, scoring
from machines.answer import Answer, clock, number
from oracle import filtered

THRESHOLDS = np.geomspace(1e-3, 1, 13)


def learn(x, u, left, step):
    """The sparsest law that predicts the last third within a twentieth of the best; nothing counts as a law."""
    # a user writes this
    library = ps.PolynomialLibrary(degree=2) + ps.FourierLibrary(n_frequencies=1) + ps.CustomLibrary(
        [lambda x: np.sign(x)], function_names=[lambda name: f"sign({name})"])
    cut, tried = 2 * len(x) // 3, []
    for threshold in THRESHOLDS:
        model = ps.SINDy(optimizer=ps.STLSQ(threshold=threshold), feature_library=library)
        model.fit(x[:cut], t=step, x_dot=left[:cut], u=u[:cut])
        terms = np.count_nonzero(model.coefficients())
        tried.append((np.std(left[cut:] - model.predict(x[cut:], u=u[cut:])), terms, model))
    tried.append((np.std(left[cut:]), 0, None))
    best = min(error for error, _, _ in tried)
    law = min((t for t in tried if t[0] <= 1.05 * best), key=lambda t: t[1])[2]
    # up to here
    return law


def answer(machine, train, task):
    """The answer of PySINDy."""
    names = [*(f"q_{c}" for c in machine.system.coords), *(f"v_{c}" for c in machine.system.coords),
             *(f"u_{c}" for c in machine.system.inputs)]
    with clock() as spent, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        left = residual.left(machine, train)
        # Each joint by its own measure, so that one threshold is right for all.
        scale = left.std(axis=0)
        x, u = np.hstack([train.q, train.v]), filtered(train.log.u, train.rate)
        model = learn(x, u, left / scale, 1 / train.rate)

    def law(q, v, u):
        return scale * model.predict(np.hstack([q, v]), u=u) if model else np.zeros_like(q)

    error = scoring.error(task, residual.predict(machine, task, law))
    terms = []
    if model:
        features = model.feature_library.get_feature_names(names)
        for joint, row, size in zip(machine.system.coords, model.coefficients(), scale):
            there = [f"{number(size * c)} {name}" for name, c in zip(features, row) if c]
            if there:
                shown = " + ".join(there[:4]) + (f" and {len(there) - 4} more terms" if len(there) > 4 else "")
                terms.append(f"{joint}: {shown}")
    return Answer("PySINDy", error, spent[0], "; ".join(terms) or "nothing")
