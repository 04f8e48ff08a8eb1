"""What `trace` and `fit` find is what the command line finds, from files and from frames."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import dynamics
import numpy as np
import pandas as pd
import polars as pl
import pytest
from conftest import Command

Swing = tuple[Path, Path, Path]


def found(result: dynamics.Result) -> dict[str, Any]:
    """A report without the names of logs."""
    report = dict(result.report)
    for key in ("split", "patched_model"):
        report.pop(key, None)
    return report


def test_a_trace_is_that_of_the_command_line(swing: Swing, command: Command) -> None:
    model, train, test = swing
    traced = dynamics.trace(model, train, test)
    printed = command("trace", model, train, "--test", test, "--json")
    assert traced.json + "\n" == printed
    assert traced.verdict == "effect"
    (finding,) = traced.findings
    assert (finding.effect, finding.on) == ("viscous", ("j2",))
    estimate = finding.parameters["d"]
    assert abs(estimate.value - 0.03) < 4 * estimate.std
    assert estimate.unit == "N*m*s"
    assert traced.after["rollout"]["total"] < 0.5 * traced.before["rollout"]["total"]
    assert "effect viscous(j2)" in traced.diff


def table_of(path: Path) -> pd.DataFrame:
    """A log as a frame, digit for digit."""
    header = path.read_text().splitlines()[0].split(",")
    return pd.DataFrame(np.loadtxt(path, delimiter=",", skiprows=1), columns=header)


def test_frames_are_files_without_a_file(swing: Swing) -> None:
    model, train, test = swing
    expected = found(dynamics.trace(model, train, test))
    table = table_of(train)
    known = dynamics.Model.load(model)
    by_group = {
        "t": table["t"].to_numpy(),
        "q": table[[f"q_{c}" for c in known.coordinates]].to_numpy(),
        "dq": table[[f"dq_{c}" for c in known.coordinates]].to_numpy(),
        "u": table[[f"u_{c}" for c in known.inputs]].to_numpy(),
    }
    kinds: dict[str, Any] = {
        "polars": pl.DataFrame({c: table[c].to_numpy() for c in table.columns}),
        "index": table.set_index("t"),
        "structured": table.to_records(index=False),
        "arrays": by_group,
        "notes": table.assign(note="left alone"),
    }
    assert found(dynamics.trace(known, [table], [table_of(test)])) == expected
    for name, log in kinds.items():
        got = found(dynamics.trace(known, log, table_of(test)))
        assert got == expected, name


def test_a_fit_is_that_of_the_command_line(swing: Swing, command: Command) -> None:
    model, train, test = swing
    fitted = dynamics.fit(model, train, test)
    assert fitted.json + "\n" == command("fit", model, train, "--test", test, "--json")
    assert [(t.term, t.on) for t in fitted.terms] == [("friction", ("j2",))]
    assert fitted.after["total"] < fitted.before["total"]
    held = dynamics.fit(model, train, test, inertia="fixed")
    assert held.inertial == []


def test_what_was_found_is_applied_once(swing: Swing, tmp_path: Path) -> None:
    original, train, test = swing
    model = tmp_path / "own.model"
    model.write_text(original.read_text())
    traced = dynamics.trace(model, train, test)
    assert traced.apply(tmp_path / "other.model")
    assert (tmp_path / "other.model").read_text() == traced.text
    assert model.read_text() == original.read_text()
    assert traced.apply()
    assert model.read_text() == traced.text
    with pytest.raises(dynamics.Error, match="changed since it was read"):
        traced.apply()
    again = dynamics.trace(model, train, test)
    assert again.verdict == "none"
    assert not again.apply()
    traced.write(tmp_path / "report")
    assert json.loads((tmp_path / "report/report.json").read_text()) == traced.report


def test_results_show_themselves(swing: Swing) -> None:
    model, train, test = swing
    traced, fitted = dynamics.trace(model, train, test), dynamics.fit(model, train, test)
    for result in (traced, fitted):
        page = result._repr_html_()
        assert "friction" in page or "viscous" in page
        assert "<script" not in page
        assert "<html" in result.html
        frame = result.residuals()
        assert frame["t"].is_monotonic_increasing
        assert len(result.plot().axes) == 2
    frame = traced.residuals()
    before, after = frame["force_before_j2"], frame["force_after_j2"]
    assert np.sqrt((after**2).mean()) < 0.8 * np.sqrt((before**2).mean())
    assert list(traced.predictions())[:2] == ["t", "measured_j1"]
    assert "viscous" in repr(traced)


def test_mistakes_in_logs_are_located(swing: Swing, tmp_path: Path) -> None:
    model, train, _ = swing
    bad = tmp_path / "bad.csv"
    lines = train.read_text().splitlines()
    lines[7] = "x" + lines[7]
    bad.write_text("\n".join(lines))
    with pytest.raises(dynamics.Error, match="line 8"):
        dynamics.trace(model, bad)
    table = table_of(train)
    with pytest.raises(dynamics.Error, match="q_j2"):
        dynamics.trace(model, table.drop(columns="q_j2"))
    table.loc[3, "q_j1"] = np.nan
    with pytest.raises(dynamics.Error, match="q_j1"):
        dynamics.trace(model, table)
    with pytest.raises(dynamics.Error, match="given twice"):
        dynamics.trace(model, [train, train])
    with pytest.raises(dynamics.Error, match="learn from"):
        dynamics.trace(model, [])
    with pytest.raises(TypeError, match="neither a path nor a frame"):
        dynamics.trace(model, 3)  # type: ignore[arg-type]
    with pytest.raises(dynamics.Error, match="No such file"):
        dynamics.trace(model, tmp_path / "none.csv")
    with pytest.raises(dynamics.Error, match="hold"):
        dynamics.trace(model, train, hold="sometimes")
    with pytest.raises(dynamics.Error, match="inertia"):
        dynamics.fit(model, train, inertia="none")
