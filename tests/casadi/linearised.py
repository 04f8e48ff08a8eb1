"""Linearisations on the constraint manifold, lifted to the whole state space.

With x = (q, v, z), F = df/dx, G = df/du and f = dx/dt, all by CasADi: W spans the tangent
space of the manifold, the null space of the Jacobian of (c, dc/dt) by (q, v); Z spans the
directions that coordinates are measured along, those across neither the rows of dc/dq
(positions) nor of A (velocities). P = W (Z' W)^-1 Z' projects onto the first, and

    PFP   P G   P f

do not depend on which bases were taken. Sampled: the exponential of [[PFP, PG, Pf], [0, 0, 0]].
"""

import casadi as ca
import numpy as np

import lagrange

CASES = 10
HOLD = 0.02
RANK = 1e-9


def null_space(matrix):
    """An orthonormal basis, one column each."""
    matrix = np.atleast_2d(matrix)
    if matrix.shape[0] == 0:
        return np.eye(matrix.shape[1])
    _, values, right = np.linalg.svd(matrix)
    rank = int(np.sum(values > RANK * values.max(initial=1)))
    return right[rank:].T


def exponential(matrix):
    """exp(matrix) by its series, scaled and squared."""
    halvings = max(0, int(np.ceil(np.log2(max(np.abs(matrix).sum(axis=1).max(), 1e-300)))) + 4)
    small = matrix / 2.0**halvings
    term = total = np.eye(len(matrix))
    for k in range(1, 25):
        term = term @ small / k
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def tangents(model):
    """CasADi function of (q, v, t, p): Jacobians of holonomic c, of all c and rates by q and v."""
    q, qd = lagrange._symbols("q", model.coordinates)
    v, vd = lagrange._symbols("v", model.coordinates)
    p, pd = lagrange._symbols("p", list(model.parameters))
    t = ca.SX.sym("t")
    held = ca.vertcat(ca.SX(0, 1), *model.holonomic(qd, t, pd).values())
    rate = ca.mtimes(ca.jacobian(held, q), v) + ca.jacobian(held, t)
    moving = ca.vertcat(rate, *model.nonholonomic(qd, vd, t, pd).values())
    jacobians = [ca.jacobian(held, q), ca.jacobian(moving, q), ca.jacobian(moving, v)]
    return ca.Function("tangents", [q, v, t, p], [ca.densify(j) for j in jacobians])


def memory(model):
    """CasADi function of (z, late, p): internal rates and their Jacobians."""
    z, zd = lagrange._symbols("z", model.states)
    late, late_d = lagrange._symbols("late", model.late)
    p, pd = lagrange._symbols("p", list(model.parameters))
    rates = model.rates(zd, late_d, pd)
    rates = ca.vertcat(ca.SX(0, 1), *[rates[name] for name in model.states])
    found = [rates, ca.jacobian(rates, z), ca.jacobian(rates, late)]
    return ca.Function("memory", [z, late, p], [ca.densify(f) for f in found])


def lifted(model, out, state, tangent, remembered):
    """P, PFP, PG, Pf, and what one hold makes of them, at one state."""
    n, s = len(model.coordinates), len(model.states)
    k, d = len(model.inputs), len(model.late)
    z, late = state.get("z", np.zeros(0)), state.get("late", np.zeros(0))
    held, moving_q, moving_v = (np.array(j) for j in tangent(state["q"], state["v"], state["t"], state["p"]))
    z_dot, z_by_z, z_by_late = (np.array(j) for j in remembered(z, late, state["p"]))
    m = len(moving_v)
    constraint = np.block([[held, np.zeros((len(held), n))], [moving_q, moving_v]])
    directions = np.block([[held, np.zeros((len(held), n))], [np.zeros((m, n)), moving_v]])
    pad = lambda basis: np.block([[basis, np.zeros((2 * n, s))], [np.zeros((s, basis.shape[1])), np.eye(s)]])
    W, Z = pad(null_space(constraint)), pad(null_space(directions))
    P = W @ np.linalg.solve(Z.T @ W, Z.T)
    F, G = np.zeros((2 * n + s, 2 * n + s)), np.zeros((2 * n + s, k + d))
    F[:n, n:2 * n] = np.eye(n)
    F[n:2 * n, :n], F[n:2 * n, n:2 * n] = out["da_dq"], out["da_dv"]
    G[n:2 * n, :k] = out["da_du"]
    if s:
        F[n:2 * n, 2 * n:], F[2 * n:, 2 * n:] = out["da_dz"], z_by_z
        G[2 * n:, k:] = z_by_late
    f = np.concatenate([state["v"], out["a"][:, 0], z_dot[:, 0]])
    A, B, drift = P @ F @ P, P @ G, P @ f
    size = len(F)
    augmented = np.zeros((size + k + d + 1,) * 2)
    augmented[:size] = np.column_stack([A, B, drift])
    moved = exponential(augmented * HOLD)
    return {"free": int(W.shape[1]), "P": P, "PFP": A, "PG": B, "Pf": drift,
            "sampled_A": moved[:size, :size] @ P, "sampled_B": moved[:size, size:-1],
            "sampled_f": moved[:size, -1]}


def document(model, draw, project, evaluate, condition, limits, seed):
    """Ten states of one model; of a constrained one, on the constraint."""
    function, constraints = lagrange.derive(model)
    tangent, remembered = tangents(model), memory(model)
    rng = np.random.default_rng(seed)
    listed = []
    while len(listed) < CASES:
        state = draw(model, rng)
        if constraints and not project(function, state):
            continue
        out = evaluate(function, state)
        feedback = abs(out.pop("feedback", np.zeros(1))).max()
        if condition(out) > limits[0] or feedback > limits[1]:
            continue
        entry = {k: state[k].tolist() for k in ("q", "v", "u", "z", "late") if k in state}
        entry["t"] = float(state["t"])
        entry["parameters"] = dict(zip(model.parameters, state["p"].tolist()))
        found = lifted(model, out, state, tangent, remembered)
        entry.update({k: x if isinstance(x, int) else (x + 0.0).tolist() for k, x in found.items()})
        listed.append(entry)
    return {"model": model.name, "casadi_version": ca.__version__, "hold": HOLD,
            "coordinates": list(model.coordinates), "inputs": list(model.inputs),
            "parameters": list(model.parameters), "cases": listed}
