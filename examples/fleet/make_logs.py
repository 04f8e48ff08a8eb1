"""Makes the logs of a fleet of pendulums with faults that are known: `python make_logs.py FOLDER`.

The folder gets a log per machine and month, `arm03_2024-05.csv`, and `truth.json`, which nothing
but the tests reads. The machines are moved by the equation below and share no code with what traces
them:

    (I + m l²) q̈ = u − m g l sin q − d q̇ − f tanh(q̇ / 0.02 rad/s) − k q
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# The pendulum of `models/pendulum.model`: kg, m, kg m², m/s².
MASS, LENGTH, INERTIA, GRAVITY = 0.5, 0.5, 0.01, 9.81
RATE, DURATION, STEPS = 100, 8.0, 20  # samples/s, s, steps of the integrator per sample
NOISE_OF_ANGLE, NOISE_OF_SPEED = 1e-4, 2e-3

# One fault per machine; the head of the list has every kind, for small fleets. `worn` is viscous
# friction that grows.
KINDS = ["none", "viscous", "worn", "coulomb", "spring"] * 3
KINDS += ["none", "viscous", "coulomb", "none", "none"] * 2


@dataclass
class Machine:
    """A machine: its fault, and how large that is, month by month.

    Attributes:
        name: what its logs begin with.
        effect: the law that the model lacks, as the library calls it; `none` if none.
        viscous, coulomb, spring: its numbers [N m s/rad, N m, N m/rad], one per month.
        drifts: whether these change over the months.
        odd: months in which the machine was not as it is.
    """

    name: str
    effect: str
    viscous: Array
    coulomb: Array
    spring: Array
    drifts: bool = False
    odd: list[int] = field(default_factory=list)


def machines(count: int, months: int, rng: np.random.Generator) -> list[Machine]:
    """Machines with faults of random size at random places of the list."""
    kinds = rng.permutation([KINDS[k % len(KINDS)] for k in range(count)])
    fleet = []
    for number, kind in enumerate(kinds):
        nothing = np.zeros(months)
        one = Machine(f"arm{number + 1:02}", kind, nothing.copy(), nothing.copy(), nothing.copy())
        if kind == "viscous":
            one.viscous += rng.uniform(0.04, 0.08)
        elif kind == "worn":
            one.effect, one.drifts = "viscous", True
            one.viscous += np.linspace(0.03, rng.uniform(0.08, 0.12), months)
        elif kind == "coulomb":
            one.coulomb += rng.uniform(0.06, 0.12)
        elif kind == "spring":
            one.spring += rng.uniform(0.2, 0.4)
        fleet.append(one)
    sound = next(one for one in fleet if one.effect == "none")
    damped = next(one for one in fleet if one.effect == "viscous" and not one.drifts)
    sound.odd, damped.odd = [months // 3], [months // 2]
    sound.coulomb[sound.odd] = 0.15  # A brake that drags.
    damped.viscous[damped.odd] *= 3  # Cold grease.
    return fleet


def excitation(count: int, rng: np.random.Generator) -> Array:
    """Torques at the samples, a sum of six sines per log: shape (samples, count), N m."""
    t = np.arange(round(DURATION * RATE) + 1)[:, None] / RATE
    torques = np.zeros((len(t), count))
    for _ in range(6):
        frequency, phase = rng.uniform(0.2, 2.5, count), rng.uniform(0, 2 * np.pi, count)
        torques += rng.uniform(0.2, 0.6, count) * np.sin(2 * np.pi * frequency * t + phase)
    return torques


def motion(u: Array, viscous: Array, coulomb: Array, spring: Array) -> tuple[Array, Array]:
    """Angles and speeds of all logs at once, by RK4 with torques straight between samples."""

    def acceleration(q: Array, v: Array, torque: Array) -> Array:
        friction = viscous * v + coulomb * np.tanh(v / 0.02)
        force = torque - MASS * GRAVITY * LENGTH * np.sin(q) - friction - spring * q
        return force / (INERTIA + MASS * LENGTH**2)

    h = 1 / (RATE * STEPS)
    angles, speeds = np.zeros_like(u), np.zeros_like(u)
    q, v = angles[0].copy(), speeds[0].copy()
    for k in range(len(u) - 1):
        slope = (u[k + 1] - u[k]) / STEPS
        for step in range(STEPS):
            now = u[k] + step * slope
            v1, a1 = v, acceleration(q, v, now)
            v2 = v + h / 2 * a1
            a2 = acceleration(q + h / 2 * v1, v2, now + slope / 2)
            v3 = v + h / 2 * a2
            a3 = acceleration(q + h / 2 * v2, v3, now + slope / 2)
            v4 = v + h * a3
            a4 = acceleration(q + h * v3, v4, now + slope)
            q = q + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
            v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        angles[k + 1], speeds[k + 1] = q, v
    return angles, speeds


def date(month: int) -> str:
    """A month, counted from the first, as in the names of logs."""
    return f"{2024 + month // 12}-{month % 12 + 1:02}"


def spoil(paths: list[Path]) -> dict[str, str]:
    """Makes three logs what no program can use; what was done, by the log's name."""
    done = {}
    for path, what in zip(paths, ["empty", "cut", "no log at all"], strict=True):
        text = {"empty": "", "cut": path.read_text()[:300], "no log at all": "<html>404</html>\n"}
        path.write_text(text[what])
        done[path.stem] = what
    return done


def main() -> None:
    """Writes the logs and the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--machines", type=int, default=25)
    parser.add_argument("--months", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng = np.random.default_rng(given.seed)
    fleet = machines(given.machines, given.months, rng)
    u = excitation(given.machines * given.months, rng)
    numbers = [[one.viscous, one.coulomb, one.spring] for one in fleet]
    viscous, coulomb, spring = (np.concatenate(column) for column in zip(*numbers, strict=True))
    q, v = motion(u, viscous, coulomb, spring)
    q += NOISE_OF_ANGLE * rng.standard_normal(q.shape)
    v += NOISE_OF_SPEED * rng.standard_normal(v.shape)

    given.folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number, one in enumerate(fleet):
        for month in range(given.months):
            k = number * given.months + month
            paths.append(given.folder / f"{one.name}_{date(month)}.csv")
            table = np.column_stack([np.arange(len(u)) / RATE, q[:, k], v[:, k], u[:, k]])
            np.savetxt(paths[-1], table, "%.9g", ",", header="t,q_j1,dq_j1,u_j1", comments="")
    ordinary = [p for k, p in enumerate(paths) if k % given.months not in fleet[k // given.months].odd]
    bad = spoil([ordinary[k] for k in rng.choice(len(ordinary), 3, replace=False)])
    truth = {
        "machines": {
            one.name: {
                "effect": one.effect,
                "drifts": one.drifts,
                "odd": [date(month) for month in one.odd],
            }
            for one in fleet
        },
        "bad_logs": bad,
    }
    (given.folder / "truth.json").write_text(json.dumps(truth, indent=2) + "\n")
    print(f"{len(paths)} logs of {len(fleet)} machines in {given.folder}")


if __name__ == "__main__":
    main()
