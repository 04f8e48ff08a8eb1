"""What the tests share: the repository's models, and its command line."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import dynamics
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"

Command = Callable[..., str]


@pytest.fixture(scope="session")
def program() -> Path:
    """The command line to compare with."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    named = os.environ.get("DYNAMICS_PROGRAM")
    built = [target / profile / "dynamics" for profile in ("debug", "release")]
    there = [Path(named)] if named else [path for path in built if path.exists()]
    if not there:
        pytest.fail("no command line to compare with: cargo build -p eqmotion-cli")
    return there[0]


@pytest.fixture(scope="session")
def command(program: Path) -> Command:
    """Runs the command line and returns what it prints."""

    def run(*arguments: object, stdin: str = "") -> str:
        line = [str(program), *(str(argument) for argument in arguments)]
        done = subprocess.run(line, input=stdin, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return str(done.stdout)

    return run


@pytest.fixture(scope="session")
def evaluated(command: Command) -> Callable[..., list[dict[str, Any]]]:
    """What `dynamics eval` answers at states that are given as arrays of rows."""

    def run(model: Path, **rows: Any) -> list[dict[str, Any]]:
        count = len(rows["q"])
        states = [{name: np.asarray(r[k]).tolist() for name, r in rows.items()} for k in range(count)]
        text = "\n".join(json.dumps(state) for state in states)
        arguments = ("eval", model, "--states", "-", "--derivatives", "--json")
        return [json.loads(line) for line in command(*arguments, stdin=text).splitlines()]

    return run


@pytest.fixture(scope="session")
def swing(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    """A double pendulum that has friction in its second joint: the model without, and two logs."""
    folder = tmp_path_factory.mktemp("swing")
    model = folder / "pendulum2.model"
    model.write_text((MODELS / "pendulum2.model").read_text())
    real = folder / "real.model"
    real.write_text(model.read_text() + "\neffect viscous(j2) { d = 0.03 }\n")
    machine = dynamics.Model.load(real)
    rng = np.random.default_rng(3)
    logs = []
    for number, name in enumerate(["train.csv", "test.csv"]):
        times = np.arange(0.0, 12.0, 0.05)
        phases = np.outer(times, [2.0 + number, 3.1]) + number
        motion = machine.simulate(
            [0.4, -0.2], u=0.15 * np.sin(phases), input_times=times, duration=10.0
        )
        columns = motion.columns()
        noisy = {c: v for c, v in columns.items() if not c.startswith("dd")}
        for column, values in noisy.items():
            if column.startswith(("q_", "dq_")):
                size = 1e-4 if column.startswith("q_") else 2e-3
                noisy[column] = values + size * rng.standard_normal(len(values))
        logs.append(folder / name)
        table = np.column_stack(list(noisy.values()))
        lines = [",".join(repr(float(x)) for x in row) for row in table]
        logs[-1].write_text("\n".join([",".join(noisy), *lines]) + "\n")
    return model, logs[0], logs[1]
