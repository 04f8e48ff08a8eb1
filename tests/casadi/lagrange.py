"""Equations of motion from energies and constraints, by CasADi differentiation.

M = d2T/dv2,  Q_C = dL/dq - (d2L/dv dq) v - d2L/dv dt  with L = T - V,
Q = Q_C + Q_D + B u,  A a = b from the constraints differentiated once
(nonholonomic) or twice (holonomic), and [M A^T; A 0][a; -lambda] = [Q; b].
Friction of a contact adds F |lambda| to Q.
"""

import casadi as ca

OUTPUTS = ("M", "bias", "Q", "B", "A", "b", "c", "c_dot", "a", "lambda")
SEEDS = ("q", "v", "u", "t", "p")
# what is differentiated by what, besides a and lambda by all seeds
SLOPES = (("M", "q"), ("bias", "q"), ("bias", "v"), ("A", "q"), ("b", "q"), ("b", "v"))


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


def _rub(M, Q, A, b, friction):
    """As `_solve` with one row, where Q + friction |lambda| stands in place of Q.

    G lambda + g |lambda| = r has the sign of r as long as G is larger than g.
    """
    inverse_at = ca.solve(M, A.T)
    rest = b - ca.mtimes(A, ca.solve(M, Q))
    sign = ca.sign(rest)
    stiffness, coupling = ca.mtimes(A, inverse_at), ca.mtimes(A, ca.solve(M, friction))
    multipliers = rest / (stiffness + sign * coupling)
    force = Q + friction * sign * multipliers
    return ca.solve(M, force) + ca.mtimes(inverse_at, multipliers), multipliers, force, coupling / stiffness


def derive(model):
    """Returns (function, names of constraints).

    The CasADi function maps (q, v, u, t, p) to the quantities of `OUTPUTS`, the
    derivatives da_ds, dlambda_ds for s in `SEEDS` and those of `SLOPES` (a matrix row by
    row), in that order. With internal states z it also takes z and what arrives late, and
    gives z_dot and derivatives by z; with friction also what share of a change of the
    multiplier comes back through it (`feedback`).
    """
    q, qd = _symbols("q", model.coordinates)
    v, vd = _symbols("v", model.coordinates)
    u, ud = _symbols("u", model.inputs)
    p, pd = _symbols("p", list(model.parameters))
    t = ca.SX.sym("t")
    z, zd = _symbols("z", model.states)
    late, late_d = _symbols("late", model.late)

    kinetic, potential = (ca.SX(e) for e in model.energies(qd, vd, pd))
    lagrangian = kinetic - potential
    momentum = ca.gradient(lagrangian, v)
    M = ca.jacobian(momentum, v)
    bias = (ca.gradient(lagrangian, q) - ca.mtimes(ca.jacobian(momentum, q), v)
            - ca.jacobian(momentum, t))
    dissipative = -ca.gradient(ca.SX(model.rayleigh(qd, vd, pd)), v)
    driven = ca.gradient(ca.SX(model.power(qd, vd, ud)), v)
    B = ca.jacobian(driven, u)
    stored = ca.gradient(ca.SX(model.stored_power(vd, zd)), v)
    Q = bias + dissipative + ca.mtimes(B, u) + stored

    names, A, b, c, c_dot = _constraints(model, q, v, t, qd, vd, pd)
    feedback = None
    if model.rubbing:
        friction = model.rubbing(qd, vd, pd)
        friction = ca.vertcat(*[friction[name] for name in model.coordinates])
        a, multipliers, Q, feedback = _rub(M, Q, A, b, friction)
    else:
        a, multipliers = _solve(M, Q, A, b)

    found = dict(zip(OUTPUTS, (M, bias, Q, B, A, b, c, c_dot, a, multipliers)))
    seeds = dict(zip(SEEDS, (q, v, u, t, p)))
    if model.states:
        seeds["z"] = z
    rows = {name: ca.vec(quantity.T) for name, quantity in found.items()}
    for name, label in (("a", "da"), ("lambda", "dlambda")):
        for seed, symbols in seeds.items():
            found[f"{label}_d{seed}"] = ca.jacobian(rows[name], symbols)
    for name, seed in SLOPES:
        found[f"d{name}_d{seed}"] = ca.jacobian(rows[name], seeds[seed])
    arguments = {"q": q, "v": v, "u": u, "t": t, "p": p}
    if model.states:
        arguments.update(z=z, late=late)
        rates = model.rates(zd, late_d, pd)
        found["z_dot"] = ca.vertcat(*[rates[name] for name in model.states])
    if feedback is not None:
        found["feedback"] = feedback
    function = ca.Function(model.name, list(arguments.values()), [ca.densify(o) for o in found.values()],
                           list(arguments), list(found))
    return function, names
