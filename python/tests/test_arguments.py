"""No argument ends the interpreter: what does not fit is an exception that says why."""

from __future__ import annotations

import inspect
import os
import signal
import threading
import time
from pathlib import Path
from typing import Any

import dynamics
import numpy as np
import pytest
from conftest import MODELS

CALLS = 100_000 if os.environ.get("CI") else 10_000
METHODS = [
    "mass_matrix",
    "bias_force",
    "applied_force",
    "input_matrix",
    "inverse_dynamics",
    "forward_dynamics",
    "multipliers",
    "constraint_jacobian",
    "constraint_bias",
    "constraint_residual",
    "constraint_rate",
    "state_rates",
    "outputs",
    "derivatives",
]


def test_wrong_arguments_are_explained() -> None:
    model = dynamics.Model.load(MODELS / "pendulum2.model")
    with pytest.raises(dynamics.Error, match=r"\(…, 2\), not \(3,\).*j1, j2"):
        model.mass_matrix([1.0, 2.0, 3.0])
    with pytest.raises(dynamics.Error, match=r"q\[1, 0\]. is NaN"):
        model.mass_matrix([[0.0, 0.0], [np.nan, 0.0]])
    with pytest.raises(dynamics.Error, match="inf"):
        model.bias_force([0.0, 0.0], [0.0, np.inf])
    with pytest.raises(dynamics.Error, match=r"`q` holds a batch of the shape \(3,\)"):
        model.bias_force(np.zeros((3, 2)), np.zeros((4, 2)))
    wrongs: list[Any] = [["a", "b"], [1j, 0], [None, None], [object(), 0.0], [True, False]]
    for wrong in wrongs:
        with pytest.raises(TypeError, match="real numbers"):
            model.mass_matrix(wrong)
    with pytest.raises(ValueError, match="inhomogeneous"):
        model.mass_matrix([[1.0], [1.0, 2.0]])
    with pytest.raises(dynamics.Error, match="no parameter `mass`"):
        model.with_parameters({"mass": 1.0})
    with pytest.raises(dynamics.Error, match="duration"):
        model.simulate([0.0, 0.0], duration=-1.0)


def test_mistakes_in_models_are_located(tmp_path: Path) -> None:
    path = tmp_path / "wrong.model"
    path.write_text("model wrong;\ncoordinate x: m;\nkinetic dot(x)^2 +;\n")
    with pytest.raises(dynamics.Error, match=r"wrong\.model:3") as caught:
        dynamics.Model.load(path)
    assert isinstance(caught.value, ValueError)
    with pytest.raises(dynamics.Error, match="no such file"):
        dynamics.Model.load(tmp_path / "none.model")


def test_a_state_without_a_motion_is_named(tmp_path: Path) -> None:
    path = tmp_path / "point.model"
    text = "model point;\ncoordinate x: m;\nparameter m: kg = 1 in 0..;\nkinetic m/2*dot(x)^2;\n"
    path.write_text(text)
    model = dynamics.Model.load(path).with_parameters({"m": 0.0})
    with pytest.raises(dynamics.SolveError, match="sample 0"):
        model.forward_dynamics(np.zeros((4, 1)))


def test_random_calls_end_in_arrays_or_exceptions() -> None:
    rng = np.random.default_rng(11)
    names = ["pendulum2.model", "duffing_constrained.model", "fourbar.model", "unicycle2d.model"]
    models = [dynamics.Model.load(MODELS / name) for name in names]
    answered = 0
    for _ in range(CALLS):
        model = models[rng.integers(len(models))]
        method = getattr(model, METHODS[rng.integers(len(METHODS))])
        parameters = list(inspect.signature(method).parameters)
        arguments = {name: odd(rng, model) for name in parameters if rng.random() < 0.8}
        arguments.pop("parallel", None)
        try:
            answer = method(**arguments)
        except (ValueError, TypeError):
            continue
        answered += 1
        if isinstance(answer, np.ndarray):
            assert answer.dtype == np.float64
    assert answered > CALLS // 100


def odd(rng: np.random.Generator, model: dynamics.Model) -> Any:
    """An argument that may or may not be one."""
    n = len(model.coordinates)
    width = int(rng.choice([n, n, n, n, n, len(model.inputs), 0, n + 1]))
    shape = [(), (0,), (2,), (2,), (3, 1)][rng.integers(5)]
    values = rng.standard_normal((*shape, width))
    match rng.integers(24):
        case 0:
            return np.full_like(values, rng.choice([np.nan, np.inf, -np.inf]))
        case 1:
            return values.astype(rng.choice(["f4", "i2", "c16", "O", "U3", ">f8", "?", "M8[s]"]))
        case 2:
            return np.asfortranarray(values)
        case 3:
            return values.tolist()
        case 4:
            return [None, "text", {}, 3.0, [[]], [[1.0], [1.0, 2.0]], b"1", object()][rng.integers(8)]
        case 5:
            return values[..., ::-1]
        case 6:
            return 1e300 * values
        case 7:
            return np.broadcast_to(values, (2, *values.shape))
        case _:
            return values


def test_ctrl_c_ends_a_simulation() -> None:
    model = dynamics.Model.load(MODELS / "pendulum2.model")
    # A shell that starts tests in the background has them ignore Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    timer.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        model.simulate([1.0, 0.0], duration=9e4)
    assert time.monotonic() - begin < 60


def test_other_threads_run_meanwhile() -> None:
    model = dynamics.Model.load(MODELS / "iiwa7.urdf")
    q = np.zeros((400_000, 7))
    ticks = 0
    thread = threading.Thread(target=model.mass_matrix, args=(q,))
    thread.start()
    while thread.is_alive():
        ticks += 1
        time.sleep(0.001)
    assert ticks > 5


def test_every_public_name_says_what_it_is() -> None:
    for name in dynamics.__all__:
        value = getattr(dynamics, name)
        if not (inspect.isclass(value) or inspect.isroutine(value)):
            continue
        assert inspect.getdoc(value), name
        for member, of in vars(value).items() if inspect.isclass(value) else []:
            if not member.startswith("_"):
                assert inspect.getdoc(of), f"{name}.{member}"
