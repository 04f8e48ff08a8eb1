"""The ten language models and the Wheelbot, stated by energies, inputs, damping, friction and constraints.

Nothing here is an equation of motion: `lagrange.py` derives those with CasADi.
Names of coordinates, inputs and parameters are those of the simulated logs
(`nominal.json`); nominal values are those of one log of the same system.
"""

from dataclasses import dataclass, field
from typing import Callable

import casadi as ca


@dataclass(frozen=True)
class Model:
    """One mechanical system.

    `energies(q, v, p)` returns kinetic and potential energy; `rayleigh(q, v, p)`
    the Rayleigh function R with Q_D = -dR/dv; `power(q, v, u)` the power of the
    inputs, whose derivative with respect to v is the generalised input force;
    `holonomic(q, t, p)` and `nonholonomic(q, v, t, p)` dictionaries name -> c.
    `states` are internal, with `rates(z, late, p)`; `late` are inputs that arrive with a
    delay. What is stored acts like an input: `stored_power(v, z)`. `rubbing(q, v, p)`, of a
    model with one constraint, is the generalised friction force per absolute multiplier.
    `q`, `v`, `u`, `z`, `late` and `p` are dictionaries of CasADi symbols by name.
    """

    name: str
    coordinates: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: dict[str, float]
    energies: Callable
    power: Callable
    rayleigh: Callable = lambda q, v, p: 0
    holonomic: Callable = lambda q, t, p: {}
    nonholonomic: Callable = lambda q, v, t, p: {}
    states: tuple[str, ...] = ()
    late: tuple[str, ...] = ()
    rates: Callable = lambda z, late, p: {}
    stored_power: Callable = lambda v, z: 0
    rubbing: Callable | None = None
    cases: int = 50
    """How many states are written down."""
    scale: dict[str, float] = field(default_factory=dict)
    """Half-width of the sampling interval of a coordinate (1 if absent)."""


def _rate(expression, q, v):
    """Time derivative of a position expression: sum of d/dq_i times v_i."""
    names = list(q)
    positions = ca.vertcat(*[q[k] for k in names])
    rates = ca.vertcat(*[v[k] for k in names])
    return ca.mtimes(ca.jacobian(expression, positions), rates)


def _squared(vector):
    return ca.dot(vector, vector)


def _along(q, v, u):
    """Each input acts along the coordinate of its name."""
    return sum(u[k] * v[k] for k in u)


# --- particle on a surface -------------------------------------------------

def _particle_energies(q, v, p):
    speed2 = v["x"] ** 2 + v["y"] ** 2 + v["z"] ** 2
    return p["m"] / 2 * speed2, p["m"] * p["g"] * q["z"]


def _particle_surface(q, t, p):
    height = (p["p1"] * q["x"] ** 2 + p["p2"] * q["y"] ** 2 + p["p3"] * q["x"]
              + p["p4"] * ca.cos(p["p5"] * q["x"]))
    return {"surface": height - q["z"]}


# --- unicycle --------------------------------------------------------------

def _unicycle_energies(q, v, p):
    centre = ca.vertcat(q["x"] + p["R"] * ca.cos(q["theta"]),
                        q["y"] + p["R"] * ca.sin(q["theta"]))
    kinetic = (p["m"] * _squared(_rate(centre, q, v)) + p["I_G"] * v["theta"] ** 2) / 2
    return kinetic, 0


def _unicycle_power(q, v, u):
    forward = ca.cos(q["theta"]) * v["x"] + ca.sin(q["theta"]) * v["y"]
    return u["drive"] * forward + u["turn"] * v["theta"]


def _unicycle_slip(q, v, t, p):
    return {"no_side_slip": ca.sin(q["theta"]) * v["x"] - ca.cos(q["theta"]) * v["y"]}


# --- Duffing masses --------------------------------------------------------

def _duffing_energies(q, v, p):
    kinetic = (p["m1"] * v["x1"] ** 2 + p["m2"] * v["x2"] ** 2) / 2
    stretch = q["x1"] - q["x2"]
    potential = (p["k1"] / 2 * stretch ** 2 + p["k1nl"] / 4 * stretch ** 4
                 + p["k2"] / 2 * q["x2"] ** 2 + p["k2nl"] / 4 * q["x2"] ** 4)
    return kinetic, potential


def _duffing_rayleigh(q, v, p):
    return p["c1"] / 2 * (v["x1"] - v["x2"]) ** 2 + p["c2"] / 2 * v["x2"] ** 2


