"""Learning the force that a model lacks, after scikit-learn's habits.

A Gaussian process stands in for the unknown force; it is seen through the constrained equation of
motion (GP²). So predicted accelerations obey the constraints, and multipliers come along.

    from dynamics.gp import LatentForceRegressor

    learnt = LatentForceRegressor(model).fit(X, accelerations)
    mean, std = learnt.predict(X_new, return_std=True)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from dynamics import _native
from dynamics._logs import Frame
from dynamics._native import Error, Model
from dynamics._types import Array

__all__ = ["LatentForceRegressor"]


class LatentForceRegressor:
    """A force that a model lacks, learnt from measured accelerations.

    `X` has a row per state: positions, velocities and inputs, shape (samples, 2 n + k), in the
    model's order and SI units; or it is a frame with the columns `q_…`, `dq_…` and `u_…` of a log.
    `y` are accelerations, shape (samples, n), or a frame with the columns `ddq_…`.

    Attributes:
        columns_: the names of the columns of `X` that the force depends on.
        noise_: standard deviation of the accelerations' noise, shape (n,).
        signal_std_: standard deviation of the force before anything was learnt, shape (n,), N or
            N·m.
        length_scales_: over which distances the force changes, shape (n, number of columns).
        log_evidence_: how well the points that were learnt from are explained, nats.
        n_features_in_: the number of columns of `X`.
    """

    def __init__(
        self,
        model: Model,
        *,
        columns: Sequence[str] | None = None,
        points: int = 200,
        restarts: int = 2,
        seed: int = 1,
    ) -> None:
        """Says how to learn.

        Args:
            model: what is known of the machine.
            columns: what the force depends on, by the names of columns of a log; positions and
                velocities if left out.
            points: at most so many rows are learnt from, those that are farthest apart; time
                grows with the third power of points times coordinates.
            restarts: how often training begins anew; the best is kept.
            seed: seed of everything random.
        """
        self.model = model
        self.columns = columns
        self.points = points
        self.restarts = restarts
        self.seed = seed

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The arguments that it was made with, by name."""
        names = ("model", "columns", "points", "restarts", "seed")
        return {name: getattr(self, name) for name in names}

    def set_params(self, **params: Any) -> LatentForceRegressor:
        """Replaces arguments that it was made with.

        Raises:
            dynamics.Error: if there is no such argument.
        """
        known = self.get_params()
        for name, value in params.items():
            if name not in known:
                raise Error(f"there is no parameter `{name}`; there are: {', '.join(known)}")
            setattr(self, name, value)
        return self

    def fit(self, X: ArrayLike | Frame, y: ArrayLike | Frame) -> LatentForceRegressor:
        """Learns from states and measured accelerations. Ctrl-C ends the wait.

        Args:
            X: states, as the class has it.
            y: accelerations, as the class has it.

        Returns:
            Itself.

        Raises:
            dynamics.Error: if shapes, names or numbers do not fit.
            dynamics.SolveError: if a state has no unique motion.
            TypeError: if an array does not hold real numbers.
        """
        names = self._names()
        chosen = list(self.columns) if self.columns is not None else names[: self._depends()]
        for column in chosen:
            if column not in names:
                raise Error(f"there is no column `{column}`; there are: {', '.join(names)}")
        if self.points < 1 or self.restarts < 1 or self.seed < 0 or not chosen:
            raise Error("`points` and `restarts` must be positive, `columns` must name some")
        outputs = [f"ddq_{name}" for name in self.model.coordinates]
        self._learnt = _native.learn(
            self.model,
            _table(X, names, "X"),
            _table(y, outputs, "y"),
            names,
            [names.index(column) for column in chosen],
            self.points,
            self.restarts,
            self.seed,
        )
        self.columns_ = chosen
        self.noise_ = np.array(self._learnt.noise)
        self.signal_std_ = np.array(self._learnt.signal)
        self.length_scales_ = np.array(self._learnt.lengths)
        self.log_evidence_ = self._learnt.log_evidence
        self.n_features_in_ = len(names)
        return self

    def predict(
        self,
        X: ArrayLike | Frame,
        return_std: bool = False,
        *,
        quantity: str = "acceleration",
    ) -> Any:
        """Predicts at states.

        Args:
            X: states, as the class has it.
            return_std: whether standard deviations are returned, too; of the quantity itself,
                without the noise of its measurement.
            quantity: `"acceleration"`, `"missing_force"`, `"multiplier"`, `"constraint_force"`
                (`Aᵀ λ`) or `"unconstrained_acceleration"`, what there would be without constraint.

        Returns:
            Means, shape (samples, n), of multipliers (samples, m), SI units; with `return_std`
            also standard deviations of the same shape.

        Raises:
            dynamics.Error: if nothing was learnt yet, or shapes, names or numbers do not fit.
            dynamics.SolveError: if a state has no unique motion.
            TypeError: if an array does not hold real numbers.
        """
        if not hasattr(self, "_learnt"):
            raise Error("nothing was learnt yet: call `fit` first")
        names = self._names()
        mean, std = self._learnt.predict(_table(X, names, "X"), names, quantity)
        return (mean, std) if return_std else mean

    def score(self, X: ArrayLike | Frame, y: ArrayLike | Frame) -> float:
        """The coefficient of determination R² of predicted accelerations, mean over coordinates.

        Args:
            X: states, as the class has it.
            y: accelerations, as the class has it.

        Returns:
            One if all are right, zero if the mean of `y` does as well.

        Raises:
            dynamics.Error: as `predict`.
        """
        outputs = [f"ddq_{name}" for name in self.model.coordinates]
        truth = _table(y, outputs, "y")
        left = ((truth - self.predict(X)) ** 2).sum(axis=0)
        return float(np.mean(1.0 - left / ((truth - truth.mean(axis=0)) ** 2).sum(axis=0)))

    def _names(self) -> list[str]:
        axes, inputs = self.model.coordinates, self.model.inputs
        groups = (("q", axes), ("dq", axes), ("u", inputs))
        return [f"{group}_{axis}" for group, names in groups for axis in names]

    def _depends(self) -> int:
        return 2 * len(self.model.coordinates)


def _table(values: Any, names: list[str], what: str) -> Array:
    """Rows of numbers, from an array or the columns of a frame."""
    if not hasattr(values, "columns"):
        return np.asarray(values)
    known = list(values.columns)
    missing = [name for name in names if name not in known]
    if missing:
        raise Error(f"`{what}` lacks the columns {', '.join(missing)}")
    return np.column_stack([np.asarray(values[name]) for name in names])
