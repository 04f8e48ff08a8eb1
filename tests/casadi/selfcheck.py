"""A second route: the closed-form equations of the logs' READMEs, in numpy.

Shares nothing with `lagrange.py`: M, Q, A, b are typed from the formulas, the
saddle-point system is solved as a whole, and derivatives come from the complex
step, which has no truncation error. Used by derive.py; also runs alone on the
stored files:  python selfcheck.py
"""

import json
import sys
from pathlib import Path

import numpy as np
from numpy import array, cos, exp, sin

TOLERANCE = 1e-11
STEP = 1e-40


def surface_particle(q, v, u, t, p):
    x, y, _ = q
    dx, dy, _ = v
    M = p["m"] * np.eye(3)
    Q = array([u[0], u[1], u[2] - p["m"] * p["g"]])
    A = array([[2 * p["p1"] * x + p["p3"] - p["p4"] * p["p5"] * sin(p["p5"] * x),
                2 * p["p2"] * y, -1]])
    b = array([-2 * p["p1"] * dx**2 - 2 * p["p2"] * dy**2
               + p["p4"] * p["p5"]**2 * dx**2 * cos(p["p5"] * x)])
    return M, Q, A, b


def unicycle2d(q, v, u, t, p):
    s, c = sin(q[2]), cos(q[2])
    dx, dy, w = v
    mr = p["m"] * p["R"]
    ic = p["I_G"] + p["m"] * p["R"]**2
    M = array([[p["m"], 0, -mr * s], [0, p["m"], mr * c], [-mr * s, mr * c, ic]])
    Q = array([mr * w**2 * c + c * u[0], mr * w**2 * s + s * u[0], u[1]])
    return M, Q, array([[s, -c, 0]]), array([-w * (dx * c + dy * s)])


def duffing_free(q, v, u, t, p):
    x1, x2 = q
    K = array([[p["k1"], -p["k1"]], [-p["k1"], p["k1"] + p["k2"]]])
    C = array([[p["c1"], -p["c1"]], [-p["c1"], p["c1"] + p["c2"]]])
    cubic = array([p["k1nl"] * (x1 - x2)**3, p["k2nl"] * x2**3 - p["k1nl"] * (x1 - x2)**3])
    M = array([[p["m1"], 0], [0, p["m2"]]])
    return M, -K @ q - C @ v - cubic + u, np.zeros((0, 2)), np.zeros(0)


def duffing_constrained(q, v, u, t, p):
    M, Q, _, _ = duffing_free(q, v, u, t, p)
    p1, p2, p3 = p["p1"], p["p2"], p["p3"]
    b = -p1 * exp(-p2 * t) * ((p3**2 - p2**2) * sin(p3 * t) + 2 * p2 * p3 * cos(p3 * t))
    return M, Q, array([[-1, 1]]), array([b])


def pendulum(q, v, u, t, p):
    M = array([[p["I"] + p["m"] * p["l"]**2]])
    return M, u - p["m"] * p["g"] * p["l"] * sin(q), np.zeros((0, 1)), np.zeros(0)


def pendulum2(q, v, u, t, p):
    m1, l1, lc1, m2, lc2, g = (p[k] for k in ("m1", "l1", "lc1", "m2", "lc2", "g"))
    m11 = p["I1"] + p["I2"] + m1 * lc1**2 + m2 * (l1**2 + lc2**2 + 2 * l1 * lc2 * cos(q[1]))
    m12 = p["I2"] + m2 * (lc2**2 + l1 * lc2 * cos(q[1]))
    s = m2 * l1 * lc2 * sin(q[1])
    tip = m2 * lc2 * g * sin(q[0] + q[1])
    Q = array([u[0] + s * (2 * v[0] * v[1] + v[1]**2) - (m1 * lc1 + m2 * l1) * g * sin(q[0]) - tip,
               u[1] - s * v[0]**2 - tip])
    M = array([[m11, m12], [m12, p["I2"] + m2 * lc2**2]])
    return M, Q, np.zeros((0, 2)), np.zeros(0)


def cartpole(q, v, u, t, p):
    ml = p["mp"] * p["l"]
    M = array([[p["mc"] + p["mp"], ml * cos(q[1])], [ml * cos(q[1]), p["I"] + ml * p["l"]]])
    Q = array([u[0] + ml * sin(q[1]) * v[1]**2, -ml * p["g"] * sin(q[1])])
    return M, Q, np.zeros((0, 2)), np.zeros(0)


