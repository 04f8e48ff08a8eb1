"""What `trace` and `fit` found, to be looked at, drawn, written and computed with."""

from __future__ import annotations

import json
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from dynamics._native import Report
from dynamics._types import Array, File

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Estimate:
    """A number with its standard deviation.

    Attributes:
        value: the estimate.
        std: its standard deviation, in the same unit; infinite or not a number where the log
            does not determine it.
        unit: the unit, as the model writes it; empty where the number's place says it.
    """

    value: float
    std: float
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.value:.4g} ± {self.std:.2g} {self.unit}".rstrip()


@dataclass(frozen=True)
class Rival:
    """An explanation that the log cannot tell from a finding.

    Attributes:
        effect: the effect, or `parameter`.
        on: what it acts on.
        evidence_difference: nats by which it explains the log better; worse if negative.
    """

    effect: str
    on: tuple[str, ...]
    evidence_difference: float


@dataclass(frozen=True)
class Finding:
    """One thing that the model lacks.

    Attributes:
        effect: the effect of the library, or `parameter`.
        on: the coordinates, inputs or parameters that it is about.
        parameters: its numbers by name.
        evidence: nats by which the log is better explained with it, less its price.
        rivals: what explains the log about as well.
        same_on: the bodies on which a load would be the same, rigidly connected with its own.
    """

    effect: str
    on: tuple[str, ...]
    parameters: dict[str, Estimate]
    evidence: float
    rivals: tuple[Rival, ...]
    same_on: tuple[str, ...] = ()


@dataclass(frozen=True)
class Term:
    """One thing that a fit has taken in.

    Attributes:
        term: what its effects say that they are part of, such as `friction` or `payload`.
        on: the coordinates, or the body, that it acts on.
        coefficients: its numbers by name, with what the model states of them already.
        gain: the share by which it lowers the mean squared error of blocks that it was not
            fitted to.
        evidence: nats by which these blocks are likelier with it.
    """

    term: str
    on: tuple[str, ...]
    coefficients: dict[str, Estimate]
    gain: float
    evidence: float


class Result:
    """What `Trace` and `Fit` have in common.

    Attributes:
        json: what the command line prints with `--json`, character for character.
        report: the same as dictionaries and lists.
        summary: what the command line prints without.
        diff: the change to the model's file, as `diff -u` shows it; empty if nothing changes.
        text: the model with what was found.
        html: the report as a page of its own, with figures.
        warnings: what should be known about the logs.
    """

    def __init__(self, found: Report) -> None:
        """Holds what was found; `trace` and `fit` make results, you do not."""
        self._found = found
        self.json = found.json
        self.report: dict[str, Any] = json.loads(found.json)
        self.summary = found.summary
        self.diff = found.diff
        self.text = found.text
        self.html = found.html
        self.warnings: list[str] = self.report["warnings"]

    def apply(self, path: File | None = None) -> bool:
        """Writes the model with what was found.

        Args:
            path: the file; the model's own if left out, and beside a robot description a new
                `.model` that names it. Another file belongs into the folder of the model, whose
                text may name files from there.

        Returns:
            Whether there was something to write.

        Raises:
            dynamics.Error: if the model's file has changed since it was read, or cannot be
                written.
        """
        return self._found.apply(path)

    def write(self, folder: File) -> None:
        """Writes the folder that the command line writes with `--report`.

        Args:
            folder: made if it is not there.

        Raises:
            dynamics.Error: if it cannot be written.
        """
        self._found.write(folder)

    def __str__(self) -> str:
        return self.summary

    def _repr_html_(self) -> str:
        change = f"<pre>{escape(self.diff)}</pre>" if self.diff else "<p>The model stays.</p>"
        return f"<div>{self._table()}{change}</div>"

    def _table(self) -> str:
        raise NotImplementedError


