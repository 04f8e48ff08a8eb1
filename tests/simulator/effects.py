"""Effects a machine may have and its nominal model lacks: numbers, places, formulas.

Every effect has one strength s that scales it from nothing (s = 0); its shape
(Stribeck speed, period, sign ...) is drawn once and stays.
"""

from dataclasses import dataclass, field

import numpy as np

import plant
from systems import rounded

LIBRARY = "library"
OUTSIDE = "outside"


@dataclass(frozen=True)
class Kind:
    """One effect type. `numbers(s, shape, ref)` are its parameters by name."""

    name: str
    code: int
    family: str
    formula: str
    numbers: object
    largest: float = 0.8
    source: str = LIBRARY
    first: float = 0.15
    """Strength tried first."""


def _sign(shape):
    return 1.0 if shape[0] < 0.5 else -1.0


def _smooth(shape, ref, low=0.02, high=0.05):
    """Width of the smooth sign: a fraction of the typical speed, or what the machine is given."""
    if ref.get("width") is not None:
        return ref["width"]
    return (low + (high - low) * shape[1]) * ref["V"]


def _wave(shape, ref):
    """Spatial frequency: 4 to 9 per turn of a joint, or per 0.3 to 0.8 strokes of a slider."""
    if ref["angular"]:
        return float(4 + int(6 * shape[2]))
    return 2 * np.pi / (ref["X"] * (0.6 + shape[2]))


def _payload(s, shape, ref):
    found = {"m_add": s * ref["mass"], "L_add": (0.5 + 0.5 * shape[0]) * ref["length"]}
    if ref["planar"]:
        return {"m_add": found["m_add"], "x_add": (2 * shape[0] - 1) * 0.15, "y_add": (2 * shape[1] - 1) * 0.15}
    return found


def _lugre(s, shape, ref):
    return {"Fc": s * ref["F"], "d": 0.1 * s * ref["F"] / ref["V"],
            "reach": min(max((0.03 + 0.05 * shape[0]) * ref["X"], 2e-3), 0.25), "rise": 0.4 + 0.8 * shape[1],
            "vst": min(max((0.2 + 0.2 * shape[2]) * ref["V"], 0.02), 0.9)}


def _com_offset(s, shape, ref):
    way = 2 * np.pi * shape[0]
    return {"x": 0.5 * s * ref["length"] * np.cos(way), "y": 0.5 * s * ref["length"] * np.sin(way)}


def _bouc_wen(s, shape, ref):
    reach = (0.15 + 0.15 * shape[0]) * ref["X"]
    return {"k": s * ref["F"] / reach, "A": 1.0, "beta": 0.67 / reach, "gamma": 0.33 / reach}


