"""Trees with free bodies whose velocities are their twists, by Pinocchio.

    python free_trees.py > free_trees.json

The convention is Pinocchio's own: a free joint has seven positions (its origin, then a unit
quaternion x, y, z, w) and six velocities (linear, then angular, in the moving frame), and
derivatives by position are along the tangent.
"""
import json

import numpy as np
import pinocchio as pin

import random_trees
from random_trees import make, rotation

random_trees.rng = rng = np.random.default_rng(20261125)


def state(model, tip):
    data = model.createData()
    q = pin.integrate(model, pin.neutral(model), rng.uniform(-1.5, 1.5, model.nv))
    v, a, u = (rng.uniform(-1.5, 1.5, model.nv) for _ in range(3))
    mass = pin.crba(model, data, q)
    result = dict(q=q, v=v, a=a, u=u, M=np.triu(mass) + np.triu(mass, 1).T,
                  bias=pin.nonLinearEffects(model, data, q, v), tau=pin.rnea(model, data, q, v, a),
                  qdd=pin.aba(model, data, q, v, u))
    result["dtau_dq"], result["dtau_dv"], _ = (
        x.copy() for x in pin.computeRNEADerivatives(model, data, q, v, a))
    result["dqdd_dq"], result["dqdd_dv"], inverse = (
        x.copy() for x in pin.computeABADerivatives(model, data, q, v, u))
    result["Minv"] = np.triu(inverse) + np.triu(inverse, 1).T
    aligned = pin.LOCAL_WORLD_ALIGNED
    pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
    pin.updateFramePlacements(model, data)
    result["velocity"] = pin.getFrameVelocity(model, data, tip, aligned).vector
    result["Jdot_v"] = pin.getFrameClassicalAcceleration(model, data, tip, aligned).vector
    result["position"], result["R"] = data.oMf[tip].translation, data.oMf[tip].rotation
    result["J"] = pin.computeFrameJacobian(model, data, q, tip, aligned)
    return {k: np.asarray(x).tolist() for k, x in result.items()}


def main():
    trees = []
    for root, parents, kinds in [
        ("floating", [], []),
        ("floating", [0, 1, 0, 3, 4], ["revolute", "revolute", "prismatic", "fixed", "revolute"]),
        ("prismatic", [0, 1, 2, 3], ["revolute", "floating", "revolute", "revolute"]),
    ]:
        bodies, model, tip, offset = make(root, parents, kinds)
        tool = pin.SE3(rotation(), rng.normal(size=3) * 0.2)
        frame = model.addFrame(pin.Frame("tip", tip, offset * tool, pin.FrameType.OP_FRAME))
        trees.append(dict(
            gravity=model.gravity.linear.tolist(), bodies=bodies,
            tool=dict(rotation=tool.rotation.tolist(), translation=tool.translation.tolist()),
            states=[state(model, frame) for _ in range(4)]))
    print(json.dumps(dict(source=f"pinocchio {pin.__version__}", trees=trees)))


if __name__ == "__main__":
    main()
