"""Time stepping: sampled command with soft feedback, RK4, constraint projection."""

import math

import numpy as np

from compiled import njit
from plant import (BACKLASH, DEAD_BAND, INPUT_BIAS, INPUT_DELAY, INPUT_GAIN, INPUT_LAG, SATURATION,
                   UNICYCLE, acceleration, hidden_rate, solve_in_place, terms)


@njit()
def command_at(nodes, j, k, fraction, delay_steps, first_order):
    """Command of input j within interval k, delayed; constant before the log begins."""
    position = fraction - delay_steps
    if delay_steps > 0:
        shift = math.floor(position + 1e-9)
        k, position = k + shift, position - shift
    if k < 0:
        return nodes[0, j]
    if not first_order:
        return nodes[k, j]
    return nodes[k, j] + (nodes[k + 1, j] - nodes[k, j]) * position


@njit()
def through_channel(value, j, kinds, targets, numbers):
    """Gain, dead band, bias, saturation of input j, in this order."""
    for stage in (INPUT_GAIN, DEAD_BAND, INPUT_BIAS, SATURATION):
        for e in range(len(kinds)):
            if kinds[e] == stage and targets[e] == j:
                x = numbers[e, 0]
                if stage == INPUT_GAIN:
                    value *= x
                elif stage == DEAD_BAND:
                    value = 0.0 if abs(value) < x else value - math.copysign(x, value)
                elif stage == INPUT_BIAS:
                    value += x
                else:
                    value = min(max(value, -x), x)
    return value


@njit()
def delays(nu, kinds, targets, numbers, step):
    """Delay of each input in samples."""
    found = np.zeros(nu)
    for e in range(len(kinds)):
        if kinds[e] == INPUT_DELAY:
            found[targets[e]] = numbers[e, 0] / step
    return found


@njit()
def through_play(z, value, width):
    """What follows a value through a play of half that width, from where it was last."""
    return min(max(z, value - width), value + width)


@njit()
def acting_input(nodes, k, fraction, late, first_order, kinds, targets, numbers, z):
    """The input that acts: delay, lag or play (its state in z), then `through_channel`."""
    nu = nodes.shape[1]
    commanded, acting = np.empty(nu), np.empty(nu)
    for j in range(nu):
        commanded[j] = command_at(nodes, j, k, fraction, late[j], first_order)
        value = commanded[j]
        for e in range(len(kinds)):
            if kinds[e] == INPUT_LAG and targets[e] == j:
                value = z[e]
            elif kinds[e] == BACKLASH and targets[e] == j:
                value = through_play(z[e], value, numbers[e, 0])
        acting[j] = through_channel(value, j, kinds, targets, numbers)
    return commanded, acting


@njit()
def project(system, p, m, q, v, t, kinds, targets, numbers):
    """Least-norm correction of q onto c = 0 and of v onto dc/dt = 0, in place."""
    n = len(q)
    M, Q, A = np.zeros((n, n)), np.zeros(n), np.zeros((m, n))
    b, c, rate = np.zeros(m), np.zeros(m), np.zeros(m)
    for velocity in range(2):
        for _ in range(1 if velocity or system == UNICYCLE else 2):
            terms(system, p, q, v, t, kinds, targets, numbers, M, Q, A, b, c, rate)
            if not velocity and system == UNICYCLE:
                continue
            G, r = np.zeros((m, m)), rate.copy() if velocity else c.copy()
            for i in range(m):
                for j in range(m):
                    G[i, j] = (A[i] * A[j]).sum()
            solve_in_place(G, r)
            for i in range(m):
                if velocity:
                    v -= r[i] * A[i]
                else:
                    q -= r[i] * A[i]


