"""Machine code gives the numbers of the tapes.

To rounding, not bit for bit: in what is emitted each function has signs of its own, and terms that so come to stand
side by side are added up first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import dynamics
import numpy as np
import pytest
from conftest import MODELS
from test_equations import NAMES, states


@pytest.mark.parametrize("name", [name for name in NAMES if name != "bead.model"])
def test_every_model_is_the_same_compiled(name: str) -> None:
    model = dynamics.Model.load(MODELS / name)
    if model.states:
        pytest.skip("machine code has no memory")
    parameters = {name: 1.1 * value for name, value in model.parameters.items()}
    model = model.with_parameters(parameters)
    fast = model.compile(options=["-O1"])
    assert fast.is_compiled
    assert not model.is_compiled
    at = states(model, 100)
    q, v, t = at["q"], at["v"], at["t"]
    calls: dict[str, Callable[[dynamics.Model], Any]] = {
        "M": lambda m: m.mass_matrix(q, t=t),
        "bias": lambda m: m.bias_force(q, v, t=t),
        "applied": lambda m: m.applied_force(q, v, t=t),
        "B": lambda m: m.input_matrix(q, v, t=t),
        "tau": lambda m: m.inverse_dynamics(q, v, -v, t=t),
        "still": lambda m: m.inverse_dynamics(q, v[0], v[1], t=0.5),
        "A": lambda m: m.constraint_jacobian(q, v, t=t),
        "b": lambda m: m.constraint_bias(q, v, t=t),
        "c": lambda m: m.constraint_residual(q, v, t=t),
        "c_dot": lambda m: m.constraint_rate(q, v, t=t),
        "a": lambda m: m.forward_dynamics(q, v, at["u"], t=t),
    }
    for key, call in calls.items():
        expected = call(model)
        least = 1e-15 * np.abs(expected).max(initial=0.0)
        np.testing.assert_allclose(call(fast), expected, 1e-13, least, err_msg=f"{name}: {key}")


def test_parameters_and_cores_are_those_of_the_call() -> None:
    model = dynamics.Model.load(MODELS / "pendulum2.model")
    fast = model.compile(options=[])
    name = next(iter(model.parameters))
    other = fast.with_parameters({name: 3.0 * model.parameters[name]})
    assert other.is_compiled
    q = states(model, 5000)["q"]
    np.testing.assert_array_equal(
        other.mass_matrix(q, parallel=True),
        model.with_parameters(other.parameters).mass_matrix(q),
    )


def test_what_cannot_be_compiled_is_explained() -> None:
    bead = dynamics.Model.load(MODELS / "bead.model")
    with pytest.raises(dynamics.Error, match="internal states or delays"):
        bead.compile()
    model = dynamics.Model.load(MODELS / "pendulum.model")
    with pytest.raises(dynamics.Error, match="cannot be called"):
        model.compile(compiler="no-such-compiler")
    with pytest.raises(dynamics.Error, match="fails"):
        model.compile(options=["--no-such-option"])
