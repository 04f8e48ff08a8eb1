#!/usr/bin/env python3
"""Runs `dynamics trace` on simulated machines and prints rates with Wilson intervals.

    python trials.py --set daily --machines DIR [--out results.jsonl]     a frozen set (frozen.toml)
    python trials.py --make FOLDER --seed 7 --count 200                    fresh machines
    python trials.py FOLDER...                                             machines that are there
    python trials.py --read results.jsonl [--beside earlier.jsonl]         tables of finished runs

Sets: those of frozen.toml, `scenarios` and `measured` (both read ../shared/data). What is counted
only is printed as rates; what may be looked at, machine by machine. See judging.py for what counts
as exact.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import running
import tables
from judging import ROOT, judge, judge_measured, judge_scenario, library
from sets import frozen

HERE = Path(__file__).parent
SHARED = ROOT.parent / "shared" / "data"


def simulate(folder, seed, count, jobs, name=None):
    """Makes the machines of a seed, or of a frozen set, that are not there yet."""
    there = {int(p.name.split("_")[1]) for p in folder.glob(f"s{seed}_*") if (p / "truth.json").exists()}
    missing = [i for i in range(count) if i not in there]
    if missing:
        which = ["--set", name, "--out", str(folder.parent)] if name else ["--seed", str(seed), "--out", str(folder)]
        command = [sys.executable, str(HERE / "simulate.py"), "--first", str(missing[0]),
                   "--count", str(count - missing[0]), "--jobs", str(jobs), *which]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return sorted(p for p in folder.glob(f"s{seed}_*") if int(p.name.split("_")[1]) < count)


def cases(a):
    """(kind, case, what the judge needs) of everything that was asked for, and whether one may look."""
    found, look = [], True
    known = frozen()
    for name in a.set:
        if name in known["simulated"]:
            entry = known["simulated"][name]
            look = look and not entry["counted"]
            folders = simulate(a.machines / name, entry["seed"], entry["count"], a.jobs, name)
            found += [("simulated", running.simulated(f), json.loads((f / "truth.json").read_text())) for f in folders]
        elif name == "scenarios":
            for log, entry in known["scenarios"].items():
                folder = SHARED / "scenarios" / log
                truth = json.loads((SHARED / "scenarios/truth" / log / "truth.json").read_text())
                found.append(("scenario", running.scenario(folder, entry, a.machines / "scenarios" / log),
                              {**entry, "floor": truth["oracle"]["test"]["acc_nrmse_floor"]}))
        elif name == "measured":
            for log, entry in known["measured"].items():
                found.append(("measured", running.measured(SHARED / "measured" / log, entry), entry))
        else:
            sets = ", ".join([*known["simulated"], "scenarios", "measured"])
            sys.exit(f"trials.py: there is no set `{name}`; there are {sets}")
    if a.make:
        simulate(a.make, a.seed, a.count, a.jobs)
        a.folders.append(a.make)
    for truth in sorted(p for folder in a.folders for p in folder.glob("**/truth.json")):
        found.append(("simulated", running.simulated(truth.parent), json.loads(truth.read_text())))
    return found, look


def traced(item, program, limit, known):
    """One line of results."""
    kind, case, truth = item
    report, cpu, memory = running.trace(case, program, limit)
    judges = {"simulated": judge, "scenario": judge_scenario, "measured": judge_measured}
    line = judges[kind](case.name, truth, report, known)
    return line | {"kind": kind, "cpu": round(cpu, 2), "memory": round(memory)}


def report(lines, look, earlier):
    """Everything that is printed of a run."""
    judged = [x for x in lines if x["kind"] != "measured"]
    if judged:
        tables.rates(judged, look)
        tables.figures(judged)
        if look:
            tables.missed(judged)
    rest = [x for x in lines if x["kind"] == "measured"]
    if rest:
        tables.measured(rest)
    if earlier:
        print()
        tables.beside(earlier, lines, look)


def read(path):
    """The lines of a finished run."""
    return [json.loads(x) for x in path.read_text().splitlines()]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/dynamics")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--set", nargs="+", default=[], help="sets of frozen.toml, `scenarios`, `measured`")
    parser.add_argument("--machines", type=Path, default=ROOT / "target/machines", help="where the sets' machines are kept")
    parser.add_argument("--out", type=Path, help="a file for one JSON line per machine")
    parser.add_argument("--read", type=Path, help="only print the tables of such a file")
    parser.add_argument("--beside", type=Path, help="such a file of an earlier revision, to compare with")
    parser.add_argument("--counted", action="store_true", help="with --read: print rates only")
    parser.add_argument("--limit", type=int, default=600, help="processor seconds for an answer")
    parser.add_argument("--make", type=Path, help="make machines in this folder first")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--at-least", type=float, default=0.0, metavar="SHARE",
                        help="fail if fewer machines than this share are accepted")
    a = parser.parse_args()
    earlier = read(a.beside) if a.beside else []
    if a.read:
        report(read(a.read), not a.counted, earlier)
        return 0
    todo, look = cases(a)
    if not todo:
        parser.error("no machine to trace: give --set NAME, --make FOLDER, or folders with a truth.json in them")
    known = library()
    lines = list(running.lines(lambda item: traced(item, a.program, a.limit, known), todo, a.jobs, a.out))
    report(lines, look, earlier)
    accepted = sum(line["accepted"] for line in lines)
    if accepted < a.at_least * len(lines):
        print(f"{accepted} of {len(lines)} accepted; at least {100 * a.at_least:.0f} % are demanded", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
