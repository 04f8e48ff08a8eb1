"""The machines with their effects once more, from CasADi's M, Q, A, b and numpy formulas.

Nothing of plant.py or rollout.py is used: inertia effects enter as energies, forces are
typed from the formulas in truth.json, acting inputs come from interpolation and fine
integration of the logged command.
"""

import dataclasses

import casadi as ca
import numpy as np

import lagrange
import models

INTEGRATED = ("bouc_wen", "dahl", "lugre", "input_lag")
FINE = 40
"""Substeps per sample where a hidden state is integrated again."""


def arm_model(n, parameters):
    """A planar chain of n links hanging down, as energies."""
    names = tuple(f"j{i + 1}" for i in range(n))

    def energies(q, v, p):
        kinetic = potential = angle = 0
        joint = ca.vertcat(0, 0)
        for i, name in enumerate(names, start=1):
            angle = angle + q[name]
            direction = ca.vertcat(ca.sin(angle), -ca.cos(angle))
            centre = joint + p[f"lc{i}"] * direction
            turn = models._rate(angle, q, v)
            kinetic += (p[f"m{i}"] * models._squared(models._rate(centre, q, v)) + p[f"I{i}"] * turn**2) / 2
            potential += p[f"m{i}"] * p["g"] * centre[1]
            joint = joint + p[f"l{i}"] * direction
        return kinetic, potential

    return models.Model(f"arm{n}", names, names, parameters, energies, models._along)


def casadi_model(system, parameters):
    """The CasADi statement of a simulated system."""
    if system.name == "planar_arm":
        return arm_model(system.links, parameters)
    name = system.name
    if name == "duffing":
        name += "_constrained" if system.constraints else "_free"
    return next(m for m in models.MODELS if m.name == name)


def energy(name, system, parameters):
    """Function (q, v) -> T + V."""
    model = casadi_model(system, parameters)
    q, v = ca.SX.sym("q", len(model.coordinates)), ca.SX.sym("v", len(model.coordinates))
    split = [{k: x[i] for i, k in enumerate(model.coordinates)} for x in (q, v)]
    total = ca.Function("energy", [q, v], [ca.SX(sum(model.energies(*split, parameters)))])
    return lambda a, b: float(total(a, b))


def _with_energy(model, system, effect):
    """The model with what an effect adds to its kinetic and potential energy."""
    x, plain = effect.parameters(), model.energies

    def energies(q, v, p):
        kinetic, potential = plain(q, v, p)
        if effect.kind.name == "armature":
            return kinetic + x["Ia"] / 2 * v[effect.on[0]]**2, potential
        if effect.kind.name == "joint_coupling":
            return kinetic + x["I"] / 2 * sum(v[name] for name in effect.on)**2, potential
        if effect.kind.name == "gravity_tilt":
            return kinetic, _tilted(system, plain, q, v, p, x["delta"])
        link = effect.where + 1
        if effect.kind.name == "com_offset":
            mass, was = p[f"m{link}"], p[f"lc{link}"]
            points = [(-mass, _on_link(system, link, q, p, was)),
                      (mass, _on_link(system, link, q, p, was + x["x"], x["y"]))]
        else:
            points = [(x["m_add"], _payload_place(system, effect, q, p, x))]
        for mass, place in points:
            kinetic = kinetic + mass / 2 * models._squared(models._rate(place, q, v))
            height = 0 if system.name == "unicycle2d" else place[1]
            potential = potential + mass * p.get("g", 0) * height
        return kinetic, potential

    return dataclasses.replace(model, energies=energies)


def _tilted(system, energies, q, v, p, delta):
    """Potential energy where gravity is turned: what hangs is turned back by as much."""
    first = "theta" if system.name == "cartpole" else system.coords[0]
    potential = ca.substitute(ca.SX(energies(q, v, p)[1]), q[first], q[first] - delta)
    if system.name == "cartpole":
        potential -= (p["mc"] + p["mp"]) * p["g"] * q["x"] * np.sin(delta)
    return potential


def _payload_place(system, effect, q, p, x):
    if system.name == "unicycle2d":
        c, s = ca.cos(q["theta"]), ca.sin(q["theta"])
        return ca.vertcat(q["x"] + c * x["x_add"] - s * x["y_add"], q["y"] + s * x["x_add"] + c * x["y_add"])
    if system.name == "cartpole":
        return ca.vertcat(q["x"] + x["L_add"] * ca.sin(q["theta"]), -x["L_add"] * ca.cos(q["theta"]))
    return _on_link(system, effect.where + 1, q, p, x["L_add"])


def _on_link(system, link, q, p, along, across=0.0):
    """Where a point of a chain's link is, along it and counter-clockwise across it."""
    place, angle = ca.vertcat(0, 0), 0
    for i in range(1, link + 1):
        angle = angle + q[f"j{i}"]
        out = ca.vertcat(ca.cos(angle), ca.sin(angle)) if system.name == "fourbar" \
            else ca.vertcat(ca.sin(angle), -ca.cos(angle))
        length = along if i == link else p.get(f"l{i}", p.get(f"L{i}"))
        place = place + length * out
    return place + across * ca.vertcat(-out[1], out[0])