@njit()
def feedback(system, q, v, driven, centre, stiffness, damping, speed):
    """Soft PD on the driven coordinates (on the path coordinate for the unicycle)."""
    u = np.empty(len(driven))
    for j in range(len(driven)):
        position, rate = q[driven[j]], v[driven[j]]
        if system == UNICYCLE and j == 0:
            cosine, sine = math.cos(q[2]), math.sin(q[2])
            position, rate = q[0] * cosine + q[1] * sine, v[0] * cosine + v[1] * sine
        u[j] = -stiffness[j] * (position - centre[j]) - damping[j] * (rate - speed[j])
    return u


@njit()
def rate_of(system, p, m, driven, kinds, targets, numbers, q, v, t, z, nodes, k, fraction, middle, late,
            first_order, nameless):
    """(a, dz/dt, lambda, acting input) at one instant within interval k; commands that are held are those
    in the middle of the step, in which none of them jumps."""
    moment = fraction if first_order else middle
    commanded, acting = acting_input(nodes, k, moment, late, first_order, kinds, targets, numbers, z)
    a, multipliers = acceleration(system, p, m, driven, kinds, targets, numbers, q, v, t, acting, z,
                                  nameless[k] + (nameless[k + 1] - nameless[k]) * fraction)
    dz = np.zeros(len(kinds))
    for e in range(len(kinds)):
        if kinds[e] == INPUT_LAG:
            dz[e] = hidden_rate(kinds[e], numbers[e], 0.0, z[e], commanded[targets[e]])
        elif kinds[e] < INPUT_GAIN:
            dz[e] = hidden_rate(kinds[e], numbers[e], v[targets[e]], z[e], 0.0)
    return a, dz, multipliers, acting


@njit()
def simulate(system, p, m, driven, kinds, targets, numbers, q0, v0, open_loop, gains, speeds,
             noise_q, noise_v, step, jitter, substeps, first_order, projected, nameless):
    """Runs the machine; returns q, v, a, command, acting input, hidden states, multipliers.

    open_loop: (N+2, nu) command without feedback; gains: rows centre, stiffness,
    damping; speeds: (N+2, nu) wanted speed; noise_q, noise_v: (N+1, n) what the
    feedback sees on top of the state. The feedback has one sample of latency when the
    command is a first-order hold (the next node must be known), none when it is held.
    jitter: (N+2) how late each sample is; the controller reads, commands and logs then. A delay
    of an input is counted in whole steps and goes with zeros alone.
    nameless: (N+2, n) forces beside all laws, drawn by straight lines from sample to sample.
    """
    count, n, nu = len(open_loop) - 1, len(q0), len(driven)
    Q, V, Acc = np.empty((count, n)), np.empty((count, n)), np.empty((count, n))
    nodes, U = np.zeros((count + 1, nu)), np.empty((count, nu))
    Z, L = np.zeros((count, len(kinds))), np.empty((count, m))
    q, v, z = q0.copy(), v0.copy(), np.zeros(len(kinds))
    late = delays(nu, kinds, targets, numbers, step)
    # where in an interval commands jump that are held and late: no step goes over a jump
    jumps = np.zeros(0) if first_order else late - np.floor(late + 1e-9)
    for k in range(count):
        stretch = jitter[k + 1] - jitter[k]
        fb = feedback(system, q + noise_q[k], v + noise_v[k], driven, gains[0], gains[1], gains[2],
                      speeds[k])
        if k == 0 or not first_order:
            nodes[k] = np.round((open_loop[k] + fb) * 1e5) / 1e5
        if first_order:
            nodes[k + 1] = np.round((open_loop[k + 1] + fb) * 1e5) / 1e5
        if k == 0:
            for e in range(len(kinds)):
                if kinds[e] == INPUT_LAG or kinds[e] == BACKLASH:
                    z[e] = nodes[0, targets[e]]
        for s in range(substeps):
            begin, last = s / substeps, s / substeps + 1.0 / substeps
            f0 = begin
            while f0 < last:
                f1, h = last, (step + stretch) / substeps
                for jump in jumps:
                    if f0 + 1e-9 < jump < f1 - 1e-9:
                        f1 = jump
                if f0 > begin or f1 < last:
                    h = (f1 - f0) * (step + stretch)
                t, fh = (k + f0) * step + (jitter[k] + f0 * stretch), f0 + 0.5 * (f1 - f0)
                th, t1 = t + h / 2, t + h
                a1, g1, lam, acting = rate_of(system, p, m, driven, kinds, targets, numbers, q, v, t, z,
                                              nodes, k, f0, fh, late, first_order, nameless)
                if f0 == 0.0:
                    Q[k], V[k], Acc[k], U[k], Z[k], L[k] = q, v, a1, acting, z, lam
                    if k == count - 1:
                        return Q, V, Acc, nodes[:count], U, Z, L
                v2 = v + h / 2 * a1
                a2, g2, _, _ = rate_of(system, p, m, driven, kinds, targets, numbers, q + h / 2 * v, v2, th,
                                       z + h / 2 * g1, nodes, k, fh, fh, late, first_order, nameless)
                v3 = v + h / 2 * a2
                a3, g3, _, _ = rate_of(system, p, m, driven, kinds, targets, numbers, q + h / 2 * v2, v3, th,
                                       z + h / 2 * g2, nodes, k, fh, fh, late, first_order, nameless)
                v4 = v + h * a3
                a4, g4, _, _ = rate_of(system, p, m, driven, kinds, targets, numbers, q + h * v3, v4, t1,
                                       z + h * g3, nodes, k, f1, fh, late, first_order, nameless)
                q = q + h / 6 * (v + 2 * v2 + 2 * v3 + v4)
                v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
                z = z + h / 6 * (g1 + 2 * g2 + 2 * g3 + g4)
                if m > 0 and projected:
                    project(system, p, m, q, v, t1, kinds, targets, numbers)
                f0 = f1
        for e in range(len(kinds)):
            if kinds[e] == BACKLASH:  # within a sample a command goes one way only
                j = targets[e]
                z[e] = through_play(z[e], command_at(nodes, j, k, 1.0, late[j], first_order), numbers[e, 0])
        if not np.all(np.isfinite(q)) or np.max(np.abs(v)) > 1e3:
            break
    Q[:] = np.nan
    return Q, V, Acc, nodes[:count], U, Z, L


