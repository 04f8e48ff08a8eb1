"""The three robots: their files, random states, and Pinocchio's model of them as text."""

import math
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
STATES = 64
SEED = 20261126
NEAR = 1e-9
"""How near 0 or 1 an entry of a rotation is that becomes 0 or 1."""


@dataclass(frozen=True)
class Robot:
    """A robot by name, with its description and whether its base floats."""

    name: str
    urdf: Path
    floats: bool
    title: str

    @property
    def model_file(self):
        """The robot as our program reads it."""
        return HERE / "robots" / f"{self.name}.model"

    def exact(self, folder):
        """A description whose right angles have all digits, for those that do not snap: files write pi/2 as
        1.57079632679, and how far that is off shows beyond the ninth digit of an acceleration."""
        tree, path = xml.parse(self.urdf), folder / f"{self.name}.urdf"
        for origin in tree.iter("origin"):
            angles = [float(x) for x in origin.get("rpy", "0 0 0").split()]
            turns = [round(angle / (math.pi / 2)) * math.pi / 2 for angle in angles]
            angles = [t if abs(t - a) < NEAR else a for t, a in zip(turns, angles)]
            origin.set("rpy", " ".join(map(repr, angles)))
        tree.write(path)
        return path

    def pinocchio(self):
        """Pinocchio's model, its rotations snapped, as ours are."""
        base = (pin.JointModelFreeFlyer(),) if self.floats else ()
        model = pin.buildModelFromUrdf(str(self.urdf), *base)
        for number in range(model.njoints):
            rotation = model.jointPlacements[number].rotation
            whole = np.round(rotation)
            model.jointPlacements[number].rotation = np.where(abs(rotation - whole) < NEAR, whole, rotation)
        return model


ROBOTS = (
    Robot("arm", ROOT / "models/iiwa7.urdf", False, "arm of 7 joints"),
    Robot("quadruped", ROOT / "models/solo12.urdf", True, "quadruped, 12 joints, floating"),
    Robot("humanoid", ROOT / "tests/pinocchio/humanoid.urdf", True, "humanoid, 29 joints, floating"),
)


@dataclass(frozen=True)
class State:
    """Where the robot is evaluated, in Pinocchio's convention; nothing drives the base."""

    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray
    a: np.ndarray


def states(robot, model):
    """64 random states, the same in every run."""
    rng, data = np.random.default_rng([SEED, len(robot.name)]), model.createData()
    found = []
    for _ in range(STATES):
        q = pin.integrate(model, pin.neutral(model), rng.uniform(-1.5, 1.5, model.nv))
        v, a, driven = rng.uniform(-2, 2, (3, model.nv))
        # torques that move every joint alike, however light its link is
        tau = pin.rnea(model, data, q, v, driven).copy()
        tau[:6 * robot.floats] = 0
        found.append(State(q, v, tau, a))
    return found


def as_text(model):
    """Pinocchio's model, one line per joint, for `speed/robot.hpp`."""
    lines = []
    for number in range(1, model.njoints):
        place, body = model.jointPlacements[number], model.inertias[number]
        tensor = body.inertia
        numbers = [*place.rotation.ravel(), *place.translation, body.mass, *body.lever,
                   tensor[0, 0], tensor[0, 1], tensor[1, 1], tensor[0, 2], tensor[1, 2], tensor[2, 2]]
        kind = model.joints[number].shortname()
        lines.append(" ".join([str(model.parents[number]), kind, *(repr(float(x)) for x in numbers)]))
    return "\n".join([*lines, ""])
