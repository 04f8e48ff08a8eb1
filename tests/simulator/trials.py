#!/usr/bin/env python3
"""Runs `dynamics trace` on simulated machines and prints rates with Wilson intervals.

    python trials.py FOLDER... --program target/release/dynamics [--jobs 2] [--out results.jsonl]
    python trials.py --make FOLDER --seed 7 --count 200 --program target/release/dynamics
    python trials.py --read results.jsonl

FOLDER holds machines as simulate.py writes them. A machine counts as

    leading   the first finding is a true effect at its true place
    exact     all true effects are found and nothing else, and the verdict is right
    accepted  as exact, but a stated rival of a finding or a near-equivalent of the
              truth (r2 >= 0.9 between their accelerations) counts as the truth

A truth that has a twin, an effect of the library whose accelerations are the same in all digits
(a constant force on a driven coordinate and a bias of its input), is not identifiable: no log
tells which of the two is first. The rate of first findings is also printed without these.
"""

import argparse
import json
import math
import re
import subprocess
import sys
import time
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CHANNEL = ("input_", "dead_band", "saturation", "backlash", "measurement_", "time_shift")


def library():
    """Names of the effect templates that the program has."""
    return {p.stem for p in (ROOT / "models/effects").glob("*.model")}


def model_of(folder, truth):
    """The model file of a machine's system; None if there is none."""
    name = truth["system"]
    if name == "duffing":
        name += "_" + truth["variant"]
    if name == "planar_arm":
        # On top of the robot description, so that a wrong mass can be called that.
        model = folder / "arm.model"
        model.write_text('model arm;\nurdf "model.urdf" { parameters: all; }\n')
        return model
    return ROOT / "models" / f"{name}.model"


def trace(folder, program, timeout):
    """Runs the program on one machine; returns its report or a note on the failure."""
    truth = json.loads((folder / "truth.json").read_text())
    nominal = json.loads((folder / "nominal.json").read_text())["nominal"]
    parameters = folder / "parameters.json"
    parameters.write_text(json.dumps({k: v for k, v in nominal.items() if k != "constrained"}))
    command = [str(program), "trace", str(model_of(folder, truth)), str(folder / "train.csv"),
               "--test", str(folder / "test.csv"), "--json"]
    if truth["system"] != "planar_arm":
        command += ["--parameters", str(parameters)]
    begin = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False)
    except subprocess.TimeoutExpired:
        return truth, {"error": "timeout"}, timeout
    took = time.monotonic() - begin
    if done.returncode != 0:
        return truth, {"error": done.stderr.strip()[-300:]}, took
    return truth, json.loads(done.stdout), took


def key(effect, on):
    """An effect at its places, as compared."""
    return effect, tuple(sorted(on))


def true_key(truth, effect):
    """The same of a true effect; an arm's parameters are called as its description's."""
    names = {"m": "mass", "lc": "cz", "I": "iyy"}
    on = effect["on"]
    if truth["system"] == "planar_arm" and effect["type"] == "parameter":
        split = [re.fullmatch(r"([a-zA-Z]+)(\d+)", name) for name in on]
        # A length is where the next joint stands.
        on = [f"j{int(m[2]) + 1}_origin_z" if m[1] == "l" else f"link{m[2]}_{names.get(m[1], m[1])}"
              for m in split]
    if truth["system"] == "unicycle2d":
        on = ["vehicle" if name == "body" else name for name in on]
    return key(effect["type"], on)


def wanted_verdict(truth, known):
    """What the report should say; `unknown` where the library lacks the effect."""
    if truth["class"] in ("none", "parameter"):
        return {truth["class"]}
    names = [e["type"] for e in truth["effects"]]
    if any(n not in known for n in names):
        return {"unknown"}
    if all(n.startswith(CHANNEL) for n in names):
        return {"channel"}
    return {"effect"}


def findings_of(report):
    """What is named: findings, and behind them what only comes nearest."""
    return report["findings"] + report.get("nearest", {}).get("findings", [])


