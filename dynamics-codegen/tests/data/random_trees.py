"""Random trees of rigid bodies with their dynamics, by Pinocchio.

    python random_trees.py > random_trees.json

Trees that a serial arm does not exercise: branches, general axes, placements,
inertias, fixed bodies, planar and floating roots. Coordinates are those of the
crate under test: a floating body has its position and a unit quaternion
(x, y, z, w), and all velocities are time derivatives of coordinates. Pinocchio
uses body velocities; with w = 2 E(n) n' and v_body = R' p' its M, bias and
accelerations are carried over by the chain rule.
"""
import json
import numpy as np
import pinocchio as pin

rng = np.random.default_rng(20240611)


def rotation():
    q = rng.normal(size=4)
    return pin.Quaternion(*(q / np.linalg.norm(q))).toRotationMatrix()


def inertia():
    # A positive definite second-moment matrix makes a physical tensor.
    a = rng.normal(size=(3, 3)) * 0.2
    s = a @ a.T
    mass = rng.uniform(0.5, 3.0)
    return mass, rng.normal(size=3) * 0.1, mass * (np.trace(s) * np.eye(3) - s)


def make(root, parents, kinds):
    """Bodies as plain data, and the same as a Pinocchio model."""
    model, bodies, joint_of, offset_of = pin.Model(), [], [], []
    for i, (parent, kind) in enumerate(zip([None] + parents, [root] + kinds)):
        place = pin.SE3(rotation(), rng.normal(size=3) * 0.3)
        if i == 2:  # one axis parallel to its parent's, one placement along an axis
            place = pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.1]))
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        if i in (1, 2):
            axis = np.array([0.0, 0.0, 1.0])
        mass, com, tensor = inertia()
        outer, offset = (0, pin.SE3.Identity()) if parent is None else (joint_of[parent], offset_of[parent])
        if kind == "fixed":
            joint, own = outer, offset * place
        else:
            model_joint = {
                "revolute": lambda: pin.JointModelRevoluteUnaligned(axis),
                "prismatic": lambda: pin.JointModelPrismaticUnaligned(axis),
                "floating": pin.JointModelFreeFlyer,
                "planar": pin.JointModelPlanar,
            }[kind]()
            joint = model.addJoint(outer, model_joint, offset * place, f"joint{i}")
            own = pin.SE3.Identity()
        if joint > 0:
            model.appendBodyToJoint(joint, pin.Inertia(mass, com, tensor), own)
        joint_of.append(joint)
        offset_of.append(own)
        bodies.append(dict(parent=parent, kind=kind, axis=axis.tolist(), rotation=place.rotation.tolist(),
                           translation=place.translation.tolist(), mass=mass, center=com.tolist(),
                           tensor=tensor.tolist()))
    model.gravity.linear = np.array([1.0, -2.0, -9.0])
    return bodies, model, joint_of[-1], offset_of[-1]


def e_matrix(n):
    x, y, z, w = n
    return np.array([[w, z, -y, -x], [-z, w, x, -y], [y, -x, w, -z]])


def to_pinocchio(root, q, v):
    """q, v and the map J with v_pin = J v, and J' v."""
    if root == "floating":
        n, dn = q[3:7], v[3:7]
        r = pin.Quaternion(np.array(n)).toRotationMatrix()
        w = 2 * e_matrix(n) @ dn
        j = np.zeros((len(v) - 1, len(v)))
        j[0:3, 0:3] = r.T
        j[3:6, 3:7] = 2 * e_matrix(n)
        j[6:, 7:] = np.eye(len(v) - 7)
        drift = np.zeros(len(v) - 1)
        drift[0:3] = -np.cross(w, r.T @ v[0:3])  # E(n') n' = 0
        return q, j, drift
    if root == "planar":
        c, s, rate = np.cos(q[2]), np.sin(q[2]), v[2]
        qp = np.concatenate([q[:2], [c, s], q[3:]])
        j = np.eye(len(v))
        j[:2, :2] = [[c, s], [-s, c]]
        drift = np.zeros(len(v))
        drift[:2] = rate * np.array([[-s, c], [-c, -s]]) @ v[:2]
        return qp, j, drift
    return q, np.eye(len(v)), np.zeros(len(v))


