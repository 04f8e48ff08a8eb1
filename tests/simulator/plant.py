"""Equations of motion of the simulated machines, compiled by numba.

Hand-written closed forms (no derivation tool, nothing shared with the Rust side):
`terms` gives M, Q, A, b, c, dc/dt; `acceleration` adds the undeclared effects and
solves [M A^T; A 0][a; -lambda] = [Q; b]. Effects are records (kind, target,
six numbers); kinds are the integers below, their numbers stand in effects.py.
"""

import math

import numpy as np

from compiled import njit

# systems
CHAIN, CARTPOLE, PARTICLE, UNICYCLE, DUFFING = range(5)

# effects: generalised forces, inertia, hidden states, input channel
(VISCOUS, COULOMB, STRIBECK, QUADRATIC_DRAG, SPEED_DRAG, CONSTANT_FORCE, SPRING, CUBIC_SPRING,
 COGGING, LOAD_FRICTION, CONTACT_FRICTION, POSITION_VISCOUS, ASYMMETRIC_COULOMB,
 ROLLING_RESISTANCE) = range(14)
ARMATURE, PAYLOAD, COM_OFFSET, JOINT_COUPLING, GRAVITY_TILT = range(20, 25)
BOUC_WEN, DAHL, LUGRE = range(30, 33)
INPUT_GAIN, INPUT_BIAS, INPUT_DELAY, INPUT_LAG, DEAD_BAND, SATURATION, BACKLASH = range(40, 47)


@njit()
def chain_bodies(n, p, kinds, targets, numbers):
    """Rows (link, mass, distance from its joint, inertia, angle from the link): the links, then
    payloads. A centre of mass that is elsewhere is at another distance and angle."""
    extra = 0
    for e in range(len(kinds)):
        extra += kinds[e] == PAYLOAD
    bodies = np.zeros((n + extra, 5))
    for i in range(n):
        bodies[i, 0], bodies[i, 1] = i, p[4 * i]
        bodies[i, 2], bodies[i, 3] = p[4 * i + 2], p[4 * i + 3]
    row = n
    for e in range(len(kinds)):
        if kinds[e] == PAYLOAD:
            bodies[row, 0], bodies[row, 1], bodies[row, 2] = targets[e], numbers[e, 0], numbers[e, 1]
            row += 1
        elif kinds[e] == COM_OFFSET:
            link = targets[e]
            along, across = bodies[link, 2] + numbers[e, 0], numbers[e, 1]
            bodies[link, 2], bodies[link, 4] = math.hypot(along, across), math.atan2(across, along)
    return bodies


@njit()
def gravity_turn(kinds, numbers):
    """Angle by which gravity is turned, counter-clockwise."""
    angle = 0.0
    for e in range(len(kinds)):
        if kinds[e] == GRAVITY_TILT:
            angle += numbers[e, 0]
    return angle


@njit()
def chain_terms(n, p, q, v, bodies, tilt, M, Q):
    """Planar chain with relative angles; p = (m, L, lc, I) per link, g, g-direction, d.

    Absolute angles phi = cumulative sum of q. With r_i the lever of link i for a
    body, M_abs[i,j] = sum m r_i r_j cos(phi_i - phi_j), and the bias likewise with
    the sine; at the body itself phi is that of its lever. Gravity is turned by `tilt`.
    p[4n+1] = 0: phi from the downward vertical; 1: phi from the x axis.
    """
    g, from_x = p[4 * n], p[4 * n + 1] > 0.5
    phi, w = np.cumsum(q), np.cumsum(v)
    absolute, force = np.zeros((n, n)), np.zeros(n)
    for body in range(len(bodies)):
        last, mass = int(bodies[body, 0]), bodies[body, 1]
        absolute[last, last] += bodies[body, 3]
        for i in range(last + 1):
            ri = p[4 * i + 1] if i < last else bodies[body, 2]
            at_i = phi[i] if i < last else phi[i] + bodies[body, 4]
            force[i] -= mass * g * ri * (math.cos(at_i - tilt) if from_x else math.sin(at_i - tilt))
            for j in range(last + 1):
                rj = p[4 * j + 1] if j < last else bodies[body, 2]
                at_j = phi[j] if j < last else phi[j] + bodies[body, 4]
                absolute[i, j] += mass * ri * rj * math.cos(at_i - at_j)
                force[i] -= mass * ri * rj * math.sin(at_i - at_j) * w[j] * w[j]
    for i in range(n):
        Q[i] = force[i:].sum()
        for j in range(n):
            M[i, j] = absolute[i:, j:].sum()


