#!/usr/bin/env python3
"""Writes (or with --check compares) expected/<urdf>.json: Pinocchio's figures of each URDF.

    python derive.py [URDF_DIR ...]            recreate
    python derive.py [URDF_DIR ...] --check    recreate in memory and compare at 1e-12

URDF_DIR defaults to ../shared/data/urdf and ../shared/oracles beside the repository.
Only figures are stored, never a URDF. The format is described in ../README.md.
"""

import argparse
import hashlib
import json
import os
import sys
import zlib
from pathlib import Path

import numpy as np
import pinocchio as pin

import crosscheck
from robot import Robot

HERE = Path(__file__).resolve().parent
SHARED = HERE.parents[2] / "shared"
SEED = 20240602
STATES = 20
LARGEST_FILE = 280_000
TOLERANCE = 1e-12


def draw(robot, rng):
    """A random state: q, v, accelerations for inverse and (through tau) forward dynamics."""
    q = rng.uniform(-2, 2, robot.nq)
    for name in robot.joints:
        rows = robot.q_range[name]
        if robot.types[name] == "prismatic":
            q[rows] *= 0.25
        elif rows.stop - rows.start == 7:
            quaternion = q[rows][3:]
            q[rows.start + 3:rows.stop] = quaternion / np.linalg.norm(quaternion)
    v = rng.uniform(-2, 2, robot.n)
    a_in, a_driven = rng.uniform(-5, 5, (2, robot.n))
    # a torque that moves every joint alike, however light its link is
    tau = robot.inverse_dynamics(q, v, a_driven)
    return q, v, a_in, tau


def state(robot, rng):
    """All figures of one random state, as arrays by name."""
    q, v, a_in, tau = draw(robot, rng)
    dtau_dq, dtau_dv = robot.inverse_derivatives(q, v, a_in)
    da_dq, da_dv, da_dtau = robot.forward_derivatives(q, v, tau)
    return {
        "q": q, "v": v, "tau": tau, "M": robot.mass_matrix(q), "bias": robot.bias(q, v),
        "a": robot.forward_dynamics(q, v, tau), "a_in": a_in,
        "tau_id": robot.inverse_dynamics(q, v, a_in),
        "dtau_dq": dtau_dq, "dtau_dv": dtau_dv,
        "da_dq": da_dq, "da_dv": da_dv, "da_dtau": da_dtau,
        "J": np.array([robot.jacobian(q, link) for link in robot.links]),
        "Jdot_v": np.array([robot.jacobian_rate_v(q, v, link) for link in robot.links]),
    }


def document(path, files, mimic):
    """Document of one URDF and the list of failed cross-checks."""
    robot = Robot(path, mimic)
    rng = np.random.default_rng([SEED, zlib.crc32(path.name.encode()), int(mimic)])
    made = [state(robot, rng) for _ in range(STATES)]
    wrong = [f"{path.name}: {w}" for s in made for w in crosscheck.failures(robot, s)]
    declared = Robot(path, True).mimics
    head = {
        "urdf": path.name, "same_content": files,
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "pinocchio_version": pin.__version__, "gravity": [0.0, 0.0, -9.81],
        "base": "fixed" if "floating" not in robot.types.values() else "floating joint of the file",
        "mimic": ("tied" if mimic else "independent") if declared else "none",
        "mimic_joints": [{"joint": j, "of": k, "multiplier": f, "offset": o}
                         for j, (k, f, o) in declared.items()],
        "n": robot.n, "joints": robot.joints,
        "joint_types": [robot.types[j] for j in robot.joints],
        "joints_in_file": [j for j in robot.file_joints if j in robot.joints],
        "links": robot.links,
    }
    states = [{k: (x + 0.0).tolist() for k, x in s.items()} for s in made]
    per_state = len(write(states[0])) + 2
    keep = min(STATES, max(1, (LARGEST_FILE - len(write(head))) // (per_state + per_state // 20)))
    return {**head, "states": states[:keep]}, wrong


def write(value):
    """Compact JSON with 17 significant digits."""
    if isinstance(value, dict):
        return "{" + ",".join(f"{json.dumps(k)}:{write(x)}" for k, x in value.items()) + "}"
    if isinstance(value, list):
        separator = ",\n" if value and isinstance(value[0], dict) else ","
        return "[" + separator.join(write(x) for x in value) + "]"
    return f"{value:.17g}" if isinstance(value, float) else json.dumps(value)


def differences(expected, found):
    """Yields what differs: the head exactly, arrays to TOLERANCE of their largest entry."""
    for key in sorted(expected.keys() | found.keys()):
        if key != "states" and expected.get(key) != found.get(key):
            yield f"{key}: {expected.get(key)!r} is not {found.get(key)!r}"
    if len(expected.get("states", [])) != len(found["states"]):
        yield "number of states"
        return
    for i, (old, new) in enumerate(zip(expected["states"], found["states"])):
        if old.keys() != new.keys():
            yield f"state {i}: keys"
            continue
        for key in old:
            x, y = np.array(old[key]), np.array(new[key])
            if x.shape != y.shape:
                yield f"state {i}: shape of {key}"
            elif not np.abs(x - y).max(initial=0) <= TOLERANCE * max(np.abs(x).max(initial=0), 1e-300):
                yield f"state {i}: {key} {np.abs(x - y).max():.3g} apart, size {np.abs(x).max():.3g}"


def urdf_files(folders):
    """[(path, names of all files with this content)], each content once; the first folder wins."""
    by_content = {}
    for folder in folders:
        for path in sorted(folder.glob("*.urdf")):
            by_content.setdefault(path.read_bytes(), []).append(path)
    return [(paths[0], sorted({p.name for p in paths})) for paths in by_content.values()]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path, metavar="URDF_DIR",
                        default=[SHARED / "data/urdf", SHARED / "oracles"])
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    parser.add_argument("--out", type=Path, default=HERE / "expected")
    arguments = parser.parse_args()
    files = urdf_files(arguments.folders)
    if not files:
        where = ", ".join(str(f) for f in arguments.folders)
        print(f"no URDF in {where}", file=sys.stderr)
        return 1 if os.environ.get("CI") or arguments.check else 0
    wrong, names = [], {}
    for path, same in files:
        declared = Robot(path, True).mimics
        for mimic in ((True, False) if declared else (True,)):
            name = path.stem + ("" if mimic else "_independent") + ".json"
            if names.setdefault(name, path) != path:
                wrong.append(f"{name}: two different URDFs of that name")
                continue
            made, failed = document(path, same, mimic)
            wrong += failed
            target = arguments.out / name
            if arguments.check and not target.exists():
                wrong.append(f"{name}: missing, run derive.py")
            elif arguments.check:
                wrong += [f"{name} {d}" for d in differences(json.loads(target.read_text()), made)]
            else:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text(write(made) + "\n")
                print(f"{name}: n {made['n']}, {len(made['states'])} states, "
                      f"{target.stat().st_size // 1024} kB")
    if arguments.check:
        wrong += [f"{p.name}: no URDF for it" for p in arguments.out.glob("*.json") if p.name not in names]
    print("\n".join(wrong), file=sys.stderr) if wrong else print(f"{len(names)} files, all checks hold")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