def fourbar(q, v, u, t, p):
    """Newton-Euler with the Jacobians of the three centres of gravity."""
    phi, w = np.cumsum(q), np.cumsum(v)
    e, normal = array([cos(phi), sin(phi)]), array([-sin(phi), cos(phi)])
    length = array([p["L1"], p["L2"], p["L3"]])
    M, Q = np.zeros((3, 3), dtype=phi.dtype), array([u[0], 0, 0], dtype=phi.dtype)
    for i in range(3):
        arm = array([length[j] if j < i else (p[f"lc{i + 1}"] if j == i else 0) for j in range(3)])
        # d p_i / d phi_j = arm_j normal_j ; phi_j depends on q_k for k <= j
        J = array([(normal[:, k:] * arm[k:]).sum(axis=1) for k in range(3)]).T
        turn = array([1.0 if k <= i else 0.0 for k in range(3)])
        drift = -(e * arm * w**2).sum(axis=1)
        mass = p[f"m{i + 1}"]
        M = M + mass * J.T @ J + p[f"I{i + 1}"] * np.outer(turn, turn)
        Q = Q - mass * J.T @ (drift + array([0, p["g"]]))
    A = array([(normal[:, k:] * length[k:]).sum(axis=1) for k in range(3)]).T
    return M, Q, A, (e * length * w**2).sum(axis=1)


def _delta_arm(angle, q, w, p):
    """Jacobians of elbow and wrist by an arm's angles, and the accelerations that are left at rest."""
    out = array([cos(angle), sin(angle), 0])
    across = array([-sin(angle), cos(angle), 0])
    up = array([0, 0, 1])
    radial = [cos(x) * out - sin(x) * up for x in (q[0], q[0] + q[1])]
    normal = [-sin(x) * out - cos(x) * up for x in (q[0], q[0] + q[1])]
    turn, s, r = w[0] + w[1], q[2], w[2]
    elbow = array([p["l1"] * normal[0], 0 * up, 0 * up]).T
    bend = p["l2"] * cos(s) * normal[1]
    sway = p["l2"] * (-sin(s) * radial[1] + cos(s) * across)
    elbow_drift = -p["l1"] * radial[0] * w[0]**2
    drift = -p["l2"] * ((turn**2 + r**2) * cos(s) * radial[1] + 2 * turn * r * sin(s) * normal[1]
                        + r**2 * sin(s) * across)
    return elbow, elbow + array([bend, bend, sway]).T, elbow_drift, elbow_drift + drift


def delta(q, v, u, t, p):
    """Simpson's rule makes a rod of three points of mass, exactly."""
    M, Q = np.zeros((12, 12), dtype=q.dtype), np.zeros(12, dtype=q.dtype)
    A, b = np.zeros((9, 12), dtype=q.dtype), np.zeros(9, dtype=q.dtype)
    weight = array([0, 0, 9.81])
    M[:3, :3], Q[:3] = 0.3 * np.eye(3), -0.3 * weight
    for i in range(3):
        own = slice(3 + 3 * i, 6 + 3 * i)
        elbow, wrist, drift, wrist_drift = _delta_arm(2 * np.pi * i / 3, q[own], v[own], p)
        for mass, points in ((p["m1"], ((1 / 6, 1, 0), (4 / 6, 1 / 2, 0))),
                             (p["m2"], ((1 / 6, 1, 0), (4 / 6, 1 / 2, 1 / 2), (1 / 6, 0, 1)))):
            for share, first, second in points:
                J = first * elbow + second * wrist
                M[own, own] += mass * share * J.T @ J
                Q[own] -= mass * share * J.T @ (first * drift + second * wrist_drift + weight)
        Q[own.start] += u[i]
        A[3 * i:3 * i + 3, own], A[3 * i:3 * i + 3, :3] = wrist, -np.eye(3)
        b[3 * i:3 * i + 3] = -wrist_drift
    return M, Q, A, b


def bead(q, v, u, t, p):
    """Its drive pushes with what is stored, which comes as a parameter here."""
    Q = array([p["delivered"], -p["m"] * p["g"]])
    return p["m"] * np.eye(2), Q, array([[-1.6 * q[0], 1]]), array([1.6 * v[0]**2])


