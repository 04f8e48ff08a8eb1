#!/usr/bin/env python3
"""Writes (or with --check compares) floating/<robot>.json: robots that float, by Pinocchio.

    python floating.py            recreate
    python floating.py --check    recreate in memory and compare at 1e-12

The convention is Pinocchio's own: the base has seven positions (its origin, then a unit
quaternion x, y, z, w) and six velocities (linear, then angular, in its own frame), the joints
come behind it in Pinocchio's order, and derivatives by position are along the tangent.
"""

import json
import sys
import zlib
from pathlib import Path

import numpy as np
import pinocchio as pin

from derive import differences, write

HERE = Path(__file__).resolve().parent
ROBOTS = {"solo12": HERE.parents[1] / "models/solo12.urdf", "humanoid": HERE / "humanoid.urdf"}
LINKS = {"solo12": ["base_link", "FL_FOOT", "HR_LOWER_LEG"],
         "humanoid": ["right_wrist_yaw_link", "left_ankle_roll_link"]}
STATES = 2


def jacobian(model, data, q, link):
    """6 x n: velocity of the link's origin, then angular velocity, along the world's axes."""
    return pin.computeFrameJacobian(model, data, q, model.getFrameId(link),
                                    pin.ReferenceFrame.LOCAL_WORLD_ALIGNED).copy()


def state(model, links, rng):
    """All figures of one random state."""
    data = model.createData()
    q = pin.integrate(model, pin.neutral(model), rng.uniform(-1.5, 1.5, model.nv))
    v, a_in, driven = rng.uniform(-2, 2, (3, model.nv))
    # torques that move every joint alike, however light its link is; nothing drives the base
    tau = pin.rnea(model, data, q, v, driven).copy()
    tau[:6] = 0
    mass = pin.crba(model, data, q)
    figures = {"q": q, "v": v, "tau": tau, "a_in": a_in,
               "M": np.triu(mass) + np.triu(mass, 1).T,
               "bias": pin.nonLinearEffects(model, data, q, v).copy(),
               "a": pin.aba(model, data, q, v, tau).copy(),
               "tau_id": pin.rnea(model, data, q, v, a_in).copy()}
    dq, dv, _ = pin.computeRNEADerivatives(model, data, q, v, a_in)
    figures |= {"dtau_dq": dq.copy(), "dtau_dv": dv.copy()}
    dq, dv, inverse = pin.computeABADerivatives(model, data, q, v, tau)
    figures |= {"da_dq": dq.copy(), "da_dv": dv.copy(),
                "da_dtau": np.triu(inverse) + np.triu(inverse, 1).T}
    step = rng.uniform(-1, 1, model.nv)
    figures |= {"step": step, "moved": pin.integrate(model, q, step)}
    # a small displacement of the base, seen from the base, while it moves on by its twist
    figures |= {"carried": -pin.Motion(v[:6]).action,
                "J": [jacobian(model, data, q, link) for link in links]}
    return {key: (np.asarray(x) + 0.0).tolist() for key, x in figures.items()}


def document(name, path):
    """All figures of a robot."""
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    rng = np.random.default_rng([20261125, zlib.crc32(name.encode())])
    return {"urdf": path.name, "pinocchio_version": pin.__version__,
            "joints": list(model.names)[2:], "links": LINKS[name],
            "states": [state(model, LINKS[name], rng) for _ in range(STATES)]}


def main():
    wrong = []
    for name, path in ROBOTS.items():
        made, target = document(name, path), HERE / "floating" / f"{name}.json"
        if "--check" in sys.argv:
            wrong += [f"{name} {d}" for d in differences(json.loads(target.read_text()), made)]
        else:
            target.parent.mkdir(exist_ok=True)
            target.write_text(write(made) + "\n")
            print(f"{target.name}: {target.stat().st_size // 1024} kB")
    print("\n".join(wrong) or "all there", file=sys.stderr if wrong else sys.stdout)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
