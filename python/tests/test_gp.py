"""A force that the model lacks is learnt, and what is predicted obeys the constraints."""

from __future__ import annotations

from typing import Any

import dynamics
import numpy as np
import pandas as pd
import pytest
from conftest import MODELS
from dynamics.gp import LatentForceRegressor

Array = np.ndarray[Any, np.dtype[np.float64]]


def sliding(count: int, seed: int) -> tuple[dynamics.Model, Array, Array, Array]:
    """A particle on its surface that air brakes; states, accelerations and multipliers."""
    model = dynamics.Model.load(MODELS / "surface_particle.model")
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-1.0, 1.0, (2, count, 3))
    # Velocities along the surface: what the multipliers' rows let pass.
    rows = model.constraint_jacobian(q)
    v -= np.einsum("...mi,...m->...i", rows, np.einsum("...mi,...i->...m", rows, v)) / (
        (rows**2).sum(axis=(-1, -2))[:, None]
    )
    u = 0.5 * rng.standard_normal((count, len(model.inputs)))
    brake = -0.6 * np.linalg.norm(v, axis=1, keepdims=True) * v
    truth = model.forward_dynamics(q, v, u + brake)
    multipliers = model.multipliers(q, v, u + brake)
    return model, np.hstack([q, v, u]), truth, multipliers


def test_a_braking_force_is_learnt_under_a_constraint() -> None:
    model, x, y, _ = sliding(80, 1)
    noisy = y + 0.005 * np.random.default_rng(3).standard_normal(y.shape)
    learnt = LatentForceRegressor(model, columns=["dq_x", "dq_y", "dq_z"]).fit(x, noisy)
    _, at, truth, multipliers = sliding(50, 2)
    q, v, u = np.split(at, [3, 6], axis=1)
    mean, std = learnt.predict(at, return_std=True)
    assert mean.shape == std.shape == truth.shape
    known = model.forward_dynamics(q, v, u)
    assert np.abs(mean - truth).max() < 0.2 * np.abs(known - truth).max()
    assert np.mean(np.abs(mean - truth) < 3 * std) > 0.9
    rows, bias = model.constraint_jacobian(q, v), model.constraint_bias(q, v)
    np.testing.assert_allclose(np.einsum("...mi,...i->...m", rows, mean), bias, atol=1e-9)
    pushed, doubt = learnt.predict(at, return_std=True, quantity="multiplier")
    assert np.mean(np.abs(pushed - multipliers) < 3 * doubt) > 0.9
    assert learnt.score(at, truth) > 0.99
    assert learnt.length_scales_.shape == (3, 3)
    assert np.all(learnt.noise_ < 0.02)


def test_frames_and_arrays_are_the_same() -> None:
    model, x, y, _ = sliding(30, 1)
    learner = LatentForceRegressor(model, points=20, restarts=1)
    names = learner._names()
    frame = pd.DataFrame(x, columns=names).assign(other="text")
    outputs = pd.DataFrame(y, columns=[f"ddq_{c}" for c in model.coordinates])
    first = learner.fit(x, y).predict(x)
    np.testing.assert_array_equal(learner.fit(frame, outputs).predict(frame), first)
    assert learner.columns_ == names[:6]
    assert learner.predict(x[:0]).shape == (0, 3)
    assert learner.predict(x, quantity="missing_force").shape == (30, 3)


def test_mistakes_are_explained() -> None:
    model, x, y, _ = sliding(10, 1)
    learner = LatentForceRegressor(model)
    with pytest.raises(dynamics.Error, match="call `fit` first"):
        learner.predict(x)
    with pytest.raises(dynamics.Error, match="same number of rows"):
        learner.fit(x, y[:5])
    with pytest.raises(dynamics.Error, match="no column `dq_w`"):
        learner.set_params(columns=["dq_w"]).fit(x, y)
    with pytest.raises(dynamics.Error, match="no parameter `depth`"):
        learner.set_params(depth=3)
    with pytest.raises(dynamics.Error, match="NaN"):
        learner.set_params(columns=None).fit(np.full_like(x, np.nan), y)
    with pytest.raises(dynamics.Error, match="lacks the columns q_x"):
        learner.fit(pd.DataFrame({"t": [0.0]}), y)
    with pytest.raises(dynamics.Error, match="quantity"):
        learner.fit(x, y).predict(x, quantity="jerk")
