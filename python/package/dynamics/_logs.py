"""Logs as people have them: files, frames, arrays by name."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias, cast

import numpy as np

from dynamics._native import Error, Model
from dynamics._types import Array, File, Recording


class Frame(Protocol):
    """A table with named columns, as those of pandas and polars are."""

    @property
    def columns(self) -> Any:
        """The names of the columns."""

    def __getitem__(self, name: Any, /) -> Any:
        """A column."""


Log: TypeAlias = File | Frame | Mapping[str, Any] | np.ndarray[Any, Any]
"""A recording.

A file of any format that `dynamics trace` reads; a frame of pandas or polars; arrays by name; a
structured array. Columns are `t` [s], `q_<coordinate>`, `u_<input>` and, if measured,
`dq_<coordinate>` and `ddq_<coordinate>`, in SI units. Arrays may also be called `q`, `dq`, `ddq`
and `u` and hold all coordinates or inputs, shape (samples, n) or (samples, k), in the model's order.
"""

Logs: TypeAlias = Log | Sequence[Log]
"""One recording, or several of one machine."""


def recordings(logs: Logs | None, name: str, model: Model) -> list[Recording]:
    """Logs as what is computed with takes them; `name` is what messages call frames."""
    if logs is None:
        return []
    if isinstance(logs, (list, tuple)):
        each = cast("Sequence[Log]", logs)
        return [_recording(log, f"{name}[{k}]", model) for k, log in enumerate(each)]
    return [_recording(cast("Log", logs), name, model)]


def _recording(log: Log, name: str, model: Model) -> Recording:
    if isinstance(log, (str, os.PathLike)):
        return os.fspath(log)
    if isinstance(log, Mapping):
        return name, _columns(log, list(log), name, model)
    names = log.dtype.names if isinstance(log, np.ndarray) else getattr(log, "columns", None)
    if names is None:
        message = (
            f"`{name}` is neither a path nor a frame: give a file, a frame of pandas or polars, a"
            " mapping from names to arrays, or a structured array"
        )
        raise TypeError(message)
    columns = _columns(log, list(names), name, model)
    index = getattr(log, "index", None)
    if getattr(index, "name", None) == "t" and "t" not in names:
        columns.insert(0, ("t", np.asarray(index, dtype=np.float64)))
    return name, columns


def _columns(log: Any, names: Sequence[Any], name: str, model: Model) -> list[tuple[str, Array]]:
    columns: list[tuple[str, Array]] = []
    for key in names:
        values = _numbers(log[key])
        if values is None:
            continue
        if values.ndim == 1:
            columns.append((str(key), values))
        elif values.ndim == 2 and key in ("q", "dq", "ddq", "u"):
            axes = model.inputs if key == "u" else model.coordinates
            if values.shape[1] != len(axes):
                raise Error(
                    f"`{name}[{key!r}]` must have the shape (samples, {len(axes)}), one column for"
                    f" each of {', '.join(axes)}, not {values.shape}"
                )
            each = zip(axes, values.T, strict=True)
            columns.extend((f"{key}_{axis}", np.ascontiguousarray(v)) for axis, v in each)
        else:
            raise Error(f"`{name}[{key!r}]` must have one axis, not the shape {values.shape}")
    return columns


def _numbers(column: Any) -> Array | None:
    """A column as float64; nothing if it holds no numbers. What is missing is not a number."""
    values = np.asarray(column)
    if values.dtype.kind in "fiub":
        return np.ascontiguousarray(values, dtype=np.float64)
    if values.dtype.kind != "O":
        return None
    try:
        return np.array([np.nan if _is_missing(x) else float(x) for x in values])
    except (TypeError, ValueError):
        return None


def _is_missing(value: Any) -> bool:
    return value is None or type(value).__name__ == "NAType"
