#!/usr/bin/env python3
"""Checks of the simulator against CasADi, energy, step halving and a second effect route.

    python verify.py        exit code 1 if one check fails

Needs casadi; uses the derivations and stored figures of ../casadi.
"""

import json
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "casadi"))

import effects as fx  # noqa: E402
import plant  # noqa: E402
import rollout  # noqa: E402
import second_route  # noqa: E402
import simulate  # noqa: E402
from systems import SYSTEMS, no_effects  # noqa: E402

FAILED = []


def report(name, error, limit):
    """Prints one figure and remembers a failure."""
    good = bool(error <= limit)
    print(f"{'ok  ' if good else 'FAIL'} {name}: {error:.2e} (limit {limit:g})")
    if not good:
        FAILED.append(name)


def distance(x, y):
    """Largest difference relative to the size of y (at least 1)."""
    x, y = np.asarray(x), np.asarray(y)
    error = np.abs(x - y).max(initial=0)
    return np.inf if np.isnan(error) else error / max(np.abs(y).max(initial=0), 1.0)


def against_stored_figures():
    """Acceleration and multiplier at the stored random states of the eight models."""
    for name, system in SYSTEMS.items():
        path = HERE.parent / "casadi" / "expected" / f"{name}.json"
        if not path.exists():
            continue
        worst = 0.0
        for case in json.loads(path.read_text())["cases"]:
            p = system.vector(case["parameters"])
            q, v, u = (np.array(case[k], dtype=float) for k in "qvu")
            a, multipliers = plant.acceleration(system.code, p, system.constraints, np.array(system.driven),
                                                *no_effects(), q, v, case["t"], u, np.zeros(0), np.zeros(len(q)))
            worst = max(worst, distance(a, case["a"]), distance(multipliers, case["lambda"]))
        report(f"{name}: a, lambda against CasADi", worst, 1e-9)


def against_second_route():
    """Logs without noise: recorded accelerations against CasADi with the effects added by
    second_route.py, for no effect and for every effect in every system."""
    for name, system in SYSTEMS.items():
        rng = np.random.default_rng([11, zlib.crc32(name.encode())])
        machine = simulate.tame_machine(system, rng, 0.0, "true")
        for kind in [None, *fx.KINDS]:
            if kind and (not fx.places(system, kind) or fx.KINDS[kind].family == "sensor"):
                continue
            machine.effects = []
            if kind:
                possible = fx.places(system, kind)
                where, on = possible[rng.integers(len(possible))]
                machine.effects = [machine.effect(kind, where, on, rng.random(3))]
            run = machine.run("train")
            if not np.all(np.isfinite(run.q)):
                report(f"{name}, {kind or 'none'}: finite", np.inf, 0)
                continue
            expected, picked = second_route.accelerations(machine, run)
            limit = 1e-9 if kind not in second_route.INTEGRATED else 1e-4
            report(f"{name}, {kind or 'none'}: a along a log", distance(run.a[picked], expected), limit)


def motion_between_samples():
    """Forced motion under both holds, integrated again with CasADi's accelerations."""
    for name, system in SYSTEMS.items():
        for first_order in (True, False):
            rng = np.random.default_rng([19, zlib.crc32(name.encode())])
            machine = simulate.tame_machine(system, rng, 0.0, "true")
            machine.first_order = first_order
            run = machine.run("test")
            first, count = 100, 60
            q, v = second_route.shoot(machine, run, first, count)
            last = first + count
            error = max(np.abs(q - run.q[last]).max(), np.abs(v - run.v[last]).max() / 10)
            report(f"{name}, {'foh' if first_order else 'zoh'}: {count} samples integrated again", error, 1e-7)


def energy():
    """Unforced conservative machines keep their energy; constraints stay closed."""
    for name, system in SYSTEMS.items():
        rng = np.random.default_rng([13, zlib.crc32(name.encode())])
        parameters = system.sample(rng)
        if system.name == "duffing":
            parameters |= {"c1": 0.0, "c2": 0.0}
        if name == "duffing_constrained":
            parameters["p1"] = 0.0  # the control constraint then does no work
        p, n, m = system.vector(parameters), len(system.coords), system.constraints
        q, v = system.start(rng, p)
        v = v + rng.uniform(-1, 1, n)
        for _ in range(4):
            rollout.project(system.code, p, m, q, v, 0.0, *no_effects())
        nu, count = len(system.inputs), 2001
        zero = np.zeros((count + 1, nu))
        noise = np.zeros((count, n))
        found = rollout.simulate(system.code, p, m, np.array(system.driven), *no_effects(), q, v, zero,
                                 np.zeros((3, nu)), zero, noise, noise, 0.005, 10, True, True)
        total = second_route.energy(name, system, parameters)
        level = np.array([total(found[0][k], found[1][k]) for k in range(0, count, 20)])
        swing = max(np.ptp([total(found[0][k], 0 * q) for k in range(0, count, 20)]), abs(level[0]), 0.1)
        report(f"{name}: energy over 10 s", np.abs(level - level[0]).max() / swing, 1e-8)


def step_halving():
    """Half the step changes a forced log with an effect by less than the sensor could show."""
    for name, kind in (("pendulum2", "stribeck"), ("fourbar", "coulomb"), ("surface_particle", "contact_friction"),
                       ("duffing_constrained", "bouc_wen"), ("planar_arm4", "coulomb")):
        rng = np.random.default_rng([17, zlib.crc32(name.encode())])
        machine = simulate.tame_machine(SYSTEMS[name], rng, 1.0, "true")
        where, on = fx.places(machine.system, kind)[0]
        machine.effects = [machine.effect(kind, where, on, rng.random(3))]
        coarse = machine.run("test")
        steps = machine.substeps(fx.encode(machine.effects))
        machine.substeps = lambda records, steps=steps: 2 * steps
        fine = machine.run("test")
        # the first three seconds: later a double pendulum forgets its start
        reach = slice(0, 3 * machine.rate)
        report(f"{name}, {kind}: half the step", np.abs(coarse.q[reach] - fine.q[reach]).max(), 1e-5)


def determinism():
    """The same seed and index give the same bytes, whatever was made before."""
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        simulate.make(3, 5, Path(one))
        simulate.make(2, 5, Path(two))
        simulate.make(3, 5, Path(two))
        name = next(Path(one).iterdir()).name
        pairs = [(f.read_bytes(), (Path(two) / name / f.name).read_bytes()) for f in (Path(one) / name).iterdir()]
        report("same seed, same bytes", float(sum(a != b for a, b in pairs) + (len(pairs) < 4)), 0)


def main():
    against_stored_figures()
    against_second_route()
    motion_between_samples()
    energy()
    step_halving()
    determinism()
    print(f"{len(FAILED)} checks failed" if FAILED else "all checks hold")
    return 1 if FAILED else 0


if __name__ == "__main__":
    sys.exit(main())
