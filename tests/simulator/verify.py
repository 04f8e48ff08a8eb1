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
import lagrange  # noqa: E402
import models  # noqa: E402
import plant  # noqa: E402
import quadrotors  # noqa: E402
import rollout  # noqa: E402
import second_route  # noqa: E402
import simulate  # noqa: E402
import wheelbot  # noqa: E402
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
        on_time, nameless = np.zeros(count + 1), np.zeros((count + 1, n))
        found = rollout.simulate(system.code, p, m, np.array(system.driven), *no_effects(), q, v, zero,
                                 np.zeros((3, nu)), zero, noise, noise, 0.005, on_time, 10, True, True, nameless)
        total = second_route.energy(name, system, parameters)
        level = np.array([total(found[0][k], found[1][k]) for k in range(0, count, 20)])
        swing = max(np.ptp([total(found[0][k], 0 * q) for k in range(0, count, 20)]), abs(level[0]), 0.1)
        report(f"{name}: energy over 10 s", np.abs(level - level[0]).max() / swing, 1e-8)


def step_halving():
    """Half the step changes a forced log with an effect by less than the sensor could show."""
    for name, kind in (("pendulum2", "stribeck"), ("fourbar", "coulomb"), ("surface_particle", "contact_friction"),
                       ("duffing_constrained", "bouc_wen"), ("planar_arm4", "coulomb"), ("pendulum2", "input_delay")):
        rng = np.random.default_rng([17, zlib.crc32(name.encode())])
        machine = simulate.tame_machine(SYSTEMS[name], rng, 1.0, "true")
        where, on = fx.places(machine.system, kind)[0]
        machine.effects = [machine.effect(kind, where, on, rng.random(3))]
        # what is held and late jumps between the ends of steps
        machine.first_order = machine.first_order and kind != "input_delay"
        coarse = machine.run("test")
        steps = machine.substeps(fx.encode(machine.effects))
        machine.substeps = lambda records, steps=steps: 2 * steps
        fine = machine.run("test")
        # the first three seconds: later a double pendulum forgets its start
        reach = slice(0, 3 * machine.rate)
        report(f"{name}, {kind}: half the step", np.abs(coarse.q[reach] - fine.q[reach]).max(), 1e-5)


def wheelbot_states():
    """Some states of the Wheelbot on the floor, with inputs and parameters of a body that is off its centre."""
    rng = np.random.default_rng(23)
    parameters = {**wheelbot.NOMINAL, "b_x": 0.01, "b_y": -0.02}
    p = np.array([*parameters.values(), *wheelbot.FAULTS.values()])
    for _ in range(20):
        q, w, u = rng.uniform(-1, 1, 7), rng.uniform(-5, 5, 5), rng.uniform(-1, 1, 2)
        _, v, a = (np.array(part).ravel() for part in wheelbot.MOTION(np.concatenate([q, w, [0, 0]]), u, p))
        yield parameters, p, q, v, a, u


def wheelbot_accelerations():
    """Maggi's equations against Lagrange's with multipliers, from the energies of ../casadi."""
    function, _ = lagrange.derive(next(m for m in models.LINEARISED if m.name == "wheelbot"))
    place = function.name_out().index("a")
    worst = 0.0
    for parameters, _, q, v, a, u in wheelbot_states():
        expected = function(q, v, u, 0.0, list(parameters.values()))[place]
        worst = max(worst, distance(a, np.array(expected).ravel()))
    report("wheelbot: a against Lagrange's equations", worst, 1e-10)


def wheelbot_instruments():
    """What an IMU feels against the second difference of where it is, and turns against the first of its axes."""
    step, worst = 1e-3, 0.0
    for _, p, q, v, a, _ in wheelbot_states():
        boards = [boards_at(q + h * v + h * h / 2 * a) for h in (-step, 0, step)]
        readings = np.array(wheelbot.INSTRUMENTS(q, v, a, p)).ravel()
        for imu, (before, now, after) in enumerate(zip(*boards)):
            pushed = (before[0] - 2 * now[0] + after[0]) / step**2 + [0, 0, wheelbot.NOMINAL["g"]]
            turned = now[1].T @ (after[1] - before[1]) / (2 * step)
            felt, turning = now[1].T @ pushed, [turned[2, 1], turned[0, 2], turned[1, 0]]
            worst = max(worst, distance(readings[12 + 3 * imu:15 + 3 * imu], felt),
                        distance(readings[3 * imu:3 * imu + 3], turning))
    report("wheelbot: IMUs against differences of their places", worst, 1e-3)


