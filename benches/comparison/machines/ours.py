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
    # a user writes this
    command = [*machine.case.command]
    # up to here
    return answer("ours, trace", machine, task, program, command, said_by_trace)


def fit(machine, task, program):
    """The answer of `dynamics fit`."""
    command = ["fit", *machine.case.command[1:]]
    return answer("ours, fit", machine, task, program, command, said_by_fit)


def answer(tool, machine, task, program, command, said):
    """Runs one of the two, and predicts by the model it wrote."""
    folder = machine.folder / command[0]
    shutil.rmtree(folder, ignore_errors=True)
    case = running.Case(tool, [*command, "--report", folder])
    report, seconds, _ = running.trace(case, program, LIMIT)
    if "error" in report:
        return Answer(tool, float("nan"), seconds, f"an error: {report['error']}")
    model = next(folder.glob("*.model"))
    return Answer(tool, scoring.error(task, predictions(machine, task, program, model)), seconds, said(report))


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
    given = machine.folder / "parameters.json"
    stated = ["--parameters", given] if "--parameters" in machine.case.command else []
    starts, count = task.starts()
    found = []
    for start in starts:
        state = {"q": list(task.q[start]), "v": list(task.v[start]), "t": task.t[start]}
        command = [program, "simulate", model, *stated, "--inputs", inputs, "--init", json.dumps(state), "--duration",
                   repr(count / task.rate), "--rate", repr(task.rate), "--max-step", repr(scoring.STEP), "--out", out]
        subprocess.run([str(part) for part in command], check=True, capture_output=True)
        found.append(np.loadtxt(out, delimiter=",", skiprows=1)[:, 1:1 + len(system.coords)])
    return np.stack(found)
