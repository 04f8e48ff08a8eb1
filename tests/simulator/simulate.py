#!/usr/bin/env python3
"""Makes random test machines: DIR/<id>/{train.csv,test.csv,nominal.json,truth.json}.

    python simulate.py --count 200 --seed 7 --out DIR [--jobs 2]
    python simulate.py --set controls widths many --out DIR [--jobs 2]     frozen sets, in folders of their names

Machine i of a seed does not depend on --count or --jobs. See ../README.md.
"""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

import disturbing
import effects as fx
import quadrotors
import sensing
import wheelbots
import writing
from machine import VISIBLE, Machine, Untamed
from sets import frozen, recipe
from systems import SYSTEMS, rounded

CLASSES = {"none": 0.15, "parameter": 0.15, "effect": 0.48, "combo": 0.14, "unknown": 0.08}
ROBOTS = {"wheelbot": wheelbots, "quadrotor": quadrotors}
"""What makes the machines of a set that says which robot it is of."""
DRAWS = 6


def pick(rng, options):
    """One of a list, uniformly."""
    return options[rng.integers(len(options))]


def draw_effects(machine, rng, verdict, only):
    """Effects of a class at random places; of a combination, neither hides in the other."""
    if verdict == "none":
        return []
    if verdict == "parameter":
        names = [["parameter"]]
    elif verdict == "unknown":
        names = [[k.name for k in fx.KINDS.values() if k.source == fx.OUTSIDE]]
    else:
        library = [k.name for k in fx.KINDS.values() if k.source == fx.LIBRARY and k.name != "parameter"]
        if machine.suite is not None:
            # Coordinates that no column shows are not read wrongly.
            hidden = sensing.TEMPLATES
            library = [n for n in library if fx.KINDS[n].family != "sensor" and n not in hidden]
        names = [library] * (2 if verdict == "combo" else 1)
    while True:
        found = []
        for position, possible in enumerate(names):
            if only and position == 0:
                possible = [n for n in possible if n == only] or possible
            name = pick(rng, [n for n in possible if fx.places(machine.system, n)])
            where, on = pick(rng, fx.places(machine.system, name))
            found.append(machine.effect(name, where, on, rng.random(3)))
        if not (len(found) == 2 and fx.nested(machine.system, *found)):
            return found


def classes_for(only):
    """Class weights, restricted to those that contain the wanted effect."""
    if not only:
        return CLASSES
    kind = fx.KINDS[only]
    wanted = "unknown" if kind.source == fx.OUTSIDE else "parameter" if only == "parameter" else "effect"
    return {wanted: 1.0}


def tame_machine(system, rng, noise_scale, feedback, **more):
    """A machine of the system whose nominal motion stays in range."""
    for _ in range(DRAWS):
        try:
            return Machine(system, rng, noise_scale, feedback, **more)
        except Untamed:
            continue
    raise Untamed(f"{system.name}: no nominal motion in range in {DRAWS} draws")


def build(index, seed, system=None, verdict=None, only=None, noise_scale=1.0, feedback="true", disturbed=None,
          width=None, given=None, sensed=False, misread=False):
    """Draws and calibrates machine `index` of a seed; returns (id, machine, class, score).

    disturbed: names of `disturbing.py`; width: the range of the smooth sign's width, drawn by its
    logarithm; given: effects with their places, instead of drawn ones; sensed: a log of sensors
    (sensing.py) instead of coordinates; misread: one of these reads wrongly.
    """
    rng = np.random.default_rng([seed, index])
    # What only some sets have is drawn apart, so that the others stay as they are.
    own, more = np.random.default_rng([seed, index, 1]), {}
    if disturbed is not None:
        more["disturbance"] = disturbing.draw(disturbed, own)
    if width:
        more["width"] = rounded(np.exp(own.uniform(*np.log(width))))
    possible = [s for s in (sensing.SYSTEMS if sensed else SYSTEMS) if system in (None, s)]
    if only:
        possible = [s for s in possible if fx.places(SYSTEMS[s], only)]
    if not possible:
        raise ValueError(f"effect {only} has no place in system {system}")
    # planar arms of every size count as one system
    groups = sorted({s.rstrip("345") for s in possible})
    group = pick(rng, groups)
    name = pick(rng, [s for s in possible if s.rstrip("345") == group])
    weights = classes_for(only) if verdict is None else {verdict: 1.0}
    drawn = str(rng.choice(list(weights), p=np.array(list(weights.values())) / sum(weights.values())))
    # Some machines leave their range with any effect: another of the system, then.
    for _ in range(DRAWS):
        machine = tame_machine(SYSTEMS[name], rng, noise_scale, feedback, **more)
        machine.suite = sensing.draw(machine, own) if sensed else None
        score = visible_effects(machine, rng, drawn, only, given)
        if misread and machine.suite is not None:
            machine.suite.misread.update(sensing.draw_misread(machine, own))
        if score is not None:
            return f"s{seed}_{index:04d}_{name}", machine, drawn, score
    raise RuntimeError(f"seed {seed}, machine {index}: no motion in range")