KINDS = {k.name: k for k in (
    Kind("viscous", plant.VISCOUS, "force", "Q[coord] += -d * dq[coord]",
         lambda s, w, r: {"d": s * r["F"] / r["V"]}),
    Kind("coulomb", plant.COULOMB, "force", "Q[coord] += -Fc * tanh(dq[coord]/vs)",
         lambda s, w, r: {"Fc": s * r["F"], "vs": _smooth(w, r)}),
    Kind("asymmetric_coulomb", plant.ASYMMETRIC_COULOMB, "force",
         "Q[coord] += -s * (Fp (1+s) + Fm (1-s)) / 2, s = tanh(dq[coord]/vs)",
         lambda s, w, r: {"Fp": s * r["F"] * (1 + 0.5 * _sign(w)), "Fm": s * r["F"] * (1 - 0.5 * _sign(w)),
                          "vs": _smooth(w, r)}),
    Kind("stribeck", plant.STRIBECK, "force",
         "Q[coord] += -(Fc + (Fs-Fc)*exp(-(dq/vst)^2)) * tanh(dq/vs) - d*dq   (dq = dq[coord])",
         lambda s, w, r: {"Fc": s * r["F"], "Fs": s * r["F"] * (1.8 + w[0]),
                          "vst": (0.2 + 0.2 * w[2]) * r["V"], "vs": _smooth(w, r),
                          "d": 0.1 * s * r["F"] / r["V"]}),
    Kind("quadratic_drag", plant.QUADRATIC_DRAG, "force", "Q[coord] += -c * |dq[coord]| * dq[coord]",
         lambda s, w, r: {"c": s * r["F"] / r["V"]**2}),
    Kind("speed_drag", plant.SPEED_DRAG, "force",
         "Q += -c * |v| * v over the translations (x, y or x, y, z)",
         lambda s, w, r: {"c": s * r["F"] / r["V"]**2}),
    Kind("constant_force", plant.CONSTANT_FORCE, "force", "Q[coord] += f",
         lambda s, w, r: {"f": _sign(w) * s * r["F"]}),
    Kind("spring", plant.SPRING, "force", "Q[coord] += -k * (q[coord] - q0)",
         lambda s, w, r: {"k": s * r["F"] / r["X"], "q0": r["mean"] + (w[0] - 0.5) * 0.6 * r["X"]}),
    Kind("cubic_spring", plant.CUBIC_SPRING, "force", "Q[coord] += -k3 * (q[coord] - q0)^3",
         lambda s, w, r: {"k3": s * r["F"] / r["X"]**3, "q0": r["mean"]}),
    Kind("cogging", plant.COGGING, "force", "Q[coord] += -amp * sin(n * q[coord] + phase)",
         lambda s, w, r: {"amp": s * r["F"], "n": _wave(w, r), "phase": 6.28 * w[0]}),
    Kind("load_friction", plant.LOAD_FRICTION, "force",
         "Q[coord] += -mu * |u_act[coord]| * tanh(dq[coord]/vs)   (load = acting drive torque)",
         lambda s, w, r: {"mu": s, "vs": _smooth(w, r)}, 0.4),
    Kind("lugre", plant.LUGRE, "memory",
         "zdot = (dq - |dq| z / (1 + rise * exp(-(dq/vst)^2))) / reach ;  Q[coord] += -Fc * z - d * dq ; z(0)=0",
         _lugre),
    Kind("rolling_resistance", plant.ROLLING_RESISTANCE, "force",
         "Q += -f * tanh(|v|/vs) * v/|v| over the translations (x, y or x, y, z)",
         lambda s, w, r: {"f": s * r["F"], "vs": _smooth(w, r)}),
    Kind("contact_friction", plant.CONTACT_FRICTION, "force",
         "tangential force at the contact: F = -mu * |N| * tanh(|v|/vs) * v/|v|, N = |lam| * ||A||",
         lambda s, w, r: {"mu": s, "vs": _smooth(w, r)}, 0.5, first=0.05),
    Kind("armature", plant.ARMATURE, "inertia", "M[coord][coord] += Ia",
         lambda s, w, r: {"Ia": s * r["M"]}),
    Kind("payload", plant.PAYLOAD, "inertia",
         "point mass m_add on the link (pole) at distance L_add from its proximal joint; "
         "unicycle: at (x_add, y_add) ahead and left of C", _payload),
    Kind("com_offset", plant.COM_OFFSET, "inertia",
         "the link's centre of mass is x further along the link and y across it (counter-clockwise)", _com_offset),
    Kind("joint_coupling", plant.JOINT_COUPLING, "coupling",
         "w = dq[a] + dq[b] ;  T += I w^2 / 2 ;  Q[a], Q[b] += -d * w - Fc * tanh(w/vs)",
         lambda s, w, r: {"I": 0.3 * s * r["M"], "d": 0.3 * s * r["F"] / r["V"], "Fc": s * r["F"], "vs": _smooth(w, r)}),
    Kind("gravity_tilt", plant.GRAVITY_TILT, "gravity", "gravity is turned by delta, counter-clockwise",
         lambda s, w, r: {"delta": 0.3 * s * _sign(w)}),
    Kind("input_gain", plant.INPUT_GAIN, "input", "u_act[input] = c * u[input]",
         lambda s, w, r: {"c": 1 - _sign(w) * s}, 0.5),
    Kind("input_bias", plant.INPUT_BIAS, "input", "u_act[input] = u[input] + u0",
         lambda s, w, r: {"u0": _sign(w) * s * r["U"]}),
    Kind("input_delay", plant.INPUT_DELAY, "input",
         "u_act(t) = u(t - tau) for each listed input; u_act = u(0) for t < tau",
         lambda s, w, r: {"tau": 0.1 * s}, 0.8, first=0.25),
    Kind("input_lag", plant.INPUT_LAG, "input",
         "T * du_act/dt = u - u_act for each listed input; u_act(0) = u(0)",
         lambda s, w, r: {"T": 0.1 * s}, 0.8, first=0.25),
    Kind("dead_band", plant.DEAD_BAND, "input",
         "u_act[input] = 0 where |u| < w, else u - w * sign(u)", lambda s, w, r: {"w": s * r["U"]}),
    Kind("saturation", plant.SATURATION, "input", "u_act[input] = clip(u, -u_max, u_max)",
         lambda s, w, r: {"u_max": r["U"] * 2.2 / (1 + 2 * s)}, 1.5, first=0.5),
    Kind("backlash", plant.BACKLASH, "input",
         "u_act stays while u moves within w of it, else follows at that distance; u_act(0) = u(0)",
         lambda s, w, r: {"w": s * r["U"]}),
    Kind("measurement_offset", -1, "sensor", "q_logged = q + offset",
         lambda s, w, r: {"offset": s * r["X"] * _sign(w)}),
    Kind("measurement_scale", -1, "sensor", "q_logged = scale * q, dq and ddq alike",
         lambda s, w, r: {"scale": 1 + 0.3 * s * _sign(w)}),
    Kind("time_shift", -1, "sensor", "q_logged(t) = q(t - tau), dq and ddq alike",
         lambda s, w, r: {"tau": 0.05 * s * _sign(w)}),
    Kind("bouc_wen", plant.BOUC_WEN, "force",
         "zdot = A*dq - beta*|dq|*z - gamma*dq*|z| ;  Q[coord] += -k*z ; z(0)=0   (dq = dq[coord])",
         _bouc_wen, source=OUTSIDE),
    Kind("dahl", plant.DAHL, "force",
         "Fdot = sigma * (dq - |dq| * F / Fc) ;  Q[coord] += -F ; F(0)=0   (dq = dq[coord])",
         lambda s, w, r: {"Fc": s * r["F"], "sigma": s * r["F"] / ((0.12 + 0.1 * w[0]) * r["X"])},
         source=OUTSIDE),
    Kind("position_viscous", plant.POSITION_VISCOUS, "force",
         "Q[coord] += -d * (1 + sin(n * q[coord] + phase)) * dq[coord]",
         lambda s, w, r: {"d": s * r["F"] / r["V"], "n": 3.0 if r["angular"] else np.pi / r["X"],
                          "phase": 6.28 * w[0]}, source=OUTSIDE),
    Kind("parameter", -1, "parameter", "the parameter's true value differs from the nominal one",
         lambda s, w, r: {}, 0.4, first=0.1),
)}

