#!/usr/bin/env python3
"""Asks whether `dynamics trace` finds as likely an explanation as the truth is.

    python reached.py --machines DIR [--set widths] [--out results.jsonl]

Each machine of the set is traced, and then its log once more under the model as patched and under the
model with the statement that it lacks (`statement` in truth.json), where nothing is left to be found.
Counted is on how many machines the log is at most 3 nats less likely under what was written than under
the truth: a search that stops in a bad optimum ends far below.
"""

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import running
import tables
from judging import ROOT
from sets import frozen
from trials import simulate

NATS = 3.0


def likelihood(folder, text, program, limit):
    """(log likelihood of a machine's log under a model's text, processor seconds)."""
    case = running.simulated(folder)
    model = case.command[1]
    with TemporaryDirectory() as scratch:
        case.command[1] = Path(scratch) / model.name
        case.command[1].write_text(text)
        for beside in model.parent.glob("*.urdf"):
            (Path(scratch) / beside.name).write_bytes(beside.read_bytes())
        report, seconds, _ = running.trace(case, program, limit)
    return report.get("log_likelihood_after"), seconds


def trial(folder, program, limit):
    """One line: by how many nats the log is less likely under what was found than under the truth."""
    truth = json.loads((folder / "truth.json").read_text())
    (effect,) = truth["effects"]
    case = running.simulated(folder)
    report, seconds, _ = running.trace(case, program, limit)
    line = {"id": truth["id"], "statement": effect["statement"], "cpu": round(seconds, 2), "reached": False}
    if "error" in report:
        return line | {"error": report["error"]}
    texts = (report["patched_model"], f"{case.command[1].read_text()}\n{effect['statement']};\n")
    likely = [likelihood(folder, text, program, limit) for text in texts]
    (found, _), (true, _) = likely
    line["cpu_again"] = [round(seconds, 2) for _, seconds in likely]
    if found is None or true is None:
        return line | {"error": "no likelihood"}
    said = [f"{f['effect']}({','.join(f['on'])})" for f in report["findings"]]
    return line | {"short": round(true - found, 2), "found": said, "reached": true - found <= NATS}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--set", default="widths", help="a set of frozen.toml whose machines have a statement")
    parser.add_argument("--machines", type=Path, default=ROOT / "target/machines", help="where the machines are kept")
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/dynamics")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--limit", type=int, default=200, help="processor seconds for an answer")
    parser.add_argument("--count", type=int, help="only so many machines of the set")
    parser.add_argument("--out", type=Path, help="a file for one JSON line per machine")
    a = parser.parse_args()
    entry = frozen()["simulated"][a.set]
    folders = simulate(a.machines / a.set, entry["seed"], a.count or entry["count"], a.jobs, a.set)
    lines = list(running.lines(lambda folder: trial(folder, a.program, a.limit), folders, a.jobs, a.out))
    print(f"within {NATS:.0f} nats of the truth: {tables.rate(lines, 'reached')}")
    print(f"no answer or refused: {sum('error' in line for line in lines)}")
    seconds = [line["cpu"] for line in lines]
    print(f"processor seconds: {tables.quantile(seconds, 0.5)} (median), {max(seconds)} (worst)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
