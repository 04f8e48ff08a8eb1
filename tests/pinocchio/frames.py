#!/usr/bin/env python3
"""Writes (or with --check compares) frames.json: where frames of a seven-joint arm are and how they move.

    python frames.py            recreate
    python frames.py --check    recreate in memory and compare at 1e-12

Figures are those of a link in the middle of the arm and of a tool that is mounted on the last one,
away from its origin and turned, as `sensors.py` mounts its board. The format is described in
../README.md.
"""

import json
import sys

import numpy as np
import pinocchio as pin

from derive import differences, write
from sensors import ABOUT_X, ABOUT_Z, HERE, MODELS, OFFSET, mount

SEED = 20261126
STATES = 10
ARM, LINK, MOUNTED_ON = "iiwa7.urdf", "link_4", "link_7"


def figures(model, data, frame, q, v):
    """Place, Jacobian and its rate by v of one frame, along the world's axes."""
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    jacobian = pin.computeFrameJacobian(model, data, q, frame, aligned).copy()
    pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
    pin.updateFramePlacements(model, data)
    place = data.oMf[frame]
    return {"position": place.translation.copy(), "rotation": place.rotation.copy(), "J": jacobian,
            "Jdot_v": pin.getFrameClassicalAcceleration(model, data, frame, aligned).vector}


def document():
    """The whole file."""
    model = pin.buildModelFromUrdf(str(MODELS / ARM))
    frames = {LINK: model.getFrameId(LINK), "tool": mount(model, MOUNTED_ON, "tool")}
    data = model.createData()
    rng = np.random.default_rng(SEED)
    states = []
    for _ in range(STATES):
        q, v = rng.uniform(-2, 2, (2, model.nv))
        shown = {"q": q, "v": v}
        for name, frame in frames.items():
            found = figures(model, data, frame, q, v)
            shown |= {f"{name} {key}": value for key, value in found.items()}
        states.append({key: (np.array(x) + 0.0).tolist() for key, x in shown.items()})
    return {"urdf": ARM, "pinocchio_version": pin.__version__, "link": LINK, "mounted_on": MOUNTED_ON,
            "translate": list(OFFSET), "rotate_x": ABOUT_X, "rotate_z": ABOUT_Z,
            "joints": list(model.names)[1:], "states": states}


def main():
    made, target = document(), HERE / "frames.json"
    if "--check" not in sys.argv:
        target.write_text(write(made) + "\n")
        print(f"{target.name}: {target.stat().st_size // 1024} kB")
        return 0
    wrong = list(differences(json.loads(target.read_text()), made))
    print("\n".join(wrong) or "all there", file=sys.stderr if wrong else sys.stdout)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
