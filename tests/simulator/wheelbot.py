"""The Wheelbot on the floor, in closed loop, as its own log shows it.

Maggi's equations from positions alone: with v = Z(q) w the velocities that rolling allows,
Z'M Z dw/dt = Z'(f - M dZ/dt w), where M and f are CasADi's derivatives of energies written here.
Nothing of this is the program's or the oracle's (tests/casadi), which `verify_wheelbot.py` compares
with it.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

COORDINATES = ("x", "y", "roll", "pitch", "yaw", "wheel", "reaction")
INPUTS = ("reaction", "wheel")
NOMINAL = {"m_w": 0.3, "m_b": 0.75, "m_r": 0.3, "I_w_r": 0.000259, "I_w_a": 0.000503, "I_bx": 0.001746,
           "I_by": 0.00181, "I_bz": 0.001585, "I_r_a": 0.000503, "I_r_r": 0.000259, "r_w": 0.053,
           "l_wb": 0.055, "l_br": 0.055, "b_x": 0.0, "b_y": 0.0, "g": 9.81}
"""Parameters of models/wheelbot.model."""
FAULTS = {"slope_x": 0.0, "slope_y": 0.0, "dry_wheel": 0.0, "dry_reaction": 0.0, "rolling": 0.0, "lag_wheel": 0.0,
          "lag_reaction": 0.0}
"""Where the floor's gravity points, sines of its angles along x and y; friction in the axles, N m, and of the tread,
N; time constants of the current loops, s."""
WIDTH = {"axle": 0.5, "tread": 0.02}
"""Speeds at which smooth friction has 76 % of its size, rad/s and m/s."""
MOUNTS = ((-0.048, -0.048, 0.119, -135, -90), (0.048, 0.048, 0.119, 45, -90), (0.048, -0.048, -0.004, -45, 90),
          (-0.048, 0.048, -0.004, 135, 90))
"""Of each IMU where it stands, m, and how it is turned: about z, then about x, degrees."""
RATE, STEPS = 100, 10
"""Ticks per second; Runge-Kutta steps per tick."""


def _turned(axis, angle):
    c, s = ca.cos(angle), ca.sin(angle)
    rows = {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis]
    return ca.vertcat(*[ca.horzcat(*row) for row in rows])


def _turning(rotation, q, v):
    """Angular velocity along the axes of the body whose axes the rotation's columns are."""
    rate = ca.reshape(ca.jtimes(ca.vec(rotation), q, v), 3, 3)
    skew = rotation.T @ rate
    return ca.vertcat(skew[2, 1], skew[0, 2], skew[1, 0])


