#!/usr/bin/env python3
"""Damages one channel of a simulated log and asks `dynamics trace` what it makes of it.

    python corruptions.py --machines DIR --count 1000 --seed 1 [--out results.jsonl]

DIR holds machines that lack nothing. Each damage is done to both logs of one of them. Counted is how
often the fault is named (a finding about the channel, its columns as mistaken, a warning with the
column's name), the log refused, or nothing said of physics; and how often an effect is claimed that
is not there.
"""

import argparse
import json
import sys
from collections import Counter, defaultdict
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import running
import tables
from judging import CHANNEL, ROOT, findings_of
from systems import SYSTEMS

KINDS = ("sign", "scale", "unit", "swap", "another", "freeze", "delay")
LOGS = ("train.csv", "test.csv")


def draw(header, angular, rng):
    """A damage: its kind, its column, and what else it needs."""
    columns = [name for name in header if name.split("_")[0] in ("q", "dq", "u")]
    while True:
        kind, column = KINDS[rng.integers(len(KINDS))], columns[rng.integers(len(columns))]
        channel = column.split("_")[0]
        others = [name for name in columns if name.split("_")[0] == channel and name != column]
        if kind in ("swap", "another") and not others:
            continue
        found = {"kind": kind, "column": column}
        if kind == "scale":
            found["factor"] = float(np.exp(rng.choice([-1, 1]) * rng.uniform(np.log(1.3), np.log(10))))
        elif kind == "unit":
            is_angle = channel != "u" and column.split("_", 1)[1] in angular
            found["factor"] = float(np.degrees(1)) if is_angle else 1000.0
        elif kind in ("swap", "another"):
            found["other"] = others[rng.integers(len(others))]
        elif kind == "freeze":
            found["from"] = float(rng.uniform(0.2, 0.7))
        elif kind == "delay":
            found["samples"] = int(rng.integers(2, 11))
        return found


def damaged(header, rows, damage):
    """Rows of a log with the damage."""
    rows, i = rows.copy(), header.index(damage["column"])
    clean = rows[:, i].copy()
    if damage["kind"] == "sign":
        rows[:, i] = -clean
    elif damage["kind"] in ("scale", "unit"):
        rows[:, i] = damage["factor"] * clean
    elif damage["kind"] == "freeze":
        first = int(damage["from"] * len(rows))
        rows[first:, i] = clean[first]
    elif damage["kind"] == "delay":
        late = damage["samples"]
        rows[late:, i] = clean[:-late]
        rows = rows[late:]
    else:
        other = header.index(damage["other"])
        rows[:, i] = rows[:, other]
        if damage["kind"] == "swap":
            rows[:, other] = clean
    return rows


def answer(report, damage):
    """What an answer is worth: refused, named, unknown, nothing, or physics."""
    if "error" in report:
        return "no answer" if report["error"] == "no answer" else "refused"
    columns = {damage["column"], damage.get("other", damage["column"])}
    places = {name.split("_", 1)[1] for name in columns}
    findings = report["findings"]
    if any(not f["effect"].startswith(CHANNEL) for f in findings):
        return "physics"
    about = [f for f in findings_of(report) if f["effect"].startswith(CHANNEL) and places & set(f["on"])]
    told = json.dumps([report.get("misread"), report["warnings"]])
    if about and report["verdict"] == "channel" or any(name in told for name in columns):
        return "named"
    if findings:
        return "another channel"
    return "unknown" if report["verdict"] == "unknown" else "nothing"


def trial(index, folders, seed, program, limit):
    """One line: a damage and what is said of it."""
    rng = np.random.default_rng([seed, index])
    folder = folders[index % len(folders)]
    truth = json.loads((folder / "truth.json").read_text())
    case = running.simulated(folder)
    (system,) = (s for s in SYSTEMS.values() if (s.name, s.variant, [*s.coords]) == (
        truth["system"], truth["variant"], truth["coords"]))
    angular = [name for name, turns in zip(system.coords, system.angular) if turns]
    with TemporaryDirectory() as scratch:
        for log in LOGS:
            header = (folder / log).open().readline().strip().split(",")
            if log == LOGS[0]:
                damage = draw(header, angular, rng)
            rows = damaged(header, np.loadtxt(folder / log, delimiter=",", skiprows=1), damage)
            np.savetxt(Path(scratch) / log, rows, fmt="%.9g", delimiter=",", header=",".join(header), comments="")
        logs = {folder / log: Path(scratch) / log for log in LOGS}
        case.command = [logs.get(part, part) for part in case.command]
        report, seconds, _ = running.trace(case, program, limit)
    said = [] if "error" in report else [f"{f['effect']}({','.join(f['on'])})" for f in findings_of(report)]
    return {"index": index, "machine": truth["id"], **damage, "answer": answer(report, damage),
            "verdict": report.get("verdict", report.get("error")), "found": said, "cpu": round(seconds, 2)}


def show(lines):
    """Rates by kind of damage."""
    groups = defaultdict(list)
    for line in lines:
        for name in (line["kind"], "all"):
            groups[name].append(line)
    for name in (*KINDS, "all"):
        counts = Counter(line["answer"] for line in groups[name])
        good = [{"good": line["answer"] in ("named", "refused")} for line in groups[name]]
        rest = ", ".join(f"{count} {answer}" for answer, count in sorted(counts.items()))
        print(f"{name:8s} named or refused {tables.rate(good, 'good')}  ({rest})")
    print(f"processor seconds: {sum(line['cpu'] for line in lines):.0f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--machines", type=Path, required=True, help="folder with machines that lack nothing")
    parser.add_argument("--of", type=int, default=10, help="how many of them")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--limit", type=int, default=120, help="processor seconds for an answer")
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/dynamics")
    parser.add_argument("--out", type=Path, help="a file for one JSON line per damage")
    a = parser.parse_args()
    found = sorted(p.parent for p in a.machines.glob("*/truth.json"))
    found = [p for p in found if json.loads((p / "truth.json").read_text())["class"] == "none"][:a.of]
    if not found:
        parser.error(f"{a.machines} holds no machine that lacks nothing")
    trials = running.lines(lambda i: trial(i, found, a.seed, a.program, a.limit), range(a.count), a.jobs, a.out)
    show(list(trials))
    return 0


if __name__ == "__main__":
    sys.exit(main())
