"""The simulated systems: names, random nominal parameters, starting states, soft feedback."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import plant

GRAVITY = 9.81
MODELS = Path(__file__).resolve().parents[2] / "models"


def rounded(value, digits=3):
    """To significant digits, so that a parameter reads as a person would write it."""
    return float(f"{value:.{digits}g}")


@dataclass(frozen=True)
class System:
    """What does not depend on the machine's numbers."""

    name: str
    variant: str
    coords: tuple[str, ...]
    inputs: tuple[str, ...]
    code: int
    constraints: int
    driven: tuple[int, ...]
    angular: tuple[bool, ...]
    base: tuple[tuple[str, float], ...]
    wrong: tuple[str, ...]
    """Parameters that may be wrong (those the motion depends on)."""
    links: int = 0

    def sample(self, rng):
        """Nominal parameters, 0.7 to 1.4 times the base values (geometry kept plausible)."""
        found = {}
        for name, value in self.base:
            if name == "g":
                found[name] = GRAVITY
            elif self.name == "fourbar" and name[0] in "Ld":
                found[name] = rounded(value * rng.uniform(0.93, 1.07))
            elif name.startswith("lc"):
                found[name] = rounded(value * rng.uniform(0.85, 1.15))
            elif name.startswith("p"):
                found[name] = rounded(value * rng.uniform(0.8, 1.2))
            else:
                found[name] = rounded(value * rng.uniform(0.7, 1.4))
        return found

    def vector(self, parameters):
        """Parameters in the order `plant.py` expects."""
        p = parameters
        if self.code != plant.CHAIN:
            return np.array([p[name] for name, _ in self.base])
        row = []
        for i in range(1, self.links + 1):
            if self.name == "pendulum":
                row += [p["m"], 2 * p["l"], p["l"], p["I"]]
            else:
                length = p.get(f"l{i}", p.get(f"L{i}"))
                row += [p[f"m{i}"], length, p[f"lc{i}"], p[f"I{i}"]]
        return np.array([*row, p["g"], float(self.name == "fourbar"), p.get("d", 0.0)])

    def nominal_document(self, parameters):
        """The `nominal` object of nominal.json."""
        found = dict(parameters)
        if self.name == "duffing" and self.constraints:
            before = {k: found.pop(k) for k in ("p1", "p2", "p3")}
            found |= {"constrained": 1, **before}
        return found

    def mass_matrix(self, p, q):
        """(M, Q at rest) without effects."""
        n, m = len(self.coords), self.constraints
        M, Q, A = np.zeros((n, n)), np.zeros(n), np.zeros((m, n))
        b, c, rate = np.zeros(m), np.zeros(m), np.zeros(m)
        plant.terms(self.code, p, q, np.zeros(n), 0.0, *no_effects(), M, Q, A, b, c, rate)
        return M, Q

    def start(self, rng, p):
        """A starting state on the constraint (before projection of the velocity)."""
        n = len(self.coords)
        q, v = rng.uniform(-0.5, 0.5, n), rng.uniform(-0.5, 0.5, n)
        if self.name == "fourbar":
            q = _closed_fourbar(p, rng.uniform(-3, 3))
            v = np.zeros(n)
        elif self.name == "unicycle2d":
            q, v = np.array([0, 0, rng.uniform(-1, 1)]), np.zeros(n)
        elif self.name == "surface_particle":
            q[2], v = p[1] * q[0]**2 + p[2] * q[1]**2 + p[3] * q[0] + p[4] * np.cos(p[5] * q[0]), v * 0
        elif self.name == "duffing" and self.constraints:
            q[1], v[1] = q[0], v[0] + p[8] * p[10]
        return q, v


def no_effects():
    """Empty effect records."""
    return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros((0, 6))


def _closed_fourbar(p, crank):
    """Joint angles with the loop closed (upper branch) for a crank angle."""
    l1, l2, l3, d = p[1], p[5], p[9], p[14]
    start = l1 * np.array([np.cos(crank), np.sin(crank)])
    gap = np.array([d, 0]) - start
    distance = np.hypot(*gap)
    inner = np.arccos((l2**2 + distance**2 - l3**2) / (2 * l2 * distance))
    phi2 = np.arctan2(gap[1], gap[0]) + inner
    elbow = start + l2 * np.array([np.cos(phi2), np.sin(phi2)])
    phi3 = np.arctan2(-elbow[1], d - elbow[0])
    return np.array([crank, phi2 - crank, phi3 - phi2])