@njit()
def chain_closure(n, p, q, v, A, b, c, rate):
    """The end of the last link stays at (d, 0)."""
    phi, w = np.cumsum(q), np.cumsum(v)
    c[0], c[1], b[0], b[1] = -p[4 * n + 2], 0.0, 0.0, 0.0
    for i in range(n):
        length, cosine, sine = p[4 * i + 1], math.cos(phi[i]), math.sin(phi[i])
        c[0] += length * cosine
        c[1] += length * sine
        b[0] += length * cosine * w[i] * w[i]
        b[1] += length * sine * w[i] * w[i]
        for j in range(i + 1):
            A[0, j] -= length * sine
            A[1, j] += length * cosine
    for row in range(2):
        rate[row] = 0.0
        for j in range(n):
            rate[row] += A[row, j] * v[j]


@njit()
def terms(system, p, q, v, t, kinds, targets, numbers, M, Q, A, b, c, rate):
    """Fills M, Q (without inputs), A, b, c and rate (dc/dt, or c if nonholonomic)."""
    n, m = len(q), len(b)
    M[:, :], Q[:], A[:, :] = 0.0, 0.0, 0.0
    tilt = gravity_turn(kinds, numbers)
    if system == CHAIN:
        chain_terms(n, p, q, v, chain_bodies(n, p, kinds, targets, numbers), tilt, M, Q)
        if m == 2:
            chain_closure(n, p, q, v, A, b, c, rate)
    elif system == CARTPOLE:  # mc, mp, l, I, g
        _pole(p[1], p[2], p[3], p[4], tilt, q, v, M, Q)
        M[0, 0] += p[0]
        Q[0] += p[0] * p[4] * math.sin(tilt)
        for e in range(len(kinds)):
            if kinds[e] == PAYLOAD:
                _pole(numbers[e, 0], numbers[e, 1], 0.0, p[4], tilt, q, v, M, Q)
    elif system == PARTICLE:  # m, p1..p5, g
        for i in range(3):
            M[i, i] = p[0]
        Q[2] = -p[0] * p[6]
        wave = p[5] * q[0]
        A[0, 0] = 2 * p[1] * q[0] + p[3] - p[4] * p[5] * math.sin(wave)
        A[0, 1], A[0, 2] = 2 * p[2] * q[1], -1.0
        curvature = 2 * p[1] - p[4] * p[5] * p[5] * math.cos(wave)
        b[0] = -curvature * v[0] * v[0] - 2 * p[2] * v[1] * v[1]
        c[0] = p[1] * q[0]**2 + p[2] * q[1]**2 + p[3] * q[0] + p[4] * math.cos(wave) - q[2]
        rate[0] = A[0, 0] * v[0] + A[0, 1] * v[1] - v[2]
    elif system == UNICYCLE:  # m, R, I_G
        _planar_mass(p[0], p[1], 0.0, q, v, M, Q)
        M[2, 2] += p[2]
        for e in range(len(kinds)):
            if kinds[e] == PAYLOAD:
                _planar_mass(numbers[e, 0], numbers[e, 1], numbers[e, 2], q, v, M, Q)
        sine, cosine = math.sin(q[2]), math.cos(q[2])
        A[0, 0], A[0, 1] = sine, -cosine
        b[0] = -v[2] * (v[0] * cosine + v[1] * sine)
        rate[0] = v[0] * sine - v[1] * cosine
        c[0] = rate[0]
    else:  # DUFFING: m1, m2, k1, k2, c1, c2, k1nl, k2nl (, p1, p2, p3)
        M[0, 0], M[1, 1] = p[0], p[1]
        stretch = q[0] - q[1]
        between = p[2] * stretch + p[4] * (v[0] - v[1]) + p[6] * stretch**3
        Q[0] = -between
        Q[1] = between - p[3] * q[1] - p[5] * v[1] - p[7] * q[1]**3
        if m == 1:
            decay, sine, cosine = p[8] * math.exp(-p[9] * t), math.sin(p[10] * t), math.cos(p[10] * t)
            A[0, 0], A[0, 1] = -1.0, 1.0
            c[0] = q[1] - q[0] - decay * sine
            rate[0] = v[1] - v[0] - decay * (p[10] * cosine - p[9] * sine)
            b[0] = decay * ((p[9]**2 - p[10]**2) * sine - 2 * p[9] * p[10] * cosine)


