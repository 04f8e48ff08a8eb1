"""A fleet's logs, carried by Dask, killed half-way: all are traced, none twice, and the page is right.

The fleet of `docs/fleet.md` has 25 machines and 20 months; this one has a hundred logs.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from conftest import MODELS, ROOT

FLEET = ROOT / "examples/fleet"
MODEL = MODELS / "pendulum.model"
MACHINES, MONTHS = 10, 10


def line_of(name: str, *arguments: object) -> list[str]:
    return [sys.executable, str(FLEET / name), *map(str, arguments)]


def run(name: str, *arguments: object) -> str:
    done = subprocess.run(line_of(name, *arguments), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def answered(answers: Path) -> dict[str, int]:
    """The answers that are there, with the time of writing."""
    there = [path for path in answers.glob("*.*") if not path.name.startswith(".")]
    return {path.name: path.stat().st_mtime_ns for path in there}


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Logs of a fleet, three of which are none."""
    folder = tmp_path_factory.mktemp("fleet") / "logs"
    run("make_logs.py", folder, "--machines", MACHINES, "--months", MONTHS, "--seed", 2)
    return folder


@contextlib.contextmanager
def started(line: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """A program with all that it starts, killed in the end without a chance to tidy up."""
    running = subprocess.Popen(line, stdout=subprocess.DEVNULL, start_new_session=True)
    try:
        yield running
    finally:
        os.killpg(running.pid, signal.SIGKILL)
        running.wait()


@pytest.fixture(scope="module")
def answers(logs: Path) -> Path:
    """Answers to all logs, of a run that was killed half-way and of one that went on."""
    folder = logs.parent / "answers"
    line = line_of("with_dask.py", MODEL, logs, folder, "--workers", 2)
    count = MACHINES * MONTHS
    with started(line) as running:
        while len(answered(folder)) < count // 2:
            assert running.poll() is None, "Dask has ended by itself"
            time.sleep(0.1)
    first = answered(folder)
    assert count // 2 <= len(first) < count

    said = run("with_dask.py", MODEL, logs, folder, "--workers", 2)
    assert f"{count} logs, {len(first)} done before" in said
    both = answered(folder)
    # Nothing is lost, and what was done is as it was.
    assert {name.rpartition(".")[0] for name in both} == {log.stem for log in logs.glob("*.csv")}
    assert len(both) == count
    assert {name: both[name] for name in first} == first
    # Each line of progress is a log traced: the rest, and nothing else.
    traced = [text.split()[1].rstrip(":") for text in said.splitlines()[1:]]
    rest = {name.rpartition(".")[0] for name in both.keys() - first.keys()}
    assert sorted(traced) == sorted(rest)
    return folder


@pytest.fixture(scope="module")
def said(answers: Path) -> dict[str, Any]:
    """What the summary says."""
    run("collect.py", answers, answers.parent / "tables")
    run("summary.py", answers.parent / "tables")
    said: dict[str, Any] = json.loads((answers.parent / "tables/fleet.json").read_text())
    return said


def test_a_third_run_has_nothing_to_do(logs: Path, answers: Path) -> None:
    before = answered(answers)
    said = run("with_dask.py", MODEL, logs, answers, "--workers", 2)
    assert said == f"{len(before)} logs, {len(before)} done before\n"
    assert answered(answers) == before


def test_the_summary_is_right_about_every_machine(logs: Path, said: dict[str, Any]) -> None:
    truth = json.loads((logs / "truth.json").read_text())
    effects = {name: one["effect"] for name, one in truth["machines"].items()}
    assert set(effects.values()) == {"none", "viscous", "coulomb", "spring"}
    named = {n: [f.removesuffix(" (j1)") for f in one["has"]] for n, one in said["machines"].items()}
    assert named == {name: [effect] for name, effect in effects.items()}
    drifts = {n: any(x["drifts"] for x in one["numbers"]) for n, one in said["machines"].items()}
    assert drifts == {name: one["drifts"] for name, one in truth["machines"].items()}
    assert set(said["unusable"]) == set(truth["bad_logs"])
    assert len(said["unusable"]) == 3


def test_the_summary_names_the_odd_months(logs: Path, said: dict[str, Any]) -> None:
    truth = json.loads((logs / "truth.json").read_text())["machines"]
    odd = {f"{name}_{month}" for name, one in truth.items() for month in one["odd"]}
    assert len(odd) == 2
    outliers = {log for one in said["machines"].values() for log in one["outliers"]}
    assert odd <= outliers
    # Of the others, the trace of one log alone may be wrong now and then.
    assert len(outliers - odd) <= MACHINES * MONTHS // 20


def test_the_page_says_what_the_summary_says(answers: Path, said: dict[str, Any]) -> None:
    page = (answers.parent / "tables/fleet.html").read_text()
    assert f"<h1>{MACHINES} machines, {MACHINES * MONTHS} logs</h1>" in page
    assert page.count('class="odd"') == sum(len(one["outliers"]) for one in said["machines"].values())
    assert page.count('class="lost"') == len(said["unusable"])
    assert page.count("<svg") == sum(x["drifts"] for o in said["machines"].values() for x in o["numbers"])


def test_an_array_of_slurm_gives_the_same_answers(
    logs: Path, answers: Path, program: Path, tmp_path: Path
) -> None:
    """Three tasks, as Slurm starts them; two logs are done already."""
    few = tmp_path / "logs"
    few.mkdir()
    bad = sorted(json.loads((logs / "truth.json").read_text())["bad_logs"])
    for name in [*(log.stem for log in sorted(logs.glob("arm0*_2024-02.csv"))[:5]), bad[0]]:
        (few / f"{name}.csv").symlink_to(logs / f"{name}.csv")
    made = tmp_path / "answers"
    environment = os.environ | {"SLURM_ARRAY_TASK_COUNT": "3"}
    command_line = tmp_path / "bin"
    command_line.mkdir()
    (command_line / "dynamics").symlink_to(program)
    environment["PATH"] = f"{command_line}{os.pathsep}{environment['PATH']}"
    for task in ("0", "1", "2", "2"):
        line = ["bash", str(FLEET / "array.sh"), str(MODEL), str(few), str(made)]
        before = answered(made) if made.exists() else {}
        done = subprocess.run(line, env=environment | {"SLURM_ARRAY_TASK_ID": task}, check=False)
        assert done.returncode == 0
        assert before.items() <= answered(made).items()
    assert len(answered(made)) == 6
    for name in answered(made):
        if name.endswith(".json"):
            assert (made / name).read_text() == (answers / name).read_text()
    assert (made / f"{bad[0]}.error").read_text().startswith("error: ")


def test_ray_gives_the_same_answers(logs: Path, answers: Path, tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="pip install ray")
    few = tmp_path / "logs"
    few.mkdir()
    for log in sorted(logs.glob("*_2024-03.csv"))[:4]:
        (few / log.name).symlink_to(log)
    run("with_ray.py", MODEL, few, tmp_path / "answers", "--workers", 2)
    made = answered(tmp_path / "answers")
    assert len(made) == 4
    for name in made:
        assert (tmp_path / "answers" / name).read_text() == (answers / name).read_text()
