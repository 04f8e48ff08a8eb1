"""Second routes for the figures of `derive.py`, so that no number stands on one call alone."""

import numpy as np
import pinocchio as pin

STEP = 1e-6


def _difference_quotient(function, n):
    """Central differences of function(i, step) over the n tangent directions, as columns."""
    return np.array([(function(i, STEP) - function(i, -STEP)) / (2 * STEP) for i in range(n)]).T


def _routes(robot, s):
    """Yields (name, stored, second route, relative tolerance)."""
    q, v, n = s["q"], s["v"], robot.n
    zero, unit = np.zeros(n), np.eye(n)
    rest = robot.inverse_dynamics(q, zero, zero)
    columns = [robot.inverse_dynamics(q, zero, e) - rest for e in unit]
    yield "M", s["M"], np.array(columns).T, 1e-11
    yield "bias", s["bias"], robot.inverse_dynamics(q, v, zero), 1e-11
    yield "tau_id", s["tau_id"], s["M"] @ s["a_in"] + s["bias"], 1e-10
    yield "a", s["a"], np.linalg.solve(s["M"], s["tau"] - s["bias"]), 1e-9
    yield "da_dtau", s["da_dtau"] @ s["M"], unit, 1e-9

    def inverse_q(i, h):
        return robot.inverse_dynamics(robot.integrate(q, h * unit[i]), v, s["a_in"])

    def forward_q(i, h):
        return robot.forward_dynamics(robot.integrate(q, h * unit[i]), v, s["tau"])

    yield "dtau_dq", s["dtau_dq"], _difference_quotient(inverse_q, n), 1e-6
    yield "dtau_dv", s["dtau_dv"], _difference_quotient(
        lambda i, h: robot.inverse_dynamics(q, v + h * unit[i], s["a_in"]), n), 1e-6
    yield "da_dq", s["da_dq"], _difference_quotient(forward_q, n), 1e-6
    yield "da_dv", s["da_dv"], _difference_quotient(
        lambda i, h: robot.forward_dynamics(q, v + h * unit[i], s["tau"]), n), 1e-6
    for link, J, rate in zip(robot.links, s["J"], s["Jdot_v"]):
        pin.forwardKinematics(robot.model, robot.data, robot.full_q(q), robot.G @ v)
        velocity = pin.getFrameVelocity(robot.model, robot.data, robot.model.getFrameId(link),
                                        pin.ReferenceFrame.LOCAL_WORLD_ALIGNED).vector
        yield f"J {link}", J @ v, velocity, 1e-11
        ahead = robot.jacobian(robot.integrate(q, STEP * v), link)
        behind = robot.jacobian(robot.integrate(q, -STEP * v), link)
        yield f"Jdot_v {link}", rate, (ahead - behind) @ v / (2 * STEP), 1e-6
    if robot.mimics:
        tied = pin.buildModelFromUrdf(str(robot.path), mimic=True)
        data = tied.createData()
        full = _tied_configuration(robot, tied, q)
        M = pin.crba(tied, data, full)
        yield "M of Pinocchio's own mimic joints", s["M"], np.triu(M) + np.triu(M, 1).T, 1e-11
        yield "bias of Pinocchio's own mimic joints", s["bias"], pin.nonLinearEffects(
            tied, data, full, v), 1e-11


def _tied_configuration(robot, tied, q):
    full = pin.neutral(tied)
    for name in robot.joints:
        joint = tied.joints[tied.getJointId(name)]
        value = q[robot.q_range[name]]
        if joint.nq == 2:
            value = np.array([np.cos(value[0]), np.sin(value[0])])
        full[joint.idx_q:joint.idx_q + joint.nq] = value
    return full


def failures(robot, s):
    """Descriptions of the routes that disagree."""
    found = []
    for name, stored, second, tolerance in _routes(robot, s):
        error = np.abs(stored - second).max(initial=0)
        size = max(np.abs(second).max(initial=0), np.abs(stored).max(initial=0), 1e-2)
        if not error <= tolerance * size:
            found.append(f"{name}: {error:.3g} from the second route (size {size:.3g})")
    return found