@njit()
def _pole(mass, length, inertia, g, tilt, q, v, M, Q):
    sine, cosine = math.sin(q[1]), math.cos(q[1])
    M[0, 0] += mass
    M[0, 1] += mass * length * cosine
    M[1, 0] += mass * length * cosine
    M[1, 1] += inertia + mass * length * length
    Q[0] += mass * length * sine * v[1] * v[1] + mass * g * math.sin(tilt)
    Q[1] -= mass * g * length * math.sin(q[1] - tilt)


@njit()
def _planar_mass(mass, ahead, left, q, v, M, Q):
    sine, cosine = math.sin(q[2]), math.cos(q[2])
    rx, ry = ahead * cosine - left * sine, ahead * sine + left * cosine
    M[0, 0] += mass
    M[1, 1] += mass
    M[2, 2] += mass * (rx * rx + ry * ry)
    M[0, 2] -= mass * ry
    M[2, 0] -= mass * ry
    M[1, 2] += mass * rx
    M[2, 1] += mass * rx
    Q[0] += mass * rx * v[2] * v[2]
    Q[1] += mass * ry * v[2] * v[2]


@njit()
def add_inputs(system, q, u, driven, Q):
    """Q += B u."""
    if system == UNICYCLE:
        Q[0] += math.cos(q[2]) * u[0]
        Q[1] += math.sin(q[2]) * u[0]
        Q[2] += u[1]
    else:
        for j in range(len(u)):
            Q[driven[j]] += u[j]


@njit()
def effect_force(kind, x, q, v, load, z):
    """Generalised force of one effect on its own coordinate (numbers x, hidden state z)."""
    if kind == VISCOUS:
        return -x[0] * v
    if kind == COULOMB:
        return -x[0] * math.tanh(v / x[1])
    if kind == ASYMMETRIC_COULOMB:
        sign = math.tanh(v / x[2])
        return -sign * (x[0] * (1 + sign) + x[1] * (1 - sign)) / 2
    if kind == STRIBECK:
        return -(x[0] + (x[1] - x[0]) * math.exp(-(v / x[2])**2)) * math.tanh(v / x[3]) - x[4] * v
    if kind == QUADRATIC_DRAG:
        return -x[0] * abs(v) * v
    if kind == CONSTANT_FORCE:
        return x[0]
    if kind == SPRING:
        return -x[0] * (q - x[1])
    if kind == CUBIC_SPRING:
        return -x[0] * (q - x[1])**3
    if kind == COGGING:
        return -x[0] * math.sin(x[1] * q + x[2])
    if kind == LOAD_FRICTION:
        return -x[0] * abs(load) * math.tanh(v / x[1])
    if kind == POSITION_VISCOUS:
        return -x[0] * (1 + math.sin(x[1] * q + x[2])) * v
    if kind == BOUC_WEN:
        return -x[0] * z
    if kind == DAHL:
        return -z
    if kind == LUGRE:
        return -x[0] * z - x[1] * v
    return 0.0