def _force(name, x, q, v, load, z):
    """Force of one effect on its coordinate along a log."""
    if name in ("coulomb", "load_friction"):
        size = x["Fc"] if name == "coulomb" else x["mu"] * np.abs(load)
        return -size * np.tanh(v / x["vs"])
    if name == "asymmetric_coulomb":
        sign = np.tanh(v / x["vs"])
        return -sign * (x["Fp"] * (1 + sign) + x["Fm"] * (1 - sign)) / 2
    if name == "stribeck":
        level = x["Fc"] + (x["Fs"] - x["Fc"]) * np.exp(-(v / x["vst"])**2)
        return -level * np.tanh(v / x["vs"]) - x["d"] * v
    return {
        "viscous": lambda: -x["d"] * v,
        "quadratic_drag": lambda: -x["c"] * np.abs(v) * v,
        "constant_force": lambda: x["f"] + 0 * v,
        "spring": lambda: -x["k"] * (q - x["q0"]),
        "cubic_spring": lambda: -x["k3"] * (q - x["q0"])**3,
        "cogging": lambda: -x["amp"] * np.sin(x["n"] * q + x["phase"]),
        "position_viscous": lambda: -x["d"] * (1 + np.sin(x["n"] * q + x["phase"])) * v,
        "lugre": lambda: -x["Fc"] * z - x["d"] * v,
        "bouc_wen": lambda: -x["k"] * z,
        "dahl": lambda: -z,
    }[name]()


def _hidden(name, x, v, a, step, hold_linear):
    """Hidden state of a hysteresis, integrated finely along the logged velocity.

    Between samples: the cubic through both values and slopes; under a held input the
    acceleration jumps at the next sample, so the parabola through v_k, a_k, v_k+1.
    """
    def rate(z, w):
        if name == "dahl":
            return x["sigma"] * (w - abs(w) * z / x["Fc"])
        if name == "lugre":
            return (w - abs(w) * z / (1 + x["rise"] * np.exp(-(w / x["vst"])**2))) / x["reach"]
        return x["A"] * w - x["beta"] * abs(w) * z - x["gamma"] * w * abs(z)

    z, found, h = 0.0, np.zeros(len(v)), step / FINE
    s = np.arange(0, FINE + 0.5, 0.5) / FINE
    for k in range(len(v) - 1):
        found[k] = z
        if hold_linear:
            w = ((2 * s**3 - 3 * s**2 + 1) * v[k] + (s**3 - 2 * s**2 + s) * step * a[k]
                 + (3 * s**2 - 2 * s**3) * v[k + 1] + (s**3 - s**2) * step * a[k + 1])
        else:
            w = v[k] + step * a[k] * s + (v[k + 1] - v[k] - step * a[k]) * s**2
        for i in range(FINE):
            z += h * rate(z + h / 2 * rate(z, w[2 * i]), w[2 * i + 1])
    found[-1] = z
    return found


def _lagged(command, hold_linear, lag, step):
    """First-order lag of a logged command, integrated finely (midpoint values)."""
    y, found = command[0], np.empty(len(command))
    decay = np.exp(-step / FINE / lag)
    for k in range(len(command) - 1):
        found[k] = y
        for i in range(FINE):
            u = command[k] + (command[k + 1] - command[k]) * (i + 0.5) / FINE if hold_linear else command[k]
            y = u + (y - u) * decay
    found[-1] = y
    return found


def _played(command, width):
    """What a play of half that width makes of a command, sample by sample."""
    found = np.empty(len(command))
    y = command[0]
    for k, u in enumerate(command):
        y = u - width if u - width > y else u + width if u + width < y else y
        found[k] = y
    return found


def _acting(machine, run, t):
    """Acting inputs along the log."""
    u = run.command.copy()
    for e in machine.effects:
        if e.kind.family != "input":
            continue
        x = e.parameters()
        for j in (e.where if isinstance(e.where, tuple) else (e.where,)):
            w, step = u[:, j], 1 / machine.rate
            if e.kind.name == "input_delay" and machine.first_order:
                w = np.interp(t - x["tau"], t, w)
            elif e.kind.name == "input_delay":
                w = w[np.maximum(np.floor((t - x["tau"]) / step + 1e-6).astype(int), 0)]
            elif e.kind.name == "input_lag":
                w = _lagged(w, machine.first_order, x["T"], step)
            elif e.kind.name == "input_gain":
                w = x["c"] * w
            elif e.kind.name == "input_bias":
                w = w + x["u0"]
            elif e.kind.name == "backlash":
                w = _played(w, x["w"])
            elif e.kind.name == "dead_band":
                w = np.sign(w) * np.maximum(np.abs(w) - x["w"], 0)
            else:
                w = np.clip(w, -x["u_max"], x["u_max"])
            u[:, j] = w
    return u