def boards_at(q):
    """Place and axes of each IMU."""
    upright = turned_about(2, q[4]) @ turned_about(0, q[2])
    chassis = upright @ turned_about(1, q[3])
    hub = np.array([q[0], q[1], 0]) + wheelbot.NOMINAL["r_w"] * upright[:, 2]
    mounts = [(np.array(place), np.deg2rad(turns)) for *place, z, x in wheelbot.MOUNTS for turns in [(z, x)]]
    return [(hub + chassis @ place, chassis @ turned_about(2, z) @ turned_about(0, x)) for place, (z, x) in mounts]


def turned_about(axis, angle):
    """Rodrigues' formula about one of the axes."""
    cross = np.cross(np.eye(3), np.eye(3)[axis])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def wheelbot_step():
    """Half the step changes the first fall of a robot with friction by less than its sensors could show."""
    ends = []
    for steps in (1, 2):
        x = np.zeros(14)
        x[2:4], p = 0.02, np.array([*wheelbot.NOMINAL.values(), *{**wheelbot.FAULTS, "dry_wheel": 0.02}.values()])
        for k in range(20 * steps):
            u = np.array([0.1 * np.sin(0.3 * (k // steps)), 0.05 * np.cos(0.3 * (k // steps))])
            x = np.array(wheelbot.ADVANCED(x, u, p, 0.01 / steps / wheelbot.STEPS))[:, -1]
        ends.append(x)
    report("wheelbot: half the step", np.abs(ends[0] - ends[1]).max(), 1e-6)


QUADROTOR = {"m": 0.7, "arm": 0.2, "drag": 0.3, "j": 0.012}
LADEN = quadrotors.Fault(carried=(0.08, 0.1, -0.06), centre=(0.01, -0.004), wind=0.4, damping=0.01)


def quadrotor_power():
    """What a quadrotor with a load and an offset gains in energy is what rotors, air and wind do at its origin."""
    machine = quadrotors.Quadrotor(QUADROTOR, LADEN)
    extra, *place = LADEN.carried
    parts = [(QUADROTOR["m"], LADEN.centre), (extra, place)]

    def energy(x):
        c, s = np.cos(x[2]), np.sin(x[2])
        total = 0.5 * QUADROTOR["j"] * x[5]**2
        for mass, (along, across) in parts:
            rx, rz = c * along - s * across, s * along + c * across
            total += 0.5 * mass * ((x[3] - x[5] * rz)**2 + (x[4] + x[5] * rx)**2) + mass * quadrotors.GRAVITY * (x[1] + rz)
        return total

    worst, rng = 0.0, np.random.default_rng(12)
    for _ in range(50):
        x, thrusts = rng.uniform(-2, 2, 8), rng.uniform(1, 6, 2)
        rate, h = machine.rates(x, thrusts)[0], 1e-6
        gained = (energy(x + h * rate) - energy(x - h * rate)) / (2 * h)
        pushed = np.array([-np.sin(x[2]), np.cos(x[2])]) * thrusts.sum() - QUADROTOR["drag"] * x[3:5] + [LADEN.wind, 0]
        torque = QUADROTOR["arm"] * (thrusts[1] - thrusts[0]) - LADEN.damping * x[5]
        power = pushed @ x[3:5] + torque * x[5]
        worst = max(worst, abs(gained - power) / max(1.0, abs(power)))
    report("quadrotor: energy against power", worst, 1e-6)


def quadrotor_step():
    """Half the step changes a second of flight with a slow rotor by less than its sensors could show."""
    machine = quadrotors.Quadrotor(QUADROTOR, quadrotors.Fault(lag=(0.03, 0.0)))
    ends = []
    for steps in (quadrotors.STEPS, 2 * quadrotors.STEPS):
        x, before = np.zeros(8), np.full(2, 3.4)
        for k in range(100):
            now = 3.4 + 0.1 * np.sin(0.2 * k + np.array([0.0, 0.1]))
            x, before = machine.tick(x, before, now, steps), now
        ends.append(x)
    report("quadrotor: half the step", np.abs(ends[0] - ends[1]).max(), 1e-6)


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
    wheelbot_accelerations()
    wheelbot_instruments()
    wheelbot_step()
    quadrotor_power()
    quadrotor_step()
    determinism()
    print(f"{len(FAILED)} checks failed" if FAILED else "all checks hold")
    return 1 if FAILED else 0


if __name__ == "__main__":
    sys.exit(main())
