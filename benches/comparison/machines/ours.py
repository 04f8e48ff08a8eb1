"""Our `trace` and `fit`: what they print, and predictions by `dynamics simulate` from the model that they write."""

import json
import shutil
import subprocess

import numpy as np
import running

from machines import scoring
from machines.answer import Answer, number

LIMIT = 300
"""Processor seconds."""


def trace(machine, task, program):
    """The answer of `dynamics trace`."""
    return answer("ours, trace", machine, task, program, "trace", said_by_trace)


def fit(machine, task, program):
    """The answer of `dynamics fit`."""
    return answer("ours, fit", machine, task, program, "fit", said_by_fit)


def answer(tool, machine, task, program, name, said):
    """Runs one of the two, and predicts by the model it wrote. It is not given the log that all are judged by."""
    folder = machine.folder / name
    shutil.rmtree(folder, ignore_errors=True)
    model, log, parameters = files(machine)
    # a user writes this
    command = [name, model, log, *parameters, "--report", folder]
    # up to here
    case = running.Case(tool, command)
    report, seconds, _ = running.trace(case, program, LIMIT)
    if "error" in report:
        return Answer(tool, float("nan"), seconds, f"an error: {report['error']}")
    written = next(folder.glob("*.model"))
    return Answer(tool, scoring.error(task, predictions(machine, task, program, written)), seconds, said(report))


def files(machine):
    """The model, the log to learn from, and the option that gives the model its numbers."""
    command = machine.case.command
    stated = command.index("--parameters") if "--parameters" in command else len(command)
    return command[1], command[2], command[stated:stated + 2]


def said_by_trace(report):
    """Findings with their numbers."""
    if report["verdict"] == "none":
        return "nothing"
    found = [term(f["effect"], f["on"], f["parameters"]) for f in report["findings"]]
    return "; ".join(found) or f"`{report['verdict']}`"


def said_by_fit(report):
    """Terms with their numbers, and whether inertias were changed."""
    found = [term(t["term"], t["on"], t["coefficients"]) for t in report["terms"]]
    if report["inertia"] != "fixed":
        found.append("other inertias")
    return "; ".join(found) or "nothing"


def term(name, on, parameters):
    """An effect at its place; a parameter is its own place."""
    values = ", ".join(f"{key} {number(p['value'])}" for key, p in parameters.items() if p["value"] is not None)
    return values if name == "parameter" else f"{name}({', '.join(on)}): {values}"


def predictions(machine, task, program, model):
    """Predictions of a written model from every start."""
    folder, system = model.parent, machine.system
    inputs, out = folder / "inputs.csv", folder / "predicted.csv"
    table = np.column_stack([task.log.t, task.log.u])
    header = ",".join(["t", *(f"u_{name}" for name in system.inputs)])
    np.savetxt(inputs, table, fmt="%.10g", delimiter=",", header=header, comments="")
    _, _, stated = files(machine)
    starts, count = task.starts()
    found = []
    for start in starts:
        state = {"q": list(task.q[start]), "v": list(task.v[start]), "t": task.t[start]}
        command = [program, "simulate", model, *stated, "--inputs", inputs, "--init", json.dumps(state), "--duration",
                   repr(count / task.rate), "--rate", repr(task.rate), "--max-step", repr(scoring.STEP), "--out", out]
        subprocess.run([str(part) for part in command], check=True, capture_output=True)
        found.append(np.loadtxt(out, delimiter=",", skiprows=1)[:, 1:1 + len(system.coords)])
    return np.stack(found)