def _equations():
    """CasADi functions: (x, u, p) to (dx/dt, accelerations), and of what instruments show."""
    q, w, z = ca.SX.sym("q", 7), ca.SX.sym("w", 5), ca.SX.sym("z", 2)
    u, p_all = ca.SX.sym("u", 2), ca.SX.sym("p", len(NOMINAL) + len(FAULTS))
    p = {name: p_all[i] for i, name in enumerate([*NOMINAL, *FAULTS])}
    v, a = ca.SX.sym("v", 7), ca.SX.sym("a", 7)
    upright = _turned("z", q[4]) @ _turned("x", q[2])
    chassis = upright @ _turned("y", q[3])
    hub = ca.vertcat(q[0], q[1], 0) + upright @ ca.vertcat(0, 0, p["r_w"])
    bodies = (
        (p["m_w"], hub, upright @ _turned("y", q[5]), (p["I_w_r"], p["I_w_a"], p["I_w_r"])),
        (p["m_b"], hub + chassis @ ca.vertcat(p["b_x"], p["b_y"], p["l_wb"]), chassis,
         (p["I_bx"], p["I_by"], p["I_bz"])),
        (p["m_r"], hub + chassis @ ca.vertcat(0, 0, p["l_wb"] + p["l_br"]), chassis @ _turned("x", q[6]),
         (p["I_r_a"], p["I_r_r"], p["I_r_r"])),
    )
    down = ca.vertcat(p["slope_x"], p["slope_y"], -ca.sqrt(1 - p["slope_x"]**2 - p["slope_y"]**2))
    kinetic, potential = 0, 0
    for mass, place, rotation, inertia in bodies:
        speed, turn = ca.jtimes(place, q, v), _turning(rotation, q, v)
        kinetic += mass / 2 * ca.sumsqr(speed) + ca.dot(ca.vertcat(*inertia), turn**2) / 2
        potential -= mass * p["g"] * ca.dot(down, place)
    momentum = ca.gradient(kinetic, v)
    mass_matrix = ca.jacobian(momentum, v)
    acting = ca.vertcat(ca.if_else(p["lag_reaction"] > 0, z[0], u[0]), ca.if_else(p["lag_wheel"] > 0, z[1], u[1]))
    axle = acting[1] - p["dry_wheel"] * ca.tanh((v[5] - v[3]) / WIDTH["axle"])
    speed = ca.sqrt(v[0]**2 + v[1]**2 + 1e-16)
    drag = p["rolling"] * ca.tanh(speed / WIDTH["tread"]) / speed
    force = ca.vertcat(-drag * v[0], -drag * v[1], 0, -axle, 0, axle,
                       acting[0] - p["dry_reaction"] * ca.tanh(v[6] / WIDTH["axle"]))
    force += ca.gradient(kinetic - potential, q) - ca.jtimes(momentum, q, v)
    free = ca.SX.zeros(7, 5)
    free[2:, :] = ca.SX.eye(5)
    free[0, 3], free[1, 3] = p["r_w"] * ca.cos(q[4]), p["r_w"] * ca.sin(q[4])
    drift = ca.jtimes(free @ w, q, v)
    reduced = ca.solve(free.T @ mass_matrix @ free, free.T @ (force - mass_matrix @ drift))
    moving, rate = free @ w, ca.substitute(reduced, v, free @ w)
    acceleration = free @ rate + ca.substitute(drift, v, moving)
    lags = ca.vertcat(p["lag_reaction"], p["lag_wheel"])
    delivered = (u - z) / ca.fmax(lags, 1e-3)
    state = ca.vertcat(q, w, z)
    motion = ca.Function("motion", [state, u, p_all], [ca.vertcat(moving, rate, delivered), moving, acceleration])
    shown = []
    for x, y, height, about_z, about_x in MOUNTS:
        mount = _turned("z", np.deg2rad(about_z)) @ _turned("x", np.deg2rad(about_x))
        board = chassis @ mount
        place = hub + chassis @ ca.vertcat(x, y, height)
        pushed = ca.jtimes(place, q, a) + ca.jtimes(ca.jtimes(place, q, v), q, v) - p["g"] * down
        shown.append((_turning(board, q, v), board.T @ pushed))
    readings = ca.vertcat(*[gyro for gyro, _ in shown], *[felt for _, felt in shown], q[5] - q[3], q[6])
    return motion, ca.Function("instruments", [q, v, a, p_all], [readings])


MOTION, INSTRUMENTS = _equations()


def _advanced():
    x, u, p, h = ca.SX.sym("x", 14), ca.SX.sym("u", 2), ca.SX.sym("p", len(NOMINAL) + len(FAULTS)), ca.SX.sym("h")
    k1 = MOTION(x, u, p)[0]
    k2 = MOTION(x + h / 2 * k1, u, p)[0]
    k3 = MOTION(x + h / 2 * k2, u, p)[0]
    k4 = MOTION(x + h * k3, u, p)[0]
    once = ca.Function("advanced", [x, u, p, h], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])
    return once.mapaccum(STEPS)


ADVANCED = _advanced()
"""(state, inputs, parameters, s) to the states at the ends of STEPS Runge-Kutta steps of so many seconds."""

NAMES = ([f"gyro_{i}_{axis}" for i in range(1, 5) for axis in "xyz"]
         + [f"felt_{i}_{axis}" for i in range(1, 5) for axis in "xyz"] + ["rolling", "spinning"])
"""Columns of what the instruments show."""
NOISE = np.array([0.0253] * 12 + [0.07] * 12 + [0.0] * 2)
RESOLUTION = np.array([0.0002663161] * 12 + [0.000598755] * 12 + [2 * np.pi / 20000] * 2)
GAINS = np.array([[4.5, 0.25, 0.0003, 0.0018], [1.6, 0.14, 0.04, 0.0344]])
"""Published gains on tilt, tilt rate, wheel angle and wheel rate: roll by the reaction wheel, pitch by the other."""
LIMIT = 1.3
"""Torque at most, N m."""
FALLEN = 0.8
"""Tilt at which the robot counts as fallen, rad."""


class Fallen(RuntimeError):
    """The robot did not balance."""


