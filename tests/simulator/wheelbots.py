"""Random Wheelbots, each with one effect that its model lacks or with none: their logs and truth.

    python wheelbots.py --count 50 --seed 7 --out DIR [--jobs 2]

A machine is a folder DIR/<id> with train.csv, test.csv, nominal.json and truth.json, like those of
simulate.py. Every sixth is a control, with nothing missing.
"""

import argparse
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from wheelbot import NOMINAL, WIDTH, Fallen, Fault, run, write

SECONDS = {"train": 8.0, "test": 5.0}
CONTROLS_EVERY = 6
"""Of so many machines one is a control."""
DRAWS = 20
SLOPE = (0.01, 0.04)
"""Sine of the floor's angle."""


def between(rng, least, most):
    """A number drawn by its logarithm."""
    return float(least * (most / least)**rng.uniform())


def either(rng):
    """A sign."""
    return float(rng.choice([-1.0, 1.0]))


def no_fault(rng):
    return Fault()


def dry_wheel(rng):
    force = between(rng, 0.008, 0.03)
    return Fault("drive_friction", ("wheel",), {"f_c": force, "v_s": WIDTH["axle"]}, {"dry_wheel": force})


def dry_reaction(rng):
    force = between(rng, 0.004, 0.02)
    return Fault("coulomb", ("reaction",), {"f_c": force, "v_s": WIDTH["axle"]}, {"dry_reaction": force})


def off_centre(rng):
    """A body whose centre of mass is off along one of its level axes."""
    name, offset = str(rng.choice(["b_x", "b_y"])), either(rng) * between(rng, 0.0015, 0.006)
    return Fault("parameter", (name,), {"name": name, "nominal": 0.0, "true": offset}, {name: offset})


def tilted_imu(rng):
    """A board that is turned about one of its axes."""
    imu, axis, angle = int(rng.integers(4)), str(rng.choice(list("xyz"))), either(rng) * between(rng, 0.03, 0.15)
    return Fault("mounting_tilt", (f"imu_{imu + 1}",), {f"phi_{axis}": angle}, mount=(imu, axis, angle))


def sloping_floor(rng):
    steep, towards = between(rng, *SLOPE), rng.uniform(0, 2 * np.pi)
    x, y = float(steep * np.cos(towards)), float(steep * np.sin(towards))
    # Gravity (0, 0, -g) turned by phi is g (-phi_y, phi_x, -1) to first order.
    return Fault("gravity_tilt", (), {"phi_x": y, "phi_y": -x}, {"slope_x": x, "slope_y": y})


def late_current(rng):
    """A current loop that is late by a time, or lags; by more than half a tick, which a log cannot tell from how its
    inputs go between samples."""
    name, late = str(rng.choice(["reaction", "wheel"])), between(rng, 0.006, 0.0098)
    if rng.uniform() < 0.5:
        times = tuple(late if name == drive else 0.0 for drive in ("reaction", "wheel"))
        return Fault("input_delay", (name,), {"tau": late}, delay=times)
    return Fault("input_lag", (name,), {"tau": late}, {f"lag_{name}": late})


def rolling_resistance(rng):
    force = between(rng, 0.15, 0.6)
    return Fault("rolling_resistance", ("x", "y"), {"f": force, "v_s": WIDTH["tread"]}, {"rolling": force})


def wrong_radius(rng):
    radius = NOMINAL["r_w"] + either(rng) * between(rng, 0.001, 0.005)
    return Fault("parameter", ("r_w",), {"name": "r_w", "nominal": NOMINAL["r_w"], "true": radius}, {"r_w": radius})


FAULTS = (dry_wheel, dry_reaction, off_centre, tilted_imu, sloping_floor, late_current, rolling_resistance,
          wrong_radius)

TWINS = {("rolling_resistance", "x"): ("coulomb", ["wheel"]),
         ("parameter", "b_x"): ("com_offset", ["frame_body"]), ("parameter", "b_y"): ("com_offset", ["frame_body"])}
"""What no log tells from an effect at its first place: a wheel that rolls without slipping turns as it goes, and an
offset of a centre of mass may be called by its parameter."""


def truth(name, seed, index, fault):
    """Contents of truth.json."""
    kind = fault.effect
    verdict = {"none": "none", "parameter": "parameter"}.get(kind, "effect")
    twin = TWINS.get((kind, fault.on[0])) if fault.on else None
    near = [{"type": twin[0], "on": twin[1], "r2": 1.0}] if twin else []
    effects = [{"type": kind, "on": list(fault.on), "params": fault.parameters, "visibility": None,
                "near_equivalents": near}] if kind != "none" else []
    return {"id": name, "system": "wheelbot", "class": verdict, "effects": effects, "seed": seed, "index": index,
            "noise_level": 1.0, "hold": "zoh", "oracle": {"test": {"acc_nrmse_floor": None}}}


def make(index, seed, out):
    """Writes one machine; returns a line about it."""
    rng = np.random.default_rng([seed, index])
    kinds = FAULTS if index % CONTROLS_EVERY else (no_fault,)
    for _ in range(DRAWS):
        fault = kinds[rng.integers(len(kinds))](rng)
        try:
            logs = {which: run(rng, fault, seconds) for which, seconds in SECONDS.items()}
            break
        except Fallen:
            continue
    else:
        raise RuntimeError(f"seed {seed}, machine {index}: none of {DRAWS} robots balances")
    name = f"s{seed}_{index:04d}_wheelbot"
    folder = out / name
    folder.mkdir(parents=True, exist_ok=True)
    for which, (t, torques, readings, _) in logs.items():
        write(folder / f"{which}.csv", t, torques, readings)
    (folder / "nominal.json").write_text(json.dumps({"nominal": NOMINAL}, indent=1) + "\n")
    (folder / "truth.json").write_text(json.dumps(truth(name, seed, index, fault), indent=1) + "\n")
    return f"{name:22s} {fault.effect} on {','.join(fault.on) or '-'}  {fault.parameters or ''}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--first", type=int, default=0, help="index of the first machine")
    parser.add_argument("--jobs", type=int, default=1)
    a = parser.parse_args()
    work, indices = partial(make, seed=a.seed, out=a.out), range(a.first, a.first + a.count)
    with ProcessPoolExecutor(a.jobs) as pool:
        for line in pool.map(work, indices):
            print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