# families of which a log's states and inputs tell the force, without a state that is hidden
ALONG_A_LOG = ("force", "inertia", "coupling", "gravity", "input", "parameter")


@dataclass
class Effect:
    """An effect at a place. `where` is a coordinate, link or input number, or a parameter's name."""

    kind: Kind
    where: object
    on: list
    shape: np.ndarray
    strength: float
    ref: dict = field(default_factory=dict)

    def parameters(self):
        """Its numbers by name, rounded to four significant digits."""
        found = self.kind.numbers(self.strength, self.shape, self.ref)
        return {k: rounded(x, 4) for k, x in found.items()}

    def wrong_value(self, nominal):
        """True value of a wrong parameter."""
        return rounded(nominal * (1 + _sign(self.shape) * self.strength), 4)

    def records(self):
        """Rows (kind, target, six numbers) for plant.py."""
        if self.kind.family in ("parameter", "sensor"):
            return []
        numbers = list(self.parameters().values())
        numbers += [0.0] * (6 - len(numbers))
        targets = self.where if isinstance(self.where, tuple) else (self.where,)
        return [(self.kind.code, target, numbers) for target in targets]


# two of a group at one place are one effect to any observer
ALIKE = (
    {"coulomb", "asymmetric_coulomb", "stribeck", "load_friction", "lugre"},
    {"viscous", "quadratic_drag", "speed_drag", "stribeck", "lugre"},
    {"spring", "cubic_spring"},
    {"spring", "constant_force", "input_bias"},
    {"constant_force", "input_bias", "asymmetric_coulomb"},
    {"payload", "com_offset"},
    {"speed_drag", "rolling_resistance"},
    {"input_delay", "input_lag", "time_shift"},
    {"input_gain", "dead_band", "saturation", "backlash"},
)