def _duffing_control(q, t, p):
    offset = p["p1"] * ca.exp(-p["p2"] * t) * ca.sin(p["p3"] * t)
    return {"control": q["x2"] - q["x1"] - offset}


# --- pendulums and cart ----------------------------------------------------

def _pendulum_energies(q, v, p):
    centre = p["l"] * ca.vertcat(ca.sin(q["j1"]), -ca.cos(q["j1"]))
    kinetic = (p["m"] * _squared(_rate(centre, q, v)) + p["I"] * v["j1"] ** 2) / 2
    return kinetic, p["m"] * p["g"] * centre[1]


def _pendulum2_energies(q, v, p):
    def down(angle):
        return ca.vertcat(ca.sin(angle), -ca.cos(angle))

    second = q["j1"] + q["j2"]
    centre1 = p["lc1"] * down(q["j1"])
    centre2 = p["l1"] * down(q["j1"]) + p["lc2"] * down(second)
    kinetic = (p["m1"] * _squared(_rate(centre1, q, v)) + p["I1"] * v["j1"] ** 2
               + p["m2"] * _squared(_rate(centre2, q, v))
               + p["I2"] * _rate(second, q, v) ** 2) / 2
    return kinetic, p["g"] * (p["m1"] * centre1[1] + p["m2"] * centre2[1])


def _cartpole_energies(q, v, p):
    centre = ca.vertcat(q["x"] + p["l"] * ca.sin(q["theta"]), -p["l"] * ca.cos(q["theta"]))
    kinetic = (p["mc"] * v["x"] ** 2 + p["mp"] * _squared(_rate(centre, q, v))
               + p["I"] * v["theta"] ** 2) / 2
    return kinetic, p["mp"] * p["g"] * centre[1]


# --- four-bar linkage ------------------------------------------------------

def _fourbar_angles(q):
    return (q["j1"], q["j1"] + q["j2"], q["j1"] + q["j2"] + q["j3"])


def _fourbar_energies(q, v, p):
    joint = ca.vertcat(0, 0)
    kinetic = potential = 0
    for i, angle in enumerate(_fourbar_angles(q), start=1):
        direction = ca.vertcat(ca.cos(angle), ca.sin(angle))
        centre = joint + p[f"lc{i}"] * direction
        kinetic += (p[f"m{i}"] * _squared(_rate(centre, q, v))
                    + p[f"I{i}"] * _rate(angle, q, v) ** 2) / 2
        potential += p[f"m{i}"] * p["g"] * centre[1]
        joint = joint + p[f"L{i}"] * direction
    return kinetic, potential


def _fourbar_closure(q, t, p):
    angles = _fourbar_angles(q)
    x = sum(p[f"L{i}"] * ca.cos(a) for i, a in enumerate(angles, start=1)) - p["d"]
    y = sum(p[f"L{i}"] * ca.sin(a) for i, a in enumerate(angles, start=1))
    return {"closure_x": x, "closure_y": y}


# --- delta robot -----------------------------------------------------------

_DELTA_ARMS = {"front": 0.0, "left": 2 * ca.pi / 3, "right": 4 * ca.pi / 3}
_DELTA_PLATFORM = 0.3


def _delta_points(q, p, arm):
    """Shoulder, elbow and wrist of an arm, and where the wrist belongs on the platform."""
    angle = _DELTA_ARMS[arm]
    out = ca.vertcat(ca.cos(angle), ca.sin(angle), 0)
    across = ca.vertcat(-ca.sin(angle), ca.cos(angle), 0)
    up = ca.vertcat(0, 0, 1)
    first, second = q[f"{arm}_q"], q[f"{arm}_q"] + q[f"{arm}_bend"]
    sway = q[f"{arm}_sway"]
    shoulder = p["base"] * out
    elbow = shoulder + p["l1"] * (ca.cos(first) * out - ca.sin(first) * up)
    along = ca.cos(sway) * (ca.cos(second) * out - ca.sin(second) * up) + ca.sin(sway) * across
    place = ca.vertcat(q["x"], q["y"], q["z"]) + p["tip"] * out
    return shoulder, elbow, elbow + p["l2"] * along, place


def _rod(mass, start, end, q, v):
    """Energies of a thin rod, from the velocities of its ends."""
    a, b = _rate(start, q, v), _rate(end, q, v)
    return mass / 6 * (_squared(a) + ca.dot(a, b) + _squared(b)), mass * 9.81 * (start + end)[2] / 2


