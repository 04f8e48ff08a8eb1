"""Numbers are those of `dynamics eval` and `dynamics simulate`, bit for bit."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import dynamics
import numpy as np
import pytest
from conftest import MODELS, Command

NAMES = sorted(path.name for path in MODELS.iterdir() if path.is_file())
BATCH = 5


def states(model: dynamics.Model, *shape: int) -> dict[str, np.ndarray[Any, np.dtype[np.float64]]]:
    """Random states near the model's middle."""
    rng = np.random.default_rng(7)
    n, k = len(model.coordinates), len(model.inputs)
    return {
        "q": 0.3 + 0.4 * rng.random((*shape, n)),
        "v": rng.standard_normal((*shape, n)),
        "u": rng.standard_normal((*shape, k)),
        "t": rng.random(shape),
    }


@pytest.mark.parametrize("name", NAMES)
def test_every_model_is_evaluated_as_by_the_command_line(
    name: str, evaluated: Callable[..., list[dict[str, Any]]]
) -> None:
    path = MODELS / name
    model = dynamics.Model.load(path)
    at = states(model, BATCH)
    q, t = at["q"], at["t"]
    turning, moving = (q, at["v"]), (q, at["v"], at["u"])
    derivatives = model.derivatives(*moving, t=t)
    ours = {
        "M": model.mass_matrix(q, t=t),
        "bias": model.bias_force(*turning, t=t),
        "applied": model.applied_force(*turning, t=t),
        "B": model.input_matrix(*turning, t=t),
        "A": model.constraint_jacobian(*turning, t=t),
        "b": model.constraint_bias(*turning, t=t),
        "c": model.constraint_residual(*turning, t=t),
        "c_dot": model.constraint_rate(*turning, t=t),
        "a": model.forward_dynamics(*moving, t=t),
        "lambda": model.multipliers(*moving, t=t),
        "da_dq": derivatives.a_q,
        "da_dv": derivatives.a_v,
        "da_du": derivatives.a_u,
        "da_dt": derivatives.a_t,
        "dlambda_dq": derivatives.lambda_q,
        "dlambda_dv": derivatives.lambda_v,
        "dlambda_du": derivatives.lambda_u,
        "dlambda_dt": derivatives.lambda_t,
    }
    if name == "bead.model":
        # Its friction depends on a multiplier: `applied_force` leaves that part out.
        del ours["applied"]
    theirs = evaluated(path, **at)
    assert len(theirs) == BATCH
    for key, values in ours.items():
        expected = np.array([answer[key] for answer in theirs]).reshape(values.shape)
        np.testing.assert_array_equal(values, expected, err_msg=f"{name}: {key}")


def test_inverse_dynamics_undoes_forward_dynamics() -> None:
    model = dynamics.Model.load(MODELS / "panda.urdf")
    at = states(model, 3)
    a = model.forward_dynamics(at["q"], at["v"], at["u"])
    tau = model.inverse_dynamics(at["q"], at["v"], a)
    applied = np.einsum("...ij,...j->...i", model.input_matrix(at["q"], at["v"]), at["u"])
    np.testing.assert_allclose(tau, applied, atol=1e-9)


def test_a_batch_is_its_states_one_by_one() -> None:
    """Also across blocks and chunks, in any shape and on all cores."""
    model = dynamics.Model.load(MODELS / "ur5.urdf")
    at = states(model, 3, 700)
    q, v, u = at["q"], at["v"], at["u"]
    calls: dict[str, Callable[..., Any]] = {
        "M": lambda i, **how: model.mass_matrix(q[i], **how),
        "bias": lambda i, **how: model.bias_force(q[i], v[i], **how),
        "a": lambda i, **how: model.forward_dynamics(q[i], v[i], u[i], **how),
    }
    for call in calls.values():
        whole = call(...)
        assert whole.shape[:2] == (3, 700)
        np.testing.assert_array_equal(whole, call(..., parallel=True))
        for index in [(0, 0), (1, 63), (1, 64), (2, 699)]:
            np.testing.assert_array_equal(whole[index], call(index))


def test_what_has_no_batch_holds_for_all() -> None:
    model = dynamics.Model.load(MODELS / "ur5.urdf")
    at = states(model, 4)
    one = at["v"][0]
    np.testing.assert_array_equal(
        model.bias_force(at["q"], one), model.bias_force(at["q"], np.tile(one, (4, 1)))
    )
    np.testing.assert_array_equal(
        model.forward_dynamics(at["q"], one), model.forward_dynamics(at["q"], one, np.zeros(6))
    )


def test_layouts_and_types_make_no_difference() -> None:
    model = dynamics.Model.load(MODELS / "ur5.urdf")
    q = states(model, 6)["q"]
    expected = model.mass_matrix(q)
    for same in [np.asfortranarray(q), q.tolist(), q[::-1][::-1], q.astype(">f8")]:
        np.testing.assert_array_equal(model.mass_matrix(same), expected)
    whole = np.ones(6, dtype=np.int32)
    np.testing.assert_array_equal(model.mass_matrix(whole), model.mass_matrix(np.ones(6)))


def test_parameters_are_replaced() -> None:
    model = dynamics.Model.load(MODELS / "pendulum2.model")
    name = next(iter(model.parameters))
    other = model.with_parameters({name: 2.0 * model.parameters[name]})
    assert other.parameters[name] == 2.0 * model.parameters[name]
    loaded = dynamics.Model.load(MODELS / "pendulum2.model", parameters=other.parameters)
    q = [0.3, 0.5]
    np.testing.assert_array_equal(other.mass_matrix(q), loaded.mass_matrix(q))
    assert not np.array_equal(other.mass_matrix(q), model.mass_matrix(q))


def test_simulations_are_those_of_the_command_line(command: Command, tmp_path: Path) -> None:
    path, out, inputs = MODELS / "cartpole.model", tmp_path / "log.csv", tmp_path / "u.csv"
    model = dynamics.Model.load(path)
    (force,) = model.inputs
    times, values = [0.0, 0.4, 1.0], [[0.5], [-1.0], [2.0]]
    rows = [f"{t},{u[0]}" for t, u in zip(times, values, strict=True)]
    inputs.write_text("\n".join([f"t,u_{force}", *rows]) + "\n")
    begin = '{"q": [0.1, 0.4], "v": [0, 0.3]}'
    rest = ("--inputs", inputs, "--duration", 1, "--rate", 50, "--out", out)
    command("simulate", path, "--init", begin, *rest)
    motion = model.simulate(
        [0.1, 0.4], [0.0, 0.3], values, input_times=times, duration=1.0, rate=50.0
    )
    with out.open() as file:
        header, *lines = list(csv.reader(file))
    columns = motion.columns()
    assert list(columns) == header
    np.testing.assert_array_equal(
        np.column_stack(list(columns.values())), np.array(lines, dtype=np.float64)
    )