@njit()
def input_series(nodes, step, first_order, kinds, targets, numbers):
    """The acting input at every sample for a logged command (lag and play followed exactly)."""
    count, nu = nodes.shape
    found = np.empty((count, nu))
    late = delays(nu, kinds, targets, numbers, step)
    last = np.empty((count + 1, nu))
    last[:count], last[count] = nodes, nodes[count - 1]
    for j in range(nu):
        lag, play = 0.0, -1.0
        for e in range(len(kinds)):
            if kinds[e] == INPUT_LAG and targets[e] == j:
                lag = numbers[e, 0]
            elif kinds[e] == BACKLASH and targets[e] == j:
                play = numbers[e, 0]
        x = nodes[0, j]
        for k in range(count):
            value = command_at(last, j, k, 0.0, late[j], first_order)
            if play >= 0:
                x = through_play(x, value, play)
            found[k, j] = through_channel(x if lag > 0 or play >= 0 else value, j, kinds, targets, numbers)
            if lag > 0:
                end = command_at(last, j, k, 1.0, late[j], first_order) if first_order else value
                slope, decay = (end - value) / step, math.exp(-step / lag)
                x = end - lag * slope + (x - value + lag * slope) * decay
    return found


@njit()
def predict(system, p, m, driven, kinds, targets, numbers, q, v, t, u, z):
    """Accelerations of a model along given states, acting inputs and hidden states."""
    found, none = np.empty_like(q), np.zeros(q.shape[1])
    for k in range(len(t)):
        found[k] = acceleration(system, p, m, driven, kinds, targets, numbers, q[k], v[k], t[k], u[k],
                                z[k], none)[0]
    return found