def given_effects(machine, rng, given):
    """Effects by name at the stated places, `all` for every one."""
    found = []
    for name, wanted in given.items():
        for where, on in fx.places(machine.system, name):
            if wanted == "all" or on == wanted:
                found.append(machine.effect(name, where, on, rng.random(3)))
    return found


def visible_effects(machine, rng, verdict, only, given=None):
    """Gives a machine effects that show, if some draw does; its scores, None if none moves in range."""
    for _ in range(DRAWS):
        machine.effects = given_effects(machine, rng, given) if given else draw_effects(machine, rng, verdict, only)
        targets = np.exp(rng.uniform(np.log(3.0), np.log(9.0), len(machine.effects)))
        score = machine.calibrate(targets)
        if score is not None and all(s >= VISIBLE for s in machine.visibility(score)):
            break
    return score


def make_of_set(index, entry, out):
    """Builds and writes one machine of a frozen set."""
    if "robot" in entry:
        return ROBOTS[entry["robot"]].make(index, entry["seed"], out)
    return make(index, entry["seed"], out, **recipe(entry, index))


def make(index, seed, out, **options):
    """Builds and writes one machine; returns a line about it."""
    name, machine, verdict, score = build(index, seed, **options)
    truth = writing.write(out / name, name, machine, verdict, score, seed, index)
    what = " + ".join(f"{e['type']} on {','.join(e['on'])}" for e in truth["effects"]) or "-"
    shown = " ".join(f"{e['visibility']:.1f}" for e in truth["effects"] if e["visibility"] is not None)
    return f"{name:32s} {verdict:10s} {what:46s} {shown}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    sets = frozen()["simulated"]
    parser.add_argument("--set", nargs="+", default=[], choices=sorted(sets), help="sets of frozen.toml")
    parser.add_argument("--count", type=int, help="without --set; with it all that the set has")
    parser.add_argument("--seed", type=int, help="without --set")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--first", type=int, default=0, help="index of the first machine")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--system", choices=sorted(SYSTEMS))
    parser.add_argument("--class", dest="verdict", choices=sorted(CLASSES))
    parser.add_argument("--effect", dest="only", choices=sorted(fx.KINDS))
    parser.add_argument("--noise-scale", type=float, default=1.0, help="0: no noise, no quantisation")
    parser.add_argument("--feedback", choices=("true", "measured"), default="true",
                        help="what the soft feedback sees: the true state, or the noisy one")
    parser.add_argument("--sensed", action="store_true", help="sensors instead of coordinates")
    parser.add_argument("--misread", action="store_true", help="with --sensed: one of them reads wrongly")
    a = parser.parse_args()
    if not a.set and None in (a.count, a.seed):
        parser.error("give --set NAME, or --count and --seed")
    try:
        for name in a.set:
            entry = sets[name]
            count = a.count or entry["count"] - a.first
            run(partial(make_of_set, entry=entry, out=a.out / name), range(a.first, a.first + count), a.jobs)
        if not a.set:
            work = partial(make, seed=a.seed, out=a.out, system=a.system, verdict=a.verdict, only=a.only,
                           noise_scale=a.noise_scale, feedback=a.feedback, sensed=a.sensed, misread=a.misread)
            run(work, range(a.first, a.first + a.count), a.jobs)
    except (ValueError, RuntimeError) as error:
        print(f"simulate.py: {error}", file=sys.stderr)
        return 2
    return 0


def run(work, indices, jobs):
    """Makes machines and prints a line about each."""
    if jobs == 1:
        for index in indices:
            print(work(index), flush=True)
        return
    work(indices[0])  # fills numba's cache before the others look for it
    with ProcessPoolExecutor(jobs) as pool:
        for line in pool.map(work, indices):
            print(line, flush=True)


if __name__ == "__main__":
    sys.exit(main())