@dataclass(frozen=True)
class Fault:
    """What a robot has that its model lacks."""

    effect: str = "none"
    on: tuple = ()
    parameters: dict = None
    """Numbers of the effect as the model's language calls them."""
    machine: dict = None
    """Parameters and faults of the equations that differ from the model's."""
    delay: tuple = (0.0, 0.0)
    """How late the torques of reaction wheel and rolling wheel act, s."""
    mount: tuple = None
    """(IMU, axis, angle) by which a board is turned beyond what the model says."""


def multisine(rng, t, rms, band):
    """A sum of sines of random phase and frequency."""
    tones = rng.uniform(*band, 6)
    sines = np.sin(2 * np.pi * tones * t[:, None] + rng.uniform(0, 2 * np.pi, 6))
    return rms * np.sqrt(2 / 6) * sines.sum(axis=1)


def run(rng, fault, seconds, noisy=True):
    """(times, torques, readings, states) of one log: the robot balances, drives and leans.

    At the beginning of a tick the torques of the tick before are sent, then instruments are read.
    """
    count = int(round(seconds * RATE)) + 1
    t = np.arange(count) / RATE
    p = {**NOMINAL, **FAULTS, **(fault.machine or {})}
    p = np.array([p[name] for name in [*NOMINAL, *FAULTS]])
    # Where to drive, how to lean, and torques on top.
    drive = multisine(rng, t, 2.5, (0.1, 0.4))
    lean = multisine(rng, t, 0.012, (0.2, 1.0))
    extra = np.stack([multisine(rng, t, 0.05, (0.5, 4.0)), multisine(rng, t, 0.03, (0.5, 4.0))], axis=1)
    drift = np.zeros(2)
    x = np.zeros(14)
    before, pending = np.zeros(2), np.zeros(2)
    torques, readings, states = np.zeros((count, 2)), np.zeros((count, len(NAMES))), np.zeros((count, 21))
    for k in range(count):
        acting = pending
        begun = np.where(np.array(fault.delay) > 0, before, acting)
        _, v, a = (np.array(part).ravel() for part in MOTION(x, begun, p))
        states[k] = np.concatenate([x[:7], v, a])
        readings[k] = shown(x[:7], v, a, p, fault)
        torques[k] = acting
        # What the controller believes: tilts that drift a little, noisy rates.
        drift = 0.98 * drift + 0.001 * rng.standard_normal(2) * noisy
        rates = v[2:4] + 0.0126 * rng.standard_normal(2) * noisy
        rolling, spinning = readings[k, -2:]
        seen = np.array([[x[2] + drift[0] - lean[k], rates[0], spinning, v[6]],
                         [x[3] + drift[1], rates[1], rolling - drive[k], v[5] - v[3]]])
        pending = np.clip((GAINS * seen).sum(axis=1) + extra[k], -LIMIT, LIMIT)
        x = tick(x, before, acting, p, fault.delay)
        before = acting
        if not np.all(np.abs(x[2:4]) < FALLEN):
            raise Fallen(f"after {t[k]:.1f} s")
    noise = NOISE * rng.standard_normal(readings.shape) * noisy
    if noisy:
        readings = np.round((readings + noise) / RESOLUTION) * RESOLUTION
    return t, torques, readings, states


def tick(x, before, acting, p, delay):
    """The state a tick later: torques change where they arrive."""
    h = 1 / RATE
    changes = sorted({0.0, h, *(d for d in delay if 0 < d < h)})
    for begin, end in zip(changes, changes[1:]):
        u = np.where(np.array(delay) > begin + 1e-12, before, acting)
        x = np.array(ADVANCED(x, u, p, (end - begin) / STEPS))[:, -1]
    return x


def shown(q, v, a, p, fault):
    """What the instruments show without noise."""
    readings = np.array(INSTRUMENTS(q, v, a, p)).ravel()
    if fault.mount:
        imu, axis, angle = fault.mount
        turn = np.array(ca.DM(_turned(axis, angle)))
        for begin in (3 * imu, 12 + 3 * imu):
            readings[begin:begin + 3] = turn.T @ readings[begin:begin + 3]
    return readings


def write(path, t, torques, readings):
    """The log as the robot writes it."""
    table = np.column_stack([t, torques, readings])
    header = ",".join(["t", *(f"u_{name}" for name in INPUTS), *NAMES])
    formats = ["%.2f", *["%.5f"] * len(INPUTS), *["%.7g"] * len(NAMES)]
    np.savetxt(path, table, fmt=formats, delimiter=",", header=header, comments="")