@njit()
def hidden_rate(kind, x, v, z, command):
    """Time derivative of an effect's hidden state."""
    if kind == BOUC_WEN:  # k, A, beta, gamma, n = 1
        return x[1] * v - x[2] * abs(v) * z - x[3] * v * abs(z)
    if kind == DAHL:  # Fc, sigma
        return x[1] * (v - abs(v) * z / x[0])
    if kind == LUGRE:  # Fc, d, reach, rise, vst
        return (v - abs(v) * z / (1 + x[3] * math.exp(-(v / x[4])**2))) / x[2]
    if kind == INPUT_LAG:
        return (command - z) / x[0]
    return 0.0


@njit()
def solve_in_place(K, r):
    """Gaussian elimination with partial pivoting; the solution replaces r."""
    size = len(r)
    for i in range(size):
        pivot = i
        for k in range(i + 1, size):
            if abs(K[k, i]) > abs(K[pivot, i]):
                pivot = k
        if pivot != i:
            for j in range(size):
                K[i, j], K[pivot, j] = K[pivot, j], K[i, j]
            r[i], r[pivot] = r[pivot], r[i]
        for k in range(i + 1, size):
            factor = K[k, i] / K[i, i]
            if factor != 0.0:
                for j in range(i, size):
                    K[k, j] -= factor * K[i, j]
                r[k] -= factor * r[i]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            r[i] -= K[i, j] * r[j]
        r[i] /= K[i, i]


@njit()
def _saddle(M, Q, A, b):
    n, m = len(Q), len(b)
    K, r = np.zeros((n + m, n + m)), np.zeros(n + m)
    K[:n, :n], K[:n, n:], K[n:, :n] = M, A.T, A
    r[:n], r[n:] = Q, b
    solve_in_place(K, r)
    return r


@njit()
def acceleration(system, p, m, driven, kinds, targets, numbers, q, v, t, u, z, nameless):
    """(a, lambda) of the machine with effects; u is the input that really acts, `nameless` a force per
    coordinate that follows no law."""
    n = len(q)
    M, Q, A = np.zeros((n, n)), np.zeros(n), np.zeros((m, n))
    b, c, rate = np.zeros(m), np.zeros(m), np.zeros(m)
    terms(system, p, q, v, t, kinds, targets, numbers, M, Q, A, b, c, rate)
    add_inputs(system, q, u, driven, Q)
    Q += nameless
    friction = -1
    for e in range(len(kinds)):
        kind, i, x = kinds[e], targets[e], numbers[e]
        if kind == ARMATURE:
            M[i, i] += x[0]
        elif kind == SPEED_DRAG or kind == ROLLING_RESISTANCE:
            planar = 2 if system == UNICYCLE else n
            speed = math.sqrt((v[:planar]**2).sum())
            if kind == SPEED_DRAG:
                per_velocity = x[0] * speed
            else:
                per_velocity = x[0] * (math.tanh(speed / x[1]) / speed if speed > 1e-9 else 1 / x[1])
            for j in range(planar):
                Q[j] -= per_velocity * v[j]
        elif kind == JOINT_COUPLING:  # I, d, Fc, vs of a drive that turns with joints i and i + 1
            together = v[i] + v[i + 1]
            force = -x[1] * together - x[2] * math.tanh(together / x[3])
            for j in range(i, i + 2):
                Q[j] += force
                M[j, i] += x[0]
                M[j, i + 1] += x[0]
        elif kind == CONTACT_FRICTION:
            friction = e
        elif kind < ARMATURE or BOUC_WEN <= kind <= LUGRE:
            load = 0.0
            for j in range(len(u)):
                if driven[j] == i:
                    load = u[j]
            Q[i] += effect_force(kind, x, q[i], v[i], load, z[e])
    solution = _saddle(M, Q, A, b)
    if friction >= 0:
        # particle on a surface: friction is tangential, so it leaves the multiplier as it is
        normal = abs(solution[n]) * math.sqrt((A[0]**2).sum())
        speed = math.sqrt((v**2).sum())
        mu, width = numbers[friction, 0], numbers[friction, 1]
        ratio = math.tanh(speed / width) / speed if speed > 1e-9 else 1 / width
        for i in range(n):
            Q[i] -= mu * normal * ratio * v[i]
        solution = _saddle(M, Q, A, b)
    return solution[:n].copy(), -solution[n:]
