#!/usr/bin/env python3
"""Writes (or with --check compares) sensors.json: what an inertial sensor on a robot shows.

    python sensors.py            recreate
    python sensors.py --check    recreate in memory and compare at 1e-12

The sensor is mounted on the last link, away from its origin and turned. Angular velocity and
acceleration of its frame come from Pinocchio's forward kinematics along its own axes, with the
accelerations of Pinocchio's forward dynamics; gravity is taken off as the sensor feels it.
The format is described in ../README.md.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin

from derive import write

HERE = Path(__file__).resolve().parent
MODELS = HERE.parents[1] / "models"
SEED = 20240603
STATES = 10
TOLERANCE = 1e-12
ROBOTS = (("iiwa7", "link_7"), ("ur5", "wrist_3_link"))
# where the sensor is in the link's frame: a translation, then turns about x and z
OFFSET, ABOUT_X, ABOUT_Z = (0.05, -0.02, 0.1), 0.4, -0.7


def turn(axis, angle):
    """Rotation about a unit axis."""
    return pin.AngleAxis(angle, np.array(axis, dtype=float)).toRotationMatrix()


def mount(model, link, name):
    """A frame of this name on a link, away from its origin and turned."""
    on = model.getFrameId(link)
    mounted = pin.SE3(turn((1, 0, 0), ABOUT_X) @ turn((0, 0, 1), ABOUT_Z), np.array(OFFSET))
    return model.addFrame(pin.Frame(name, model.frames[on].parentJoint, on,
                                    model.frames[on].placement * mounted, pin.FrameType.OP_FRAME))


def robot(name, link):
    """The states of one robot with what the sensor shows."""
    model = pin.buildModelFromUrdf(str(MODELS / f"{name}.urdf"))
    board = mount(model, link, "board")
    data = model.createData()
    rng = np.random.default_rng([SEED, len(name)])
    states = []
    for _ in range(STATES):
        q, v = rng.uniform(-2, 2, (2, model.nv))
        tau = pin.rnea(model, data, q, v, rng.uniform(-5, 5, model.nv))
        a = pin.aba(model, data, q, v, tau)
        pin.forwardKinematics(model, data, q, v, a)
        pin.updateFramePlacements(model, data)
        turning = pin.getFrameVelocity(model, data, board, pin.LOCAL).angular
        moving = pin.getFrameClassicalAcceleration(model, data, board, pin.LOCAL).linear
        felt = moving - data.oMf[board].rotation.T @ model.gravity.linear
        shown = {"q": q, "v": v, "tau": tau, "gyro": turning, "felt": felt}
        states.append({key: (np.array(x) + 0.0).tolist() for key, x in shown.items()})
    return {"urdf": f"{name}.urdf", "link": link, "joints": list(model.names)[1:], "states": states}


def document():
    """The whole file."""
    return {"pinocchio_version": pin.__version__, "translate": list(OFFSET),
            "rotate_x": ABOUT_X, "rotate_z": ABOUT_Z, "robots": [robot(*r) for r in ROBOTS]}


def apart(old, new):
    """Whether two documents differ."""
    if isinstance(old, dict):
        return old.keys() != new.keys() or any(apart(old[k], new[k]) for k in old if k != "states") \
            or any(apart(x, y) for x, y in zip(old.get("states", []), new.get("states", [])))
    if isinstance(old, list) and old and isinstance(old[0], (float, int)):
        x, y = np.array(old), np.array(new)
        return x.shape != y.shape or np.abs(x - y).max() > TOLERANCE * max(1.0, np.abs(x).max())
    if isinstance(old, list):
        return len(old) != len(new) or any(apart(x, y) for x, y in zip(old, new))
    return old != new


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    arguments = parser.parse_args()
    path, made = HERE / "sensors.json", document()
    if not arguments.check:
        path.write_text(write(made) + "\n")
        print(f"{path.name}: {path.stat().st_size // 1024} kB")
        return 0
    if apart(json.loads(path.read_text()), made):
        print(f"{path.name}: does not agree, run sensors.py", file=sys.stderr)
        return 1
    print(f"{path.name} agrees")
    return 0


if __name__ == "__main__":
    sys.exit(main())