def _extra_force(machine, effect, run, acting, t):
    """Generalised force of a force effect along the log, n columns (contact friction apart)."""
    extra, x, name = np.zeros_like(run.q), effect.parameters(), effect.kind.name
    if name == "speed_drag":
        planar = len(effect.on)
        speed = np.linalg.norm(run.v[:, :planar], axis=1, keepdims=True)
        extra[:, :planar] = -x["c"] * speed * run.v[:, :planar]
        return extra
    if name == "rolling_resistance":
        planar = len(effect.on)
        speed = np.linalg.norm(run.v[:, :planar], axis=1, keepdims=True)
        direction = run.v[:, :planar] / np.maximum(speed, 1e-12)
        extra[:, :planar] = -x["f"] * np.tanh(speed / x["vs"]) * direction
        return extra
    if name == "joint_coupling":
        pair = slice(effect.where, effect.where + 2)
        w = run.v[:, pair].sum(axis=1, keepdims=True)
        extra[:, pair] = -x["d"] * w - x["Fc"] * np.tanh(w / x["vs"])
        return extra
    i = effect.where
    z = None
    if name in ("bouc_wen", "dahl", "lugre"):
        z = _hidden(name, x, run.v[:, i], run.a[:, i], t[1], machine.first_order)
    drive = list(machine.system.driven)
    load = acting[:, drive.index(i)] if i in drive else None
    extra[:, i] = _force(name, x, run.q[:, i], run.v[:, i], load, z)
    return extra


def shoot(machine, run, first, count):
    """State `count` samples after sample `first`: RK4 on CasADi's accelerations, no effects."""
    parameters = machine.true_parameters([])
    model = dataclasses.replace(casadi_model(machine.system, parameters), parameters=parameters)
    function, _ = lagrange.derive(model)
    p, step, parts = list(parameters.values()), 1 / machine.rate, 8
    h = step / parts

    def slope(q, v, k, s):
        u = run.command[k]
        if machine.first_order:
            u = (1 - s) * u + s * run.command[k + 1]
        return np.array(function(q, v, u, (k + s) * step, p)[8])[:, 0]

    q, v = run.q[first], run.v[first]
    for k in range(first, first + count):
        for i in range(parts):
            s, half = i / parts, 0.5 / parts
            a1 = slope(q, v, k, s)
            a2 = slope(q + h / 2 * v, v + h / 2 * a1, k, s + half)
            a3 = slope(q + h / 2 * v + h**2 / 4 * a1, v + h / 2 * a2, k, s + half)
            a4 = slope(q + h * v + h**2 / 2 * a2, v + h * a3, k, s + 2 * half)
            q = q + h * v + h**2 / 6 * (a1 + a2 + a3)
            v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return q, v


def accelerations(machine, run):
    """(accelerations, sample numbers) of a noise-free run by this route."""
    system = machine.system
    parameters = machine.true_parameters()
    model = dataclasses.replace(casadi_model(system, parameters), parameters=parameters)
    t = np.arange(len(run.q)) / machine.rate
    acting = _acting(machine, run, t)
    extra, friction = np.zeros_like(run.q), None
    for e in machine.effects:
        if e.kind.family in ("inertia", "coupling", "gravity"):
            model = _with_energy(model, system, e)
        if e.kind.family == "coupling":
            extra += _extra_force(machine, e, run, acting, t)
        elif e.kind.name == "contact_friction":
            friction = e.parameters()
        elif e.kind.family in ("force", "memory"):
            extra += _extra_force(machine, e, run, acting, t)
    function, _ = lagrange.derive(model)
    p = list(parameters.values())
    picked = np.arange(0, len(t) - 1, 7)
    found = []
    for k in picked:
        values = function(run.q[k], run.v[k], acting[k], t[k], p)
        M, _, Q, _, A, b = (np.array(x) for x in values[:6])
        found.append(_constrained(M, Q[:, 0] + extra[k], A, b[:, 0], run.v[k], friction))
    return np.array(found), picked


def _constrained(M, Q, A, b, v, friction):
    """a of [M A^T; A 0][a; -lambda] = [Q; b]; contact friction by fixed point on the multiplier."""
    m = len(b)
    K = np.block([[M, A.T], [A, np.zeros((m, m))]])
    solution = np.linalg.solve(K, np.concatenate([Q, b]))
    for _ in range(3 if friction else 0):
        normal, speed = np.linalg.norm(A.T @ solution[len(Q):]), np.linalg.norm(v)
        direction = v / speed if speed > 1e-12 else 0 * v
        pull = friction["mu"] * normal * np.tanh(speed / friction["vs"]) * direction
        solution = np.linalg.solve(K, np.concatenate([Q - pull, b]))
    return solution[:len(Q)]