class Trace(Result):
    """What a log says that a model lacks.

    Attributes:
        verdict: `effect`, `parameter`, `channel`, `none` or `unknown`.
        findings: what the model lacks, strongest first.
        before: errors of the model as given on data that nothing was fitted to; the groups are
            `acceleration`, `force` and `rollout`, each with `total` (a share) and
            `per_coordinate` (SI units).
        after: the same of the model with the findings.
        noise_floor: the same of a model that is exactly right.
    """

    def __init__(self, found: Report) -> None:
        """Holds what was found; `trace` makes traces, you do not."""
        super().__init__(found)
        self.verdict: str = self.report["verdict"]
        self.findings = [_finding(finding) for finding in self.report["findings"]]
        self.before: dict[str, Any] = self.report["before"]
        self.after: dict[str, Any] = self.report["after"]
        self.noise_floor: dict[str, Any] = self.report["noise_floor"]
        self._series: dict[str, Any] = json.loads(found.series)["series"]

    def __repr__(self) -> str:
        found = [f"{f.effect} on {', '.join(f.on)}" for f in self.findings]
        return f"<Trace: {self.verdict}; {'; '.join(found) or 'no finding'}>"

    def residuals(self) -> pandas.DataFrame:
        """Curves along the log that is judged by, thinned to what a plot can show.

        Returns:
            A frame with a row per sample: `t` [s]; of each coordinate `q_`, `dq_`, `ddq_` [SI
            units], and `force_before_`, `force_after_`, the generalised force that the model
            lacks as given and with the findings [N or N·m].

        Raises:
            ImportError: if pandas is not there.
        """
        columns: dict[str, Array] = {"t": _curve(self._series["t"])}
        names = {"position": "q", "velocity": "dq", "acceleration": "ddq"}
        for of in self._series["coordinates"]:
            for name in ("position", "velocity", "acceleration", "force_before", "force_after"):
                columns[f"{names.get(name, name)}_{of['name']}"] = _curve(of[name])
        return _frame(columns)

    def predictions(self) -> pandas.DataFrame:
        """Open-loop predictions of the positions along the log that is judged by.

        Returns:
            A frame with a row per sample: `t` [s]; of each coordinate `measured_`, `before_` and
            `after_` [SI units]; not a number where a prediction ends.

        Raises:
            ImportError: if pandas is not there.
        """
        columns: dict[str, Array] = {"t": _curve(self._series["prediction_t"])}
        for of in self._series["coordinates"]:
            for name, curve in of["prediction"].items():
                columns[f"{name}_{of['name']}"] = _curve(curve)
        return _frame(columns)

    def plot(self) -> Figure:
        """Draws the force that the model lacks over time, before and after, per coordinate.

        Returns:
            A figure of matplotlib.

        Raises:
            ImportError: if matplotlib is not there.
        """
        curves = {
            of["name"]: [("before", of["force_before"]), ("after", of["force_after"])]
            for of in self._series["coordinates"]
        }
        return _figure(_curve(self._series["t"]), curves, "missing force")

    def _table(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(f.effect)}</td><td>{escape(', '.join(f.on))}</td>"
            f"<td>{_numbers(f.parameters)}</td><td>{f.evidence:.1f}</td></tr>"
            for f in self.findings
        )
        findings = (
            "<table><tr><th>finding</th><th>on</th><th>parameters</th><th>evidence [nats]</th></tr>"
            f"{rows}</table>"
        )
        errors = "".join(
            f"<tr><td>{what}</td>"
            + "".join(
                f"<td>{_share(score[what]['total'])}</td>"
                for score in (self.before, self.after, self.noise_floor)
            )
            + "</tr>"
            for what in ("acceleration", "force", "rollout")
        )
        return (
            f"<p>Verdict: <b>{escape(self.verdict)}</b></p>{findings if rows else ''}"
            "<table><tr><th>held-out error</th><th>before</th><th>after</th><th>noise floor</th></tr>"
            f"{errors}</table>"
        )