def _delta_energies(q, v, p):
    kinetic = _DELTA_PLATFORM / 2 * (v["x"] ** 2 + v["y"] ** 2 + v["z"] ** 2)
    potential = _DELTA_PLATFORM * 9.81 * q["z"]
    for arm in _DELTA_ARMS:
        shoulder, elbow, wrist, _ = _delta_points(q, p, arm)
        for mass, start, end in ((p["m1"], shoulder, elbow), (p["m2"], elbow, wrist)):
            T, V = _rod(mass, start, end, q, v)
            kinetic, potential = kinetic + T, potential + V
    return kinetic, potential


def _delta_closure(q, t, p):
    gaps = {}
    for arm in _DELTA_ARMS:
        *_, wrist, place = _delta_points(q, p, arm)
        gaps |= {f"{arm}_closes_{axis}": (wrist - place)[i] for i, axis in enumerate("xyz")}
    return gaps


# --- bead on a wire --------------------------------------------------------

_STEEP = 0.8


def _bead_energies(q, v, p):
    return p["m"] / 2 * (v["x"] ** 2 + v["y"] ** 2), p["m"] * p["g"] * q["y"]


def _bead_wire(q, t, p):
    return {"wire": q["y"] - _STEEP * q["x"] ** 2}


def _bead_rubbing(q, v, p):
    """Against the velocity; as large as mu times the force across the wire, less where it creeps."""
    speed = ca.sqrt(v["x"] ** 2 + v["y"] ** 2)
    normal = ca.sqrt(1 + (2 * _STEEP * q["x"]) ** 2)
    size = p["mu"] * normal * ca.tanh(speed / p["v_s"])
    return {name: -size * rate / speed for name, rate in v.items()}


# --- Wheelbot --------------------------------------------------------------

def _turn(axis, angle):
    """Rotation matrix about a coordinate axis."""
    c, s = ca.cos(angle), ca.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = ca.SX.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def _rotational(R, inertia, q, v):
    """Kinetic energy of turning: `w = vee(R' dR/dt)`, along the body's axes."""
    names = list(q)
    positions = ca.vertcat(*[q[k] for k in names])
    rates = ca.vertcat(*[v[k] for k in names])
    rate = ca.reshape(ca.mtimes(ca.jacobian(ca.vec(R), positions), rates), 3, 3)
    skew = ca.mtimes(R.T, rate)
    w = ca.vertcat(skew[2, 1], skew[0, 2], skew[1, 0])
    return sum(inertia[i] * w[i] ** 2 for i in range(3)) / 2


def _wheelbot_energies(q, v, p):
    upright = ca.mtimes(_turn(2, q["yaw"]), _turn(0, q["roll"]))
    chassis = ca.mtimes(upright, _turn(1, q["pitch"]))
    hub = ca.vertcat(q["x"], q["y"], 0) + p["r_w"] * upright[:, 2]
    body = hub + ca.mtimes(chassis, ca.vertcat(p["b_x"], p["b_y"], p["l_wb"]))
    top = hub + (p["l_wb"] + p["l_br"]) * chassis[:, 2]
    parts = ((p["m_w"], hub, ca.mtimes(upright, _turn(1, q["wheel"])), (p["I_w_r"], p["I_w_a"], p["I_w_r"])),
             (p["m_b"], body, chassis, (p["I_bx"], p["I_by"], p["I_bz"])),
             (p["m_r"], top, ca.mtimes(chassis, _turn(0, q["reaction"])), (p["I_r_a"], p["I_r_r"], p["I_r_r"])))
    kinetic = sum(m / 2 * _squared(_rate(place, q, v)) + _rotational(R, inertia, q, v)
                  for m, place, R, inertia in parts)
    return kinetic, p["g"] * sum(m * place[2] for m, place, _, _ in parts)


def _wheelbot_rolling(q, v, t, p):
    speed = p["r_w"] * v["wheel"]
    return {"rolling_x": v["x"] - speed * ca.cos(q["yaw"]), "rolling_y": v["y"] - speed * ca.sin(q["yaw"])}


_DUFFING_FREE = {"m1": 2.0, "m2": 1.0, "k1": 10.0, "k2": 12.0, "c1": 0.1, "c2": 0.15,
                 "k1nl": 1.0, "k2nl": 2.0}
_DUFFING_CONSTRAINED = {"m1": 2.0, "m2": 1.2, "k1": 9.0, "k2": 11.0, "c1": 0.12, "c2": 0.1,
                        "k1nl": 1.5, "k2nl": 2.0, "p1": 0.25, "p2": 0.15, "p3": 4.4}