def state(root, model, size):
    data = model.createData()
    q, v, a, u = (rng.uniform(-1.5, 1.5, size) for _ in range(4))
    if root == "floating":
        q[3:7] /= np.linalg.norm(q[3:7])
        v[3:7] -= q[3:7] * (q[3:7] @ v[3:7])
        a[3:7] -= q[3:7] * (q[3:7] @ a[3:7] + v[3:7] @ v[3:7])
        u[3:7] -= q[3:7] * (q[3:7] @ u[3:7])
    qp, j, drift = to_pinocchio(root, q, v)
    vp = j @ v
    mass = pin.crba(model, data, qp)
    mass = np.triu(mass) + np.triu(mass, 1).T
    nle = pin.rnea(model, data, qp, vp, np.zeros_like(vp))
    result = dict(q=q, v=v, a=a, u=u, M=j.T @ mass @ j, bias=j.T @ (nle + mass @ drift),
                  tau=j.T @ pin.rnea(model, data, qp, vp, j @ a + drift))
    # Q_pin with J' Q_pin = u: for the quaternion E u / 2 (u is tangent).
    force = np.linalg.pinv(j.T) @ u
    ap = pin.aba(model, data, qp, vp, force)
    if root == "floating":
        qdd = np.zeros(size)
        e, w = e_matrix(q[3:7]), vp[3:6]
        r = j[0:3, 0:3].T
        qdd[0:3] = r @ (ap[0:3] + np.cross(w, vp[0:3]))
        qdd[3:7] = 0.5 * e.T @ ap[3:6] - 0.25 * (w @ w) * q[3:7]
        qdd[7:] = ap[6:]
    else:
        qdd = np.linalg.solve(j, ap - drift)
    result["qdd"] = qdd
    if root not in ("floating", "planar"):
        pin.computeRNEADerivatives(model, data, q, v, a)
        result["dtau_dq"], result["dtau_dv"] = data.dtau_dq.copy(), data.dtau_dv.copy()
        pin.computeABADerivatives(model, data, q, v, u)
        result["dqdd_dq"], result["dqdd_dv"] = data.ddq_dq.copy(), data.ddq_dv.copy()
    frame = pin.LOCAL_WORLD_ALIGNED
    pin.forwardKinematics(model, data, qp, vp, np.zeros_like(vp) + drift)
    pin.computeJointJacobians(model, data, qp)
    pin.framesForwardKinematics(model, data, qp)
    fid = model.nframes - 1
    jac = pin.getFrameJacobian(model, data, fid, frame)
    acc = pin.getFrameClassicalAcceleration(model, data, fid, frame).vector
    result["J"], result["Jdot_v"] = jac @ j, acc
    result["position"], result["R"] = data.oMf[fid].translation, data.oMf[fid].rotation
    return {k: np.asarray(x).tolist() for k, x in result.items()}


def main():
    # Depth first: Pinocchio expects the joints of a subtree side by side.
    trees = []
    for root, parents, kinds in [
        ("revolute", [0, 1, 2, 1, 4, 4, 6], ["revolute", "revolute", "prismatic", "revolute", "revolute", "fixed", "revolute"]),
        ("prismatic", [0, 1, 0, 3], ["revolute", "revolute", "prismatic", "revolute"]),
        ("floating", [0, 1, 0, 3, 4], ["revolute", "revolute", "prismatic", "fixed", "revolute"]),
        ("planar", [0, 1, 0], ["revolute", "revolute", "revolute"]),
    ]:
        bodies, model, tip, offset = make(root, parents, kinds)
        tool = pin.SE3(rotation(), rng.normal(size=3) * 0.2)
        model.addFrame(pin.Frame("tip", tip, offset * tool, pin.FrameType.OP_FRAME))
        size = model.nv + (1 if root == "floating" else 0)
        trees.append(dict(root=root, gravity=model.gravity.linear.tolist(), bodies=bodies,
                          tool=dict(rotation=tool.rotation.tolist(), translation=tool.translation.tolist()),
                          states=[state(root, model, size) for _ in range(5)]))
    print(json.dumps(dict(source=f"pinocchio {pin.__version__}", trees=trees)))


if __name__ == "__main__":
    main()