def judge(truth, report, took, known):
    """One line of results."""
    line = {"id": truth["id"], "system": truth["system"], "class": truth["class"], "seconds": round(took, 2),
            "noise": truth["noise_level"], "hold": truth["hold"],
            "truth": [true_key(truth, e) for e in truth["effects"]],
            "size": min((e["visibility"] for e in truth["effects"]), default=None), "twin": has_twin(truth)}
    wanted = wanted_verdict(truth, known)
    line["wanted"] = sorted(wanted)[0]
    if "error" in report:
        return line | {"error": report["error"], "exact": False, "accepted": False, "leading": False, "verdict": "error",
                       "found": []}
    findings = findings_of(report)
    found = [key(f["effect"], f["on"]) for f in findings]
    rivals = [{key(r["effect"], r["on"]) for r in f["confounded_with"]} | {own}
              for f, own in zip(findings, found)]
    near = [{true_key(truth, n) for n in e["near_equivalents"]} for e in truth["effects"]]
    true = line["truth"]
    right = report["verdict"] in wanted
    exact = right and sorted(found) == sorted(true)
    if line["wanted"] == "unknown":
        exact = accepted = leading = report["verdict"] == "unknown"
    else:
        def is_one(i, own):
            return any(t in rivals[i] or own in near[j] for j, t in enumerate(true))
        covered = all(any(t in rivals[i] or found[i] in near[j] for i in range(len(found)))
                      for j, t in enumerate(true))
        # A name beside the verdict that nothing explains the log is no explanation.
        accepted = (report["verdict"] != "unknown" and covered and len(found) <= len(true)
                    and all(is_one(i, own) for i, own in enumerate(found)))
        leading = bool(true) and bool(found) and found[0] in true
    score = {k: (report[k]["acceleration"]["total"], report[k]["rollout"]["total"]) for k in
             ("before", "after", "noise_floor")}
    return line | {"verdict": report["verdict"], "found": found, "rivals": [sorted(r) for r in rivals],
                   "exact": exact, "accepted": exact or accepted, "leading": leading, "score": score,
                   "floor": truth["oracle"]["test"]["acc_nrmse_floor"], "estimates": estimates(truth, report),
                   "remaining": report.get("remaining"), "misfit": report.get("misfit_after")}


# Near-equivalents that are this near are the same law.
TWIN = 0.9999


def has_twin(truth):
    """Whether no log can tell one of the true effects from another effect."""
    return any(n["r2"] >= TWIN for e in truth["effects"] for n in e["near_equivalents"])


SAME = {"f_c": ("Fc",), "v_s": ("vs",), "q_0": ("q0",), "gain": ("c",), "bias": ("u0",), "c": ("c",), "d": ("d",),
        "k": ("k",), "f": ("f",), "tau": ("tau", "T"), "mu": ("mu",)}


def estimates(truth, report):
    """(name, true, value, standard error) where names can be matched."""
    found = []
    for e in truth["effects"]:
        for f in findings_of(report):
            if key(f["effect"], f["on"]) != key(e["type"], e["on"]):
                continue
            for name, p in f["parameters"].items():
                if e["type"] == "parameter":
                    found.append((name, e["params"]["true"], p["value"], p["std"]))
                for other in SAME.get(name, ()):
                    if other in e["params"]:
                        found.append((f"{e['type']}.{name}", e["params"][other], p["value"], p["std"]))
    return found


def wilson(hits, count, z=1.96):
    """95 % interval of a rate."""
    if count == 0:
        return 0.0, 1.0
    rate, square = hits / count, z * z
    middle = (rate + square / (2 * count)) / (1 + square / count)
    half = z / (1 + square / count) * math.sqrt(rate * (1 - rate) / count + square / (4 * count * count))
    return max(0.0, middle - half), min(1.0, middle + half)


def rate(lines, field):
    hits = sum(bool(x[field]) for x in lines)
    low, high = wilson(hits, len(lines))
    return f"{hits:3d}/{len(lines):<3d} {100 * hits / max(len(lines), 1):5.1f} % [{100 * low:3.0f}, {100 * high:3.0f}]"