class Fit(Result):
    """Parameters of a machine whose forces were measured.

    Attributes:
        terms: what was taken in, in that order.
        inertial: the inertial parameters, a dictionary each; empty if they were held.
        before: error of the model as given on data that nothing was fitted to: `total` and
            `by_coordinate`, N or N·m.
        after: the same with what was found.
        worse: whether the error after is larger.
    """

    def __init__(self, found: Report) -> None:
        """Holds what was found; `fit` makes fits, you do not."""
        super().__init__(found)
        self.terms = [_term(term) for term in self.report["terms"]]
        self.inertial: list[dict[str, Any]] = self.report["inertial"]
        self.before: dict[str, Any] = self.report["before"]
        self.after: dict[str, Any] = self.report["after"]
        self.worse: bool = self.report["worse"]
        self._curves: dict[str, Any] = json.loads(found.series)

    def __repr__(self) -> str:
        found = [f"{t.term} on {', '.join(t.on)}" for t in self.terms]
        return f"<Fit: {'; '.join(found) or 'no term'}>"

    def residuals(self) -> pandas.DataFrame:
        """Curves along the log that was judged by, thinned to what a plot can show.

        Returns:
            A frame with a row per sample: `t` [s]; of each coordinate `dq_` [SI units], and
            `measured_`, `before_`, `after_`: the force that inputs exert, and what the model as
            given and as fitted leaves of it [N or N·m].

        Raises:
            ImportError: if pandas is not there.
        """
        columns: dict[str, Array] = {"t": _curve(self._curves["t"])}
        for of in self._curves["coordinates"]:
            for name in ("velocity", "measured", "before", "after"):
                prefix = "dq" if name == "velocity" else name
                columns[f"{prefix}_{of['name']}"] = _curve(of[name])
        return _frame(columns)

    def plot(self) -> Figure:
        """Draws the force that the model leaves over time, before and after, per coordinate.

        Returns:
            A figure of matplotlib.

        Raises:
            ImportError: if matplotlib is not there.
        """
        curves = {
            of["name"]: [("before", of["before"]), ("after", of["after"])]
            for of in self._curves["coordinates"]
        }
        return _figure(_curve(self._curves["t"]), curves, "force left")

    def _table(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(t.term)}</td><td>{escape(', '.join(t.on))}</td>"
            f"<td>{_numbers(t.coefficients)}</td><td>{_share(t.gain)}</td></tr>"
            for t in self.terms
        )
        return (
            f"<p>Error left: {self.before['total']:.4g} before, {self.after['total']:.4g} after</p>"
            "<table><tr><th>term</th><th>on</th><th>coefficients</th><th>gain</th></tr>"
            f"{rows}</table>"
        )


def _number(value: float | None) -> float:
    return float("nan") if value is None else value


def _finding(of: dict[str, Any]) -> Finding:
    numbers = of["parameters"].items()
    rivals = of["confounded_with"]
    return Finding(
        effect=of["effect"],
        on=tuple(of["on"]),
        parameters={
            name: Estimate(_number(p["value"]), _number(p["std"]), p["unit"]) for name, p in numbers
        },
        evidence=_number(of["evidence"]),
        rivals=tuple(
            Rival(r["effect"], tuple(r["on"]), _number(r["evidence_difference"])) for r in rivals
        ),
        same_on=tuple(of.get("same_on", ())),
    )


def _term(of: dict[str, Any]) -> Term:
    numbers = of["coefficients"].items()
    return Term(
        term=of["term"],
        on=tuple(of["on"]),
        coefficients={
            name: Estimate(_number(c["value"]), _number(c["std"])) for name, c in numbers
        },
        gain=_number(of["gain"]),
        evidence=_number(of["evidence"]),
    )


def _numbers(estimates: dict[str, Estimate]) -> str:
    return "<br>".join(escape(f"{name} = {value}") for name, value in estimates.items())


def _share(value: float | None) -> str:
    return "" if value is None else f"{100 * value:.3g} %"


def _curve(values: list[float | None]) -> Array:
    return np.array(values, dtype=np.float64)


def _frame(columns: dict[str, Array]) -> pandas.DataFrame:
    import pandas

    return pandas.DataFrame(columns)


def _figure(t: Array, curves: dict[str, list[tuple[str, list[float | None]]]], what: str) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 2 * len(curves)), layout="constrained")
    panels = figure.subplots(len(curves), sharex=True, squeeze=False)[:, 0]
    for panel, (name, lines) in zip(panels, curves.items(), strict=True):
        for label, values in lines:
            panel.plot(t, _curve(values), label=label, linewidth=0.8)
        panel.set_ylabel(f"{what}\n{name}")
    panels[0].legend()
    panels[-1].set_xlabel("t [s]")
    return figure
