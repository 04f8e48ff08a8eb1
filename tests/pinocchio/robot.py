"""One URDF robot in Pinocchio, with mimic joints reduced away.

Coordinates here are one number per independent joint: the angle of a revolute
or continuous joint, the displacement of a prismatic one; a floating joint has
seven (position, quaternion x y z w) and six velocities (linear, then angular, in
the moving frame). Pinocchio's algorithms run on the full model; a mimic joint
q_j = multiplier q_k + offset enters through the constant matrix G, v_full = G v.
"""

import xml.etree.ElementTree as xml

import numpy as np
import pinocchio as pin

MOVABLE = ("revolute", "continuous", "prismatic", "floating")


class Robot:
    """Model, coordinates and end links of one URDF file."""

    def __init__(self, path, mimic):
        """`mimic`: True ties mimic joints to their leader, False leaves them independent."""
        self.path = path
        self.tree = xml.parse(path).getroot()
        self.model = pin.buildModelFromUrdf(str(path), mimic=False)
        self.data = self.model.createData()
        self.file_joints = {j.get("name"): j for j in self.tree.findall("joint")}
        self.types = {name: j.get("type") for name, j in self.file_joints.items()}
        unsupported = {t for t in self.types.values() if t not in (*MOVABLE, "fixed")}
        if unsupported:
            raise ValueError(f"{path.name}: joint types {sorted(unsupported)} are not covered here")
        self.mimics = self._mimics() if mimic else {}
        order = list(self.model.names)[1:]
        self.joints = [name for name in order if name not in self.mimics]
        self._maps()
        self.links = self._end_links()

    def _mimics(self):
        found = {}
        for name, joint in self.file_joints.items():
            tag = joint.find("mimic")
            if tag is not None:
                found[name] = (tag.get("joint"), float(tag.get("multiplier", 1)),
                               float(tag.get("offset", 0)))
        leaders = {leader for leader, _, _ in found.values()}
        if leaders & found.keys():
            raise ValueError(f"{self.path.name}: a mimic joint follows a mimic joint")
        return found

    def _maps(self):
        """Column ranges of each independent joint in q and v, and G."""
        self.q_range, self.v_range, nq, nv = {}, {}, 0, 0
        for name in self.joints:
            joint = self.model.joints[self.model.getJointId(name)]
            size = 7 if joint.nv == 6 else 1
            self.q_range[name], self.v_range[name] = slice(nq, nq + size), slice(nv, nv + joint.nv)
            nq, nv = nq + size, nv + joint.nv
        self.nq, self.n = nq, nv
        self.G = np.zeros((self.model.nv, nv))
        for name in list(self.model.names)[1:]:
            joint = self.model.joints[self.model.getJointId(name)]
            leader, factor, _ = self.mimics.get(name, (name, 1.0, 0.0))
            rows = slice(joint.idx_v, joint.idx_v + joint.nv)
            self.G[rows, self.v_range[leader]] = factor * np.eye(joint.nv)

    def full_q(self, q):
        """Pinocchio's configuration vector (cosine and sine for continuous joints)."""
        full = pin.neutral(self.model)
        for name in list(self.model.names)[1:]:
            joint = self.model.joints[self.model.getJointId(name)]
            leader, factor, offset = self.mimics.get(name, (name, 1.0, 0.0))
            value = q[self.q_range[leader]]
            if joint.nq == 7:
                full[joint.idx_q:joint.idx_q + 7] = value
            elif joint.nq == 2:
                angle = factor * value[0] + offset
                full[joint.idx_q:joint.idx_q + 2] = np.cos(angle), np.sin(angle)
            else:
                full[joint.idx_q] = factor * value[0] + offset
        return full

    def integrate(self, q, step):
        """q moved by a tangent step (plain addition but for a floating joint)."""
        moved = q.copy()
        for name in self.joints:
            rows, columns = self.q_range[name], self.v_range[name]
            if rows.stop - rows.start == 7:
                se3 = pin.XYZQUATToSE3(q[rows]) * pin.exp6(step[columns])
                moved[rows] = pin.SE3ToXYZQUAT(se3)
            else:
                moved[rows] += step[columns]
        return moved

    def _end_links(self):
        """For each movable joint with no movable joint behind it, the last link in the
        file that is rigidly attached to it and carries no further link."""
        children = {}
        for name, joint in self.file_joints.items():
            children.setdefault(joint.find("parent").get("link"), []).append(name)
        child_of = {n: j.find("child").get("link") for n, j in self.file_joints.items()}
        position = {link.get("name"): i for i, link in enumerate(self.tree.findall("link"))}

        def behind(link):
            """(rigidly attached leaf links, whether a movable joint follows)"""
            leaves, movable = [], False
            for joint in children.get(link, []):
                if self.types[joint] in MOVABLE:
                    movable = True
                else:
                    more, further = behind(child_of[joint])
                    leaves, movable = leaves + more, movable or further
            return (leaves or [link]), movable

        ends = []
        for name in list(self.model.names)[1:]:
            leaves, movable = behind(child_of[name])
            if not movable:
                ends.append(max(leaves, key=position.get))
        return ends

    # --- quantities, all in the independent coordinates ---------------------

    def mass_matrix(self, q):
        M = pin.crba(self.model, self.data, self.full_q(q))
        M = np.triu(M) + np.triu(M, 1).T
        return self.G.T @ M @ self.G

    def inverse_dynamics(self, q, v, a):
        return self.G.T @ pin.rnea(self.model, self.data, self.full_q(q), self.G @ v, self.G @ a)

    def bias(self, q, v):
        return self.G.T @ pin.nonLinearEffects(self.model, self.data, self.full_q(q), self.G @ v)

    def forward_dynamics(self, q, v, tau):
        """Articulated-body algorithm; with tied joints, M and bias solved instead."""
        if self.mimics:
            return np.linalg.solve(self.mass_matrix(q), tau - self.bias(q, v))
        return pin.aba(self.model, self.data, self.full_q(q), v, tau)

    def inverse_derivatives(self, q, v, a):
        dq, dv, _ = pin.computeRNEADerivatives(self.model, self.data, self.full_q(q),
                                               self.G @ v, self.G @ a)
        return self.G.T @ dq @ self.G, self.G.T @ dv @ self.G

    def forward_derivatives(self, q, v, tau):
        """da/dq, da/dv, da/dtau."""
        if self.mimics:
            a = self.forward_dynamics(q, v, tau)
            inverse = np.linalg.inv(self.mass_matrix(q))
            dq, dv = self.inverse_derivatives(q, v, a)
            return -inverse @ dq, -inverse @ dv, inverse
        dq, dv, inverse = pin.computeABADerivatives(self.model, self.data, self.full_q(q), v, tau)
        return dq.copy(), dv.copy(), np.triu(inverse) + np.triu(inverse, 1).T

    def jacobian(self, q, link):
        """6 x n: velocity of the link frame's origin, then angular velocity, world axes."""
        full = pin.computeFrameJacobian(self.model, self.data, self.full_q(q),
                                        self.model.getFrameId(link),
                                        pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        return full @ self.G

    def jacobian_rate_v(self, q, v, link):
        """(dJ/dt) v: classical acceleration of the frame for a = 0."""
        pin.forwardKinematics(self.model, self.data, self.full_q(q), self.G @ v,
                              np.zeros(self.model.nv))
        frame = self.model.getFrameId(link)
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return pin.getFrameClassicalAcceleration(self.model, self.data, frame, aligned).vector
