"""Equations of motion from energies and constraints, by CasADi differentiation.

M = d2T/dv2,  Q_C = dL/dq - (d2L/dv dq) v - d2L/dv dt  with L = T - V,
Q = Q_C + Q_D + B u,  A a = b from the constraints differentiated once
(nonholonomic) or twice (holonomic), and [M A^T; A 0][a; -lambda] = [Q; b].
"""

import casadi as ca

OUTPUTS = ("M", "bias", "Q", "B", "A", "b", "c", "c_dot", "a", "lambda")
SEEDS = ("q", "v", "u", "t", "p")


def _symbols(prefix, names):
    column = ca.SX.sym(prefix, len(names))
    return column, {name: column[i] for i, name in enumerate(names)}


def _constraints(model, q, v, t, qd, vd, pd):
    """Rows A, b, c, c_dot; c_dot of a nonholonomic row is not a number (no a in it)."""
    n = q.numel()
    a_rows, b_rows, c_rows, rate_rows = [ca.SX(0, n)], [ca.SX(0, 1)], [ca.SX(0, 1)], [ca.SX(0, 1)]
    holonomic = model.holonomic(qd, t, pd)
    nonholonomic = model.nonholonomic(qd, vd, t, pd)
    for c in holonomic.values():
        rate = ca.mtimes(ca.jacobian(c, q), v) + ca.jacobian(c, t)
        # c_ddot = A a + (terms without a); b is minus the terms without a
        rest = ca.mtimes(ca.jacobian(rate, q), v) + ca.jacobian(rate, t)
        a_rows.append(ca.jacobian(rate, v))
        b_rows.append(-rest)
        c_rows.append(c)
        rate_rows.append(rate)
    for c in nonholonomic.values():
        a_rows.append(ca.jacobian(c, v))
        b_rows.append(-ca.mtimes(ca.jacobian(c, q), v) - ca.jacobian(c, t))
        c_rows.append(c)
        rate_rows.append(ca.SX.nan(1, 1))
    names = [*holonomic, *nonholonomic]
    return names, *(ca.vertcat(*r) for r in (a_rows, b_rows, c_rows, rate_rows))


def _solve(M, Q, A, b):
    """Solution of the saddle-point system, eliminated by the Schur complement."""
    m = A.size1()
    free = ca.solve(M, Q)
    if m == 0:
        return free, ca.SX(0, 1)
    inverse_at = ca.solve(M, A.T)
    multipliers = ca.solve(ca.mtimes(A, inverse_at), b - ca.mtimes(A, free))
    return free + ca.mtimes(inverse_at, multipliers), multipliers


def derive(model):
    """Returns (function, names of constraints).

    The CasADi function maps (q, v, u, t, p) to the quantities of `OUTPUTS`
    and the derivatives da_ds, dlambda_ds for s in `SEEDS`, in that order.
    """
    q, qd = _symbols("q", model.coordinates)
    v, vd = _symbols("v", model.coordinates)
    u, ud = _symbols("u", model.inputs)
    p, pd = _symbols("p", list(model.parameters))
    t = ca.SX.sym("t")

    kinetic, potential = (ca.SX(e) for e in model.energies(qd, vd, pd))
    lagrangian = kinetic - potential
    momentum = ca.gradient(lagrangian, v)
    M = ca.jacobian(momentum, v)
    bias = (ca.gradient(lagrangian, q) - ca.mtimes(ca.jacobian(momentum, q), v)
            - ca.jacobian(momentum, t))
    dissipative = -ca.gradient(ca.SX(model.rayleigh(qd, vd, pd)), v)
    driven = ca.gradient(ca.SX(model.power(qd, vd, ud)), v)
    B = ca.jacobian(driven, u)
    Q = bias + dissipative + ca.mtimes(B, u)

    names, A, b, c, c_dot = _constraints(model, q, v, t, qd, vd, pd)
    a, multipliers = _solve(M, Q, A, b)

    outputs = [M, bias, Q, B, A, b, c, c_dot, a, multipliers]
    labels = list(OUTPUTS)
    for label, quantity in (("da", a), ("dlambda", multipliers)):
        for seed_label, seed in zip(SEEDS, (q, v, u, t, p)):
            outputs.append(ca.jacobian(quantity, seed))
            labels.append(f"{label}_d{seed_label}")
    function = ca.Function(model.name, [q, v, u, t, p], [ca.densify(o) for o in outputs],
                           list(SEEDS), labels)
    return function, names