MODELS = (
    Model("surface_particle", ("x", "y", "z"), ("x", "y", "z"),
          {"m": 3.0, "p1": 0.08, "p2": 0.05, "p3": 0.05, "p4": 0.1, "p5": 3.0, "g": 9.81},
          _particle_energies, _along, holonomic=_particle_surface),
    Model("unicycle2d", ("x", "y", "theta"), ("drive", "turn"),
          {"m": 4.0, "R": 0.06, "I_G": 0.09},
          _unicycle_energies, _unicycle_power, nonholonomic=_unicycle_slip,
          scale={"theta": 3.1}),
    Model("duffing_free", ("x1", "x2"), ("x1", "x2"), _DUFFING_FREE,
          _duffing_energies, _along, rayleigh=_duffing_rayleigh),
    Model("duffing_constrained", ("x1", "x2"), ("x1", "x2"), _DUFFING_CONSTRAINED,
          _duffing_energies, _along, rayleigh=_duffing_rayleigh, holonomic=_duffing_control),
    Model("pendulum", ("j1",), ("j1",), {"m": 0.8, "l": 0.3, "I": 0.02, "g": 9.81},
          _pendulum_energies, _along, scale={"j1": 3.1}),
    Model("pendulum2", ("j1", "j2"), ("j1", "j2"),
          {"m1": 1.2, "l1": 0.45, "lc1": 0.22, "I1": 0.024,
           "m2": 0.8, "l2": 0.4, "lc2": 0.19, "I2": 0.012, "g": 9.81},
          _pendulum2_energies, _along, scale={"j1": 3.1, "j2": 3.1}),
    Model("cartpole", ("x", "theta"), ("x",),
          {"mc": 1.2, "mp": 0.25, "l": 0.3, "I": 0.0075, "g": 9.81},
          _cartpole_energies, _along, scale={"theta": 3.1}),
    Model("fourbar", ("j1", "j2", "j3"), ("j1",),
          {"m1": 0.6, "L1": 0.16, "lc1": 0.07, "I1": 0.002,
           "m2": 1.0, "L2": 0.42, "lc2": 0.2, "I2": 0.015,
           "m3": 0.9, "L3": 0.36, "lc3": 0.17, "I3": 0.01, "d": 0.42, "g": 9.81},
          _fourbar_energies, _along, holonomic=_fourbar_closure,
          scale={"j1": 3.1, "j2": 3.1, "j3": 3.1}),
    Model("delta",
          ("x", "y", "z", *(f"{arm}_{k}" for arm in _DELTA_ARMS for k in ("q", "bend", "sway"))),
          tuple(f"{arm}_q" for arm in _DELTA_ARMS),
          {"base": 0.2, "tip": 0.05, "l1": 0.25, "l2": 0.6, "m1": 0.4, "m2": 0.1},
          _delta_energies, _along, holonomic=_delta_closure, cases=10),
    Model("bead", ("x", "y"), ("pull",),
          {"m": 0.2, "mu": 0.3, "v_s": 0.05, "tau": 0.015, "slow": 0.04, "g": 9.81},
          _bead_energies, lambda q, v, u: 0, holonomic=_bead_wire,
          states=("delivered",), late=("pull",),
          rates=lambda z, late, p: {"delivered": (late["pull"] - z["delivered"]) / p["slow"]},
          stored_power=lambda v, z: z["delivered"] * v["x"], rubbing=_bead_rubbing),
)

_WHEELBOT = Model(
    "wheelbot", ("x", "y", "roll", "pitch", "yaw", "wheel", "reaction"), ("reaction", "wheel"),
    {"m_w": 0.3, "m_b": 0.75, "m_r": 0.3, "I_w_r": 0.000259, "I_w_a": 0.000503, "I_bx": 0.001746,
     "I_by": 0.00181, "I_bz": 0.001585, "I_r_a": 0.000503, "I_r_r": 0.000259, "r_w": 0.053,
     "l_wb": 0.055, "l_br": 0.055, "b_x": 0.0, "b_y": 0.0, "g": 9.81},
    _wheelbot_energies,
    lambda q, v, u: u["wheel"] * (v["wheel"] - v["pitch"]) + u["reaction"] * v["reaction"],
    nonholonomic=_wheelbot_rolling, scale={"yaw": 3.1, "wheel": 3.1, "reaction": 3.1})

# whose linearisations are stored
LINEARISED = (*(m for m in MODELS if m.name in ("cartpole", "fourbar", "unicycle2d", "bead")), _WHEELBOT)