def table(lines):
    """The tables of rates."""
    def block(title, group):
        print(f"\n{title:28s} {'exact':24s} {'accepted':24s} leading")
        groups = defaultdict(list)
        for x in lines:
            for g in group(x):
                groups[g].append(x)
        for g in sorted(groups):
            print(f"{g:28s} {rate(groups[g], 'exact')}  {rate(groups[g], 'accepted')}  {rate(groups[g], 'leading')}")
    block("class / wanted verdict", lambda x: [f"{x['class']} -> {x['wanted']}"])
    block("effect", lambda x: sorted({t[0] for t in x["truth"]}) or ["-"])
    block("system", lambda x: [x["system"]])
    block("noise level", lambda x: [str(x["noise"])])
    block("size (times the floor)", lambda x: [] if x["size"] is None else
          ["2 to 3" if x["size"] < 3 else "3 to 6" if x["size"] < 6 else "6 and more"])
    named = [x for x in lines if x["class"] != "none" and x["wanted"] != "unknown"]
    print(f"\nfirst finding strictly true: {rate(named, 'leading')}; where the truth has no twin: "
          f"{rate([x for x in named if not x['twin']], 'leading')}")
    inside = [abs(t - v) / s for x in lines for _, t, v, s in x.get("estimates", []) if s and math.isfinite(s)]
    if inside:
        print(f"\nestimates: {len(inside)}; within 1, 2, 3 standard errors:",
              *(f"{sum(z < k for z in inside) / len(inside):.3f}" for k in (1, 2, 3)))
    times = sorted(x["seconds"] for x in lines)
    print(f"seconds: median {times[len(times) // 2]:.1f}, longest {times[-1]:.1f}")
    wrong = Counter()
    print("\nnot accepted:")
    for x in lines:
        if not x["accepted"]:
            show = lambda keys: " + ".join(f"{n}({','.join(on)})" for n, on in keys) or "-"
            print(f"  {x['id']:32s} {x['wanted']:9s} {show(x['truth']):44s} -> {x['verdict']}: {show(x['found'])}"
                  f"{' ' + x['error'] if 'error' in x else ''}")
            wrong[x["wanted"], x["verdict"]] += 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/dynamics")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, help="a file for one JSON line per machine")
    parser.add_argument("--read", type=Path, help="only print the tables of such a file")
    parser.add_argument("--timeout", type=float, default=300)
    parser.add_argument("--make", type=Path, help="make machines in this folder first")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--skip", default="", help="systems to leave out, by comma")
    parser.add_argument("--at-least", type=float, default=0.0, metavar="SHARE",
                        help="fail if fewer machines than this share are accepted")
    parser.add_argument("--verbose", action="store_true")
    a = parser.parse_args()
    if a.read:
        table([json.loads(x) for x in a.read.read_text().splitlines()])
        return 0
    if a.make:
        command = [sys.executable, str(Path(__file__).with_name("simulate.py")), "--count", str(a.count),
                   "--seed", str(a.seed), "--out", str(a.make), "--jobs", str(a.jobs)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        a.folders.append(a.make)
    machines = sorted(p.parent for folder in a.folders for p in folder.glob("**/truth.json"))
    machines = [m for m in machines if not any(s and s in m.name for s in a.skip.split(","))]
    if not machines:
        parser.error("no machine to trace: give folders with a truth.json somewhere in them, or --make FOLDER")
    known = library()
    lines = []
    if a.out:
        a.out.write_text("")
    with ThreadPoolExecutor(a.jobs) as pool:
        for done in pool.map(lambda m: trace(m, a.program, a.timeout), machines):
            line = judge(*done, known)
            lines.append(line)
            if a.out:
                # At once, so that an interrupted run keeps what it has.
                with a.out.open("a") as out:
                    out.write(json.dumps(line) + "\n")
            if a.verbose:
                print(json.dumps({k: line[k] for k in ("id", "wanted", "verdict", "truth", "found", "seconds")}),
                      flush=True)
    table(lines)
    accepted = sum(line["accepted"] for line in lines)
    if accepted < a.at_least * len(lines):
        print(f"{accepted} of {len(lines)} accepted; at least {100 * a.at_least:.0f} % are demanded", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
