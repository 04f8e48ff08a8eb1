"""What inertial sensors and encoders show of a motion in a vertical plane: logs without coordinates.

Closed forms: a link turned by phi (absolute) whose joint accelerates by (ax, ay) shows, at a
distance r along it, the turning rate w = dphi/dt and along its own axes the acceleration of
that point, r (dw/dt) across and -r w^2 along, less that of gravity.
"""

from dataclasses import dataclass

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


def draw(machine, rng):
    """A random suite for a machine."""
    steps = 2 * np.pi / 2**int(rng.choice([12, 13, 14]))
    return Suite(float(rng.choice(LEVELS)), machine.rate // int(rng.choice([1, 2, 5])), float(steps))


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
        rate, along, across = felt(machine, run, body, r)
        for axis, values, sd in ((f"{name}_gyro_z", rate, GYRO), (f"{name}_felt_x", along, ACCELEROMETER),
                                 (f"{name}_felt_y", across, ACCELEROMETER)):
            names.append(axis)
            columns.append(values + suite.level * sd * rng.standard_normal(len(values)))
    if machine.system.name == "cartpole":
        turned = np.round(run.q[:, 0] / WHEEL / suite.steps) * suite.steps
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