def nested(system, one, other):
    """Whether two effects at the same place cannot be told apart by their kind."""
    ideal_link = system.name == "duffing" and system.constraints  # only the sum of forces shows
    # what has no place, such as a tilt of gravity, is where its like is
    apart = list(one.on) != list(other.on) and not set(one.on) & set(other.on)
    if apart and not ideal_link:
        return False
    names = {one.kind.name, other.kind.name}
    return len(names) == 1 or any(names <= group for group in ALIKE)


def encode(effects):
    """Effect records as the three arrays plant.py takes."""
    rows = [row for e in effects for row in e.records()]
    return (np.array([r[0] for r in rows], dtype=np.int64), np.array([r[1] for r in rows], dtype=np.int64),
            np.array([r[2] for r in rows], dtype=float).reshape(len(rows), 6))


def places(system, name):
    """All places (where, names) at which an effect can sit in a system; empty if none."""
    coordinates = [(i, [c]) for i, c in enumerate(system.coords)]
    inputs = [(j, [u]) for j, u in enumerate(system.inputs)]
    joints = coordinates
    if system.name == "surface_particle":
        joints = coordinates[:2]
    elif system.name == "unicycle2d":
        joints = coordinates[2:]
    if name == "parameter":
        return [(p, [p]) for p in system.wrong]
    if name in ("input_delay", "input_lag") and len(inputs) > 1:
        return inputs + [(tuple(range(len(inputs))), list(system.inputs))]
    if KINDS[name].family == "input":
        return inputs
    if name == "gravity_tilt":
        return [(0, [])] if system.code in (plant.CHAIN, plant.CARTPOLE) else []
    if name == "joint_coupling":
        pairs = zip(system.coords, system.coords[1:])
        return [(i, [a, b]) for i, (a, b) in enumerate(pairs)] if system.name in ("pendulum2", "planar_arm") else []
    if name == "com_offset":
        return [(i, [f"link{i + 1}"]) for i in range(system.links)] if system.name in ("pendulum2", "planar_arm") else []
    if KINDS[name].family == "sensor":
        return coordinates
    if name in ("speed_drag", "rolling_resistance"):
        return [(0, list(system.coords[:2 if system.name == "unicycle2d" else 3]))] \
            if system.name in ("unicycle2d", "surface_particle") else []
    if name == "contact_friction":
        return [(0, ["surface"])] if system.name == "surface_particle" else []
    if name == "cogging":
        return [c for c in joints if c[0] in system.driven and system.name not in ("surface_particle", "unicycle2d")]
    if name == "load_friction":
        return [c for c in joints if c[0] in system.driven
                and system.name in ("pendulum", "pendulum2", "planar_arm", "cartpole", "fourbar")]
    if name == "armature":
        return [c for c in joints if c[0] in system.driven] if system.name in ("pendulum2", "planar_arm") else []
    if name == "payload":
        if system.name in ("pendulum2", "planar_arm", "fourbar"):
            return [(i, [f"link{i + 1}"]) for i in range(1 if system.name == "fourbar" else 0, system.links)]
        return [(0, ["pole" if system.name == "cartpole" else "body"])] \
            if system.name in ("cartpole", "unicycle2d") else []
    return joints
