"""`trace` and `fit`: what logs say about a model."""

from __future__ import annotations

import os
from collections.abc import Sequence

from dynamics import _native
from dynamics._logs import Logs, recordings
from dynamics._native import Model
from dynamics._results import Fit, Trace
from dynamics._types import File


def trace(
    model: Model | File,
    logs: Logs,
    test: Logs | None = None,
    *,
    map: File | None = None,
    hold: str | None = None,
    horizon: float = 0.5,
    seed: int = 1,
    time_limit: float = 600.0,
    trust_columns: bool = False,
) -> Trace:
    """Finds what a model lacks, as `dynamics trace` does, with the same numbers.

    Ctrl-C ends it with `KeyboardInterrupt`. Other threads run meanwhile.

    Args:
        model: the model, or its file.
        logs: the recordings to learn from; see `Log`.
        test: other recordings of the machine, to judge by; without them the last third of
            `logs` is kept apart.
        map: a TOML file that says what the columns are; without it, `LOG.toml` beside a file.
        hold: what inputs do between samples, `"linear"` or `"previous"`; found if left out.
        horizon: how long open-loop predictions run, s.
        seed: seed of everything random.
        time_limit: after so many seconds the search ends with the best that it has.
        trust_columns: whether to search although columns look mistaken.

    Returns:
        Verdict, findings, the change to the model, curves.

    Raises:
        dynamics.Error: if model and logs cannot be used together; the message says the place,
            what was expected and how to mend it.
        TypeError: if a log is none.
    """
    known = _model(model)
    return Trace(
        _native.trace(
            known,
            recordings(logs, "logs", known),
            recordings(test, "test", known),
            map,
            hold,
            horizon,
            seed,
            time_limit,
            trust_columns,
            f"dynamics.trace({os.fspath(known.path)!r}, …, seed={seed})",
        )
    )


def fit(
    model: Model | File,
    logs: Logs,
    test: Logs | None = None,
    *,
    map: File | None = None,
    inertia: str = "consistent",
    leave_out: Sequence[str] = (),
    trust_columns: bool = False,
) -> Fit:
    """Fits inertias, friction and couplings to measured forces, as `dynamics fit` does.

    Ctrl-C ends the wait with `KeyboardInterrupt`. Other threads run meanwhile.

    Args:
        model: the model, or its file.
        logs: the recordings to learn from; see `Log`.
        test: other recordings of the machine, to judge by; without them the last third of
            `logs` is kept apart.
        map: a TOML file that says what the columns are; without it, `LOG.toml` beside a file.
        inertia: how inertial parameters are treated: `"consistent"`, only what a rigid body can
            have; `"linear"`, any numbers; `"fixed"`, as the model has them.
        leave_out: coordinates whose efforts are not to be learnt from.
        trust_columns: whether to learn from efforts although they look like no forces of their
            joints.

    Returns:
        Terms, inertial parameters, errors, the change to the model, curves.

    Raises:
        dynamics.Error: if model and logs cannot be used together; the message says the place,
            what was expected and how to mend it.
        TypeError: if a log is none.
    """
    known = _model(model)
    return Fit(
        _native.fit(
            known,
            recordings(logs, "logs", known),
            recordings(test, "test", known),
            map,
            (inertia, list(leave_out), trust_columns),
            f"dynamics.fit({os.fspath(known.path)!r}, …, inertia={inertia!r})",
        )
    )


def _model(model: Model | File) -> Model:
    return model if isinstance(model, Model) else Model.load(model)