_DUFFING = (("m1", 2.0), ("m2", 1.1), ("k1", 10.0), ("k2", 12.0), ("c1", 0.11), ("c2", 0.13),
            ("k1nl", 1.3), ("k2nl", 2.0))


def planar_arm(n):
    """A chain of n links in a vertical plane, joint angles relative, zero hanging down."""
    base = []
    for i in range(1, n + 1):
        shrink = 0.8**(i - 1)
        base += [(f"m{i}", 1.8 * shrink), (f"l{i}", 0.4 * shrink), (f"lc{i}", 0.19 * shrink),
                 (f"I{i}", 0.03 * shrink**3)]
    names = tuple(f"j{i}" for i in range(1, n + 1))
    wrong = tuple(name for name, _ in base if name != f"l{n}")
    return System("planar_arm", f"n{n}", names, names, plant.CHAIN, 0, tuple(range(n)), (True,) * n,
                  (*base, ("g", GRAVITY)), wrong, n)


SYSTEMS = {
    "pendulum": System(
        "pendulum", "standard", ("j1",), ("j1",), plant.CHAIN, 0, (0,), (True,),
        (("m", 0.8), ("l", 0.3), ("I", 0.02), ("g", GRAVITY)), ("m", "l", "I"), 1),
    "pendulum2": System(
        "pendulum2", "standard", ("j1", "j2"), ("j1", "j2"), plant.CHAIN, 0, (0, 1), (True, True),
        (("m1", 1.1), ("l1", 0.4), ("lc1", 0.19), ("I1", 0.017), ("m2", 0.7), ("l2", 0.35),
         ("lc2", 0.17), ("I2", 0.009), ("g", GRAVITY)),
        ("m1", "l1", "lc1", "I1", "m2", "lc2", "I2"), 2),
    "cartpole": System(
        "cartpole", "standard", ("x", "theta"), ("x",), plant.CARTPOLE, 0, (0,), (False, True),
        (("mc", 1.0), ("mp", 0.25), ("l", 0.28), ("I", 0.006), ("g", GRAVITY)),
        ("mc", "mp", "l", "I")),
    "surface_particle": System(
        "surface_particle", "standard", ("x", "y", "z"), ("x", "y", "z"), plant.PARTICLE, 1,
        (0, 1, 2), (False,) * 3,
        (("m", 2.5), ("p1", 0.08), ("p2", 0.06), ("p3", 0.05), ("p4", 0.1), ("p5", 3.0),
         ("g", GRAVITY)), ("m", "p1", "p2", "p3", "p4", "p5")),
    "unicycle2d": System(
        "unicycle2d", "standard", ("x", "y", "theta"), ("drive", "turn"), plant.UNICYCLE, 1,
        (0, 2), (False, False, True), (("m", 4.0), ("R", 0.07), ("I_G", 0.09)), ("m", "R", "I_G")),
    "duffing_free": System(
        "duffing", "free", ("x1", "x2"), ("x1", "x2"), plant.DUFFING, 0, (0, 1), (False, False),
        _DUFFING, tuple(name for name, _ in _DUFFING)),
    "duffing_constrained": System(
        "duffing", "constrained", ("x1", "x2"), ("x1", "x2"), plant.DUFFING, 1, (0, 1),
        (False, False), (*_DUFFING, ("p1", 0.25), ("p2", 0.15), ("p3", 4.4)),
        ("m1", "m2", "k2", "k2nl", "c2", "p1", "p2", "p3")),
    "fourbar": System(
        "fourbar", "standard", ("j1", "j2", "j3"), ("j1",), plant.CHAIN, 2, (0,), (True,) * 3,
        (("m1", 0.6), ("L1", 0.16), ("lc1", 0.07), ("I1", 0.002), ("m2", 1.0), ("L2", 0.42),
         ("lc2", 0.2), ("I2", 0.015), ("m3", 0.9), ("L3", 0.36), ("lc3", 0.17), ("I3", 0.01),
         ("d", 0.42), ("g", GRAVITY)),
        ("m1", "L1", "lc1", "I1", "m2", "L2", "lc2", "I2", "m3", "L3", "lc3", "I3", "d"), 3),
    **{f"planar_arm{n}": planar_arm(n) for n in (3, 4, 5)},
}
