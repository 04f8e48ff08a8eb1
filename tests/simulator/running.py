"""Runs `dynamics trace` as a process of its own, with its processor time and a limit on it."""

import json
import os
import resource
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from judging import ROOT


@dataclass
class Case:
    """What to trace."""

    name: str
    command: list
    """Arguments of `dynamics`."""


def model_of(folder, truth):
    """The model file of a machine's system."""
    name = truth["system"]
    if (folder / "sensed.model").exists():
        return folder / "sensed.model"
    if name == "duffing":
        name += "_" + truth["variant"]
    if name == "planar_arm":
        # On top of the robot description, so that a wrong mass can be called that.
        model = folder / "arm.model"
        model.write_text('model arm;\nurdf "model.urdf" { parameters: all; }\n')
        return model
    return ROOT / "models" / f"{name}.model"


def simulated(folder):
    """The case of a machine as `simulate.py` wrote it."""
    truth = json.loads((folder / "truth.json").read_text())
    nominal = json.loads((folder / "nominal.json").read_text())["nominal"]
    command = ["trace", model_of(folder, truth), folder / "train.csv", "--test", folder / "test.csv"]
    if truth["system"] != "planar_arm":
        command += parameters(folder, nominal)
    return Case(truth["id"], command)


def scenario(folder, entry, scratch):
    """The case of a shared log whose truth is written down."""
    nominal = json.loads((folder / "nominal.json").read_text())["nominal"]
    model = ROOT / "models" / f"{entry['model']}.model" if "model" in entry else folder.parent / "assets" / entry["urdf"]
    logs = [next(p for p in folder.glob(f"{which}.csv*")) for which in ("train", "test")]
    command = ["trace", model, logs[0], "--test", logs[1]]
    if nominal:
        scratch.mkdir(parents=True, exist_ok=True)
        command += parameters(scratch, nominal)
    return Case(folder.name, command)


def measured(folder, entry):
    """The case of a measured log."""
    model = ROOT / entry["model"] if entry["model"].startswith("tests/") else folder / entry["model"]
    command = ["trace", model, folder / entry["log"]]
    if "map" in entry:
        command += ["--map", folder / entry["map"]]
    if "test" in entry:
        command += ["--test", folder / entry["test"]]
    return Case(folder.name, command)


def parameters(folder, nominal):
    """The option that gives a model these nominal values."""
    path = folder / "parameters.json"
    path.write_text(json.dumps({k: v for k, v in nominal.items() if k != "constrained"}))
    return ["--parameters", path]


def trace(case, program, limit):
    """(report or {"error"}, processor seconds, largest memory in MB) of one case."""

    def bound():
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))

    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as complaints:
        command = [str(part) for part in [program, *case.command, "--json"]]
        process = subprocess.Popen(command, stdout=out, stderr=complaints, stdin=subprocess.DEVNULL, preexec_fn=bound)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = usage.ru_utime + usage.ru_stime
        out.seek(0)
        complaints.seek(0)
        if process.returncode < 0:
            report = {"error": "no answer" if seconds >= limit else f"signal {-process.returncode}"}
        elif process.returncode > 0:
            report = {"error": complaints.read().decode(errors="replace").strip()[-300:]}
        else:
            report = json.load(out)
    return report, seconds, usage.ru_maxrss / 1024


def lines(trial, items, jobs, out=None):
    """Yields what a trial says of each item, in their order.

    Each is written to the file `out` as a line of JSON at once, so that an interrupted run keeps what it has.
    """
    if out:
        out.write_text("")
    with ThreadPoolExecutor(jobs) as pool:
        for line in pool.map(trial, items):
            if out:
                with out.open("a") as file:
                    file.write(json.dumps(line) + "\n")
            yield line
