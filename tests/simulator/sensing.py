"""What inertial sensors and encoders show of a motion in a vertical plane: logs without coordinates.

Closed forms: a link turned by phi (absolute) whose joint accelerates by (ax, ay) shows, at a
distance r along it, the turning rate w = dphi/dt and along its own axes the acceleration of
that point, r (dw/dt) across and -r w^2 along, less that of gravity.
"""

from dataclasses import dataclass, field

import numpy as np

import plant

SYSTEMS = ("cartpole", "pendulum2", "fourbar")
"""Systems that sensors are known of."""
TEMPLATES = ("gravity_tilt",)
"""Effects that sensors feel in ways the templates do not say."""
SHARE = 0.6
"""Where on a link its sensor is mounted, as a share of the link's length."""
WHEEL = 0.03
"""Radius of the wheel that turns a cart's encoder, m."""
GYRO, ACCELEROMETER, LEVELS = 3e-3, 0.03, (0.5, 1.0, 2.0)
"""Noise, rad/s and m/s^2, at the usual level, and the levels."""


@dataclass(frozen=True)
class Suite:
    """The sensors of one machine."""

    level: float
    rate: int
    """Of the encoder, readings per second."""
    steps: float
    """Of the encoder, rad."""
    misread: dict = field(default_factory=dict)
    """What one sensor reads wrongly, as an entry of truth.json; empty where all read rightly."""


def draw(machine, rng):
    """A random suite for a machine."""
    steps = 2 * np.pi / 2**int(rng.choice([12, 13, 14]))
    return Suite(float(rng.choice(LEVELS)), machine.rate // int(rng.choice([1, 2, 5])), float(steps))


def draw_misread(machine, rng):
    """An error of one sensor that its log shows: offset, scale, time, or the axes of a board."""
    boards = [name for name, _, _ in mounts(machine)]
    columns = [f"{name}_{part}" for name in boards for part in ("gyro_z", "felt_x", "felt_y")]
    encoders = ["wheel"] if machine.system.name == "cartpole" else []
    kind = str(rng.choice(["measurement_offset", "measurement_scale", "time_shift", "mounting_tilt"]))
    # Nothing tells where a cart's encoder counts from.
    places = {"mounting_tilt": boards, "measurement_offset": columns}.get(kind, columns + encoders)
    place = str(rng.choice(places))
    sign, size = float(rng.choice([-1.0, 1.0])), rng.uniform()
    if kind == "measurement_offset":
        least, most = (0.02, 0.1) if "gyro" in place else (0.1, 0.5)
        params = {"offset": sign * least * (most / least)**size}
    elif kind == "measurement_scale":
        params = {"scale": 1 + sign * (0.03 + 0.07 * size)}
    elif kind == "time_shift":
        # In whole samples, which need no curve between them.
        params = {"tau": sign * int(2 + 4 * size) / machine.rate}
    else:
        params = {"phi_z": sign * (0.03 + 0.12 * size)}
    return {"type": kind, "on": [place], "family": "sensor", "formula": FORMULAS[kind],
            "params": {name: float(f"{value:.4g}") for name, value in params.items()},
            "visibility": None, "near_equivalents": []}


FORMULAS = {
    "measurement_offset": "reading = value + offset",
    "measurement_scale": "reading = scale * value",
    "time_shift": "reading(t) = value(t - tau)",
    "mounting_tilt": "reading along the board's axes turned by phi_z, counter-clockwise",
}
"""What an error of a sensor does."""


def misread(machine, suite, name, values):
    """What a sensor reads whose true values these are, one row per component of a board's accelerometer."""
    found, number = suite.misread, suite.misread.get("params", {})
    if name not in found.get("on", []):
        return values
    if found["type"] == "measurement_offset":
        return values + number["offset"]
    if found["type"] == "measurement_scale":
        return values * number["scale"]
    if found["type"] == "time_shift":
        late = round(number["tau"] * machine.rate)
        return values[np.clip(np.arange(len(values)) - late, 0, len(values) - 1)]
    sin, cos = np.sin(number["phi_z"]), np.cos(number["phi_z"])
    return np.array([[cos, sin], [-sin, cos]]) @ values


def mounts(machine):
    """(name, body, distance along it) of the inertial sensors."""
    p = machine.nominal
    if machine.system.name == "cartpole":
        return [("imu", "pole", round(2 * SHARE * p["l"], 4))]
    letter = "L" if machine.system.name == "fourbar" else "l"
    links = (1, 3) if machine.system.name == "fourbar" else (1, 2)
    return [(f"imu{i}", f"link{i}", round(SHARE * p[f"{letter}{i}"], 4)) for i in links]


def statements(machine, suite):
    """The sensors in the model's language."""
    lines = []
    for name, body, r in mounts(machine):
        lines += [f"frame {name} = {body} * translate({r}, 0, 0);",
                  f"sensor {name}_gyro: rad/s = gyroscope({name});",
                  f"sensor {name}_felt: m/s^2 = accelerometer({name});"]
    if machine.system.name == "cartpole":
        lines += [f"constant wheel_radius: m = {WHEEL};",
                  f"sensor wheel: rad = x/wheel_radius {{ rate: {suite.rate}; }}"]
    return "\n".join([*lines, ""])


def shown(machine, suite, run, rng):
    """(names, columns) of what the sensors show of a run, noise and steps included."""
    names, columns = [], []
    for name, body, r in mounts(machine):
        rate, *pushed = felt(machine, run, body, r)
        along, across = misread(machine, suite, name, np.array(pushed))
        for axis, values, sd in ((f"{name}_gyro_z", rate, GYRO), (f"{name}_felt_x", along, ACCELEROMETER),
                                 (f"{name}_felt_y", across, ACCELEROMETER)):
            names.append(axis)
            values = misread(machine, suite, axis, values)
            columns.append(values + suite.level * sd * rng.standard_normal(len(values)))
    if machine.system.name == "cartpole":
        turned = misread(machine, suite, "wheel", run.q[:, 0] / WHEEL)
        turned = np.round(turned / suite.steps) * suite.steps
        every = machine.rate // suite.rate
        names.append("wheel")
        columns.append(turned[np.arange(len(turned)) // every * every])
    return names, columns


def felt(machine, run, body, r):
    """Turning rate of a body, and what is felt at a distance r along it: along and across."""
    p, g = machine.true_parameters(), machine.true_parameters()["g"]
    count = len(run.q)
    if machine.system.code == plant.CARTPOLE:
        angle, w, dw = run.q[:, 1] - np.pi / 2, run.v[:, 1], run.a[:, 1]
        ax, ay = run.a[:, 0], np.zeros(count)
    else:
        hanging = 0.0 if machine.system.name == "fourbar" else np.pi / 2
        letter = "L" if machine.system.name == "fourbar" else "l"
        ax, ay, w, dw, angle = (np.zeros(count) for _ in range(5))
        angle -= hanging
        for i in range(int(body[-1])):
            if i:
                length = p[f"{letter}{i}"]
                ax = ax - length * (w**2 * np.cos(angle) + dw * np.sin(angle))
                ay = ay - length * (w**2 * np.sin(angle) - dw * np.cos(angle))
            angle, w, dw = angle + run.q[:, i], w + run.v[:, i], dw + run.a[:, i]
    up = ay + g
    along = ax * np.cos(angle) + up * np.sin(angle) - r * w**2
    across = -ax * np.sin(angle) + up * np.cos(angle) + r * dw
    return w, along, across