def bead_friction(q, v, p):
    """Coulomb's law on a parabola: mu |lambda| sqrt(1 + (1.6 x)^2), against the velocity."""
    speed = np.sqrt(v @ v)
    return -p["mu"] * np.sqrt(1 + 2.56 * q[0]**2) * np.tanh(speed / p["v_s"]) / speed * v


FRICTION = {"bead": bead_friction}
FORMULAS = {f.__name__: f for f in (surface_particle, unicycle2d, duffing_free, duffing_constrained,
                                    pendulum, pendulum2, cartpole, fourbar, delta, bead)}


def _solved(name, q, v, u, t, p):
    """(a, lambda, Q); where friction acts, by trying both signs of the multiplier."""
    M, Q, A, b = FORMULAS[name](q, v, u, t, p)
    m, n = A.shape
    friction = FRICTION[name](q, v, p)[:, None] if name in FRICTION else np.zeros((n, m))
    for sign in (1, -1):
        K = np.block([[M, A.T + sign * friction], [A, np.zeros((m, m))]])
        solution = np.linalg.solve(K, np.concatenate([Q, b]))
        a, multipliers = solution[:n], -solution[n:]
        if name not in FRICTION or sign * multipliers[0].real > 0:
            return a, multipliers, Q + sign * friction @ multipliers
    raise ValueError(f"{name}: no sign of the multiplier fits")


def _derivatives(name, q, v, u, t, p):
    """da/ds and dlambda/ds by the complex step for s = q, v, u, t, p (then z), and those of the terms."""
    values = list(p.values())
    point = np.concatenate([q, v, u, [t], values])
    stored = [k for k in p if k == "delivered"]
    cuts = np.cumsum([len(q), len(v), len(u), 1, len(p) - len(stored)])
    columns = []
    for i in range(len(point)):
        shifted = point.astype(complex)
        shifted[i] += 1j * STEP
        qs, vs, us, ts, ps, zs = np.split(shifted, cuts)
        given = dict(zip(p, np.concatenate([ps, zs])))
        a, multipliers, _ = _solved(name, qs, vs, us, ts[0], given)
        M, _, A, b = FORMULAS[name](qs, vs, us, ts[0], given)
        parts = (a, multipliers, M, A, b)
        columns.append(np.concatenate([np.ravel(part).imag for part in parts]) / STEP)
    whole = np.array(columns).T
    ends = np.cumsum([a.size, multipliers.size, M.size, A.size])
    found = {}
    for seed, block in zip("qvutpz", np.split(whole, cuts, axis=1)):
        if seed == "z" and not stored:
            continue
        block = block[:, 0] if seed == "t" else block
        parts = dict(zip(("a", "lambda", "M", "A", "b"), np.split(block, ends)))
        found[f"da_d{seed}"], found[f"dlambda_d{seed}"] = parts["a"], parts["lambda"]
        slopes = {"q": ("M", "A", "b"), "v": ("b",)}
        found.update({f"d{k}_d{seed}": parts[k] for k in slopes.get(seed, ())})
    return found


def compare(document):
    """List of disagreements between a document of derive.py and the formulas."""
    name, wrong = document["model"], []
    for number, case in enumerate(document["cases"]):
        q, v, u = (np.array(case[k]) for k in "qvu")
        t, p = case["t"], dict(case["parameters"])
        p.update(zip(("delivered",), case.get("z", ())))
        M, _, A, b = FORMULAS[name](q, v, u, t, p)
        a, multipliers, Q = _solved(name, q, v, u, t, p)
        route = {"M": M, "Q": Q, "A": A, "b": b, "a": a, "lambda": multipliers,
                 **_derivatives(name, q, v, u, t, p)}
        for key, value in route.items():
            value = np.asarray(value, dtype=float)
            stored = np.array(case[key], dtype=float).reshape(value.shape)
            size = max(np.abs(value).max(initial=0), 1.0)
            error = np.abs(value - stored).max(initial=0)
            if not error <= TOLERANCE * size:
                wrong.append(f"{name} case {number}: {key} {error:.3g} from the formulas (size {size:.3g})")
    return wrong


def main():
    wrong = []
    for name in FORMULAS:
        path = Path(__file__).resolve().parent / "expected" / f"{name}.json"
        wrong += compare(json.loads(path.read_text()))
    print("\n".join(wrong) or f"{len(FORMULAS)} models agree with the printed formulas to {TOLERANCE:g}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
