#!/usr/bin/env python3
"""Traces simulated logs with and without wild cells: the answer must not change.

    python wild.py --machines DIR [--share 0.01] [--out results.jsonl]

In both logs of each machine below DIR every cell but the stamps is wild with this probability, by 0.3
to 30 times the spread of its channel (disturbing.py). Told is each machine whose verdict or findings
are others than those of the logs as they were.
"""

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import running
import tables
from corruptions import LOGS
from disturbing import Disturbance
from judging import ROOT, findings_of


def made_wild(log, path, share, rng):
    """Writes `log` with wild cells to `path`."""
    header = log.open().readline().strip()
    rows = np.loadtxt(log, delimiter=",", skiprows=1)
    cells, by = Disturbance(outliers=share).wild(rows, rng)
    rows[tuple(cells.T)] += by
    np.savetxt(path, rows, fmt="%.9g", delimiter=",", header=header, comments="")


def said(report):
    """The verdict and what it names."""
    if "error" in report:
        return [report["error"]]
    return [report["verdict"], *sorted(f"{f['effect']}({','.join(f['on'])})" for f in findings_of(report))]


def trial(folder, seed, share, program, limit):
    """One line: both answers about a machine."""
    case = running.simulated(folder)
    clean, before, _ = running.trace(case, program, limit)
    rng = np.random.default_rng([seed, *folder.name.encode()])
    with TemporaryDirectory() as scratch:
        logs = {folder / log: Path(scratch) / log for log in LOGS}
        for log, path in logs.items():
            made_wild(log, path, share, rng)
        case.command = [logs.get(part, part) for part in case.command]
        wild, after, _ = running.trace(case, program, limit)
    return {"machine": folder.name, "clean": said(clean), "wild": said(wild), "same": said(clean) == said(wild),
            "cpu": [round(before, 2), round(after, 2)]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--machines", type=Path, required=True, help="folder with simulated machines")
    parser.add_argument("--share", type=float, default=0.01, help="share of the cells that become wild")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--limit", type=int, default=200, help="processor seconds for an answer")
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/dynamics")
    parser.add_argument("--out", type=Path, help="a file for one JSON line per machine")
    a = parser.parse_args()
    folders = sorted(p.parent for p in a.machines.glob("**/truth.json"))
    if not folders:
        parser.error(f"{a.machines} holds no machines")
    lines = []
    for line in running.lines(lambda folder: trial(folder, a.seed, a.share, a.program, a.limit), folders, a.jobs, a.out):
        lines.append(line)
        if not line["same"]:
            print(f"{line['machine']}: {' '.join(line['clean'])} -> {' '.join(line['wild'])}", flush=True)
    print(f"the same answer {tables.rate(lines, 'same')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
