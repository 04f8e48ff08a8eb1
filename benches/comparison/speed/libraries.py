"""Each library: its program, the states in its own convention, its results in Pinocchio's.

Pinocchio's convention is that of all comparisons: a floating base has its origin and a quaternion (x, y, z, w), its
velocity along its own axes (linear, then angular); bias forces stand on the left; derivatives by positions are along
the velocities.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

FUNCTIONS = {
    "mass": "mass matrix M",
    "bias": "bias force",
    "both": "both",
    "forward": "forward dynamics",
    "inverse_by": "∂ inverse dynamics / ∂(q, v)",
    "forward_by": "∂ forward dynamics / ∂(q, v, u)",
}
DERIVATIVES = ("inverse_by", "forward_by")


def parts(function, n, inputs):
    """Shapes of a function's results, in the order of a program's answer."""
    return {
        "mass": [(n, n)], "bias": [(n,)], "both": [(n, n), (n,)], "forward": [(n,)],
        "inverse_by": [(n, n), (n, n)], "forward_by": [(n,), (n, n), (n, n), (n, inputs)],
    }[function]


def split(numbers, shapes, order="C"):
    """A program's answer as arrays."""
    found, at = [], 0
    for shape in shapes:
        size = int(np.prod(shape))
        found.append(np.reshape(numbers[at:at + size], shape, order=order))
        at += size
    if at != len(numbers):
        raise ValueError(f"{len(numbers)} numbers for results of {at}")
    return found


class Library:
    """What most have in common: Pinocchio's own convention."""

    name = "Pinocchio C++"
    functions = tuple(FUNCTIONS)

    def __init__(self, robot, model):
        self.robot, self.model, self.n = robot, model, model.nv

    def row(self, x):
        """The numbers of a state as the program reads them."""
        return np.concatenate([x.q, x.v, x.tau, x.a])

    def results(self, function, numbers, _):
        """An answer at a state in Pinocchio's convention."""
        return split(numbers, parts(function, self.n, self.n))


class Ours(Library):
    """Our C: nothing but joints has an input, and bias forces stand on the right."""

    name = "ours, C"

    def __init__(self, robot, model):
        super().__init__(robot, model)
        self.undriven = 6 * robot.floats

    def row(self, x):
        return np.concatenate([x.q, x.v, x.tau[self.undriven:], x.a])

    def results(self, function, numbers, _):
        found = split(numbers, parts(function, self.n, self.n - self.undriven))
        if function in ("bias", "both"):
            found[-1] = -found[-1]
        return found


class CasadiC(Library):
    """CasADi's C from Pinocchio's model: columns first."""

    name = "CasADi C from Pinocchio"

    def results(self, function, numbers, _):
        return split(numbers, parts(function, self.n, self.n), order="F")


@dataclass(frozen=True)
class Base:
    """How another library's velocities w of a state belong to Pinocchio's: v = T w, dv/dt = T dw/dt + extra."""

    T: np.ndarray
    extra: np.ndarray

    def results(self, function, found, mass):
        """Mass matrix, bias and acceleration of the other library in Pinocchio's convention."""
        inverse = np.linalg.inv(self.T)
        if function in ("mass", "both"):
            found[0] = inverse.T @ found[0] @ inverse
        if function in ("bias", "both"):
            found[-1] = inverse.T @ found[-1] - mass @ self.extra
        if function == "forward":
            found[0] = self.T @ found[0] + self.extra
        return found


class OtherAxes(Library):
    """A library whose floating base moves along the world's axes, and whose joints may have another order."""

    functions = tuple(f for f in FUNCTIONS if f not in DERIVATIVES)

    def __init__(self, robot, model, joints):
        super().__init__(robot, model)
        first = 2 if robot.floats else 1
        ours = list(model.names)[first:]
        if sorted(joints) != sorted(ours):
            raise ValueError(f"{self.name} has the joints {joints}, Pinocchio {ours}")
        self.order = [ours.index(name) for name in joints]

    def turned(self, x):
        """The base's rotation."""
        return pin.Quaternion(x.q[3:7]).matrix()

    def joints(self, values):
        """The joints' entries of a vector of Pinocchio's, in this library's order."""
        return values[len(values) - len(self.order):][self.order]

    def base(self, x):
        """T and extra at a state."""
        extra, places = np.zeros(self.n), np.eye(len(self.order))[self.order].T
        if not self.robot.floats:
            return Base(places, extra)
        T = np.zeros((self.n, self.n))
        T[:6, :6] = self.base_block(self.turned(x))
        T[6:, 6:] = places
        extra[:3] = -np.cross(x.v[3:6], x.v[:3])
        return Base(T, extra)

    def results(self, function, numbers, x):
        found = split(numbers, parts(function, self.n, self.n), order="F")
        return self.base(x).results(function, found, self.mass(x))

    def mass(self, x):
        """Pinocchio's mass matrix."""
        upper = pin.crba(self.model, self.model.createData(), x.q)
        return np.triu(upper) + np.triu(upper, 1).T


class Mujoco(OtherAxes):
    """MuJoCo: linear velocity along the world's axes, angular along the body's; quaternions w first."""

    name = "MuJoCo"

    def base_block(self, R):
        zero = np.zeros((3, 3))
        return np.block([[R.T, zero], [zero, np.eye(3)]])

    def row(self, x):
        if not self.robot.floats:
            return np.concatenate([self.joints(x.q), self.joints(x.v), self.joints(x.tau)])
        place = np.concatenate([x.q[:3], x.q[[6, 3, 4, 5]]])
        twist = np.linalg.solve(self.base_block(self.turned(x)), x.v[:6])
        return np.concatenate([place, self.joints(x.q), twist, self.joints(x.v), np.zeros(6), self.joints(x.tau)])


class Dynibo(OtherAxes):
    """dynibo: angular, then linear velocity, both along the world's axes; its gravity is fixed."""

    name = "dynibo"
    gravity = 9.80665

    def base_block(self, R):
        zero = np.zeros((3, 3))
        return np.block([[zero, R.T], [R.T, zero]])

    def row(self, x):
        joints = [self.joints(x.q), self.joints(x.v)]
        if not self.robot.floats:
            return np.concatenate([*joints, self.joints(x.tau)])
        twist = np.linalg.solve(self.base_block(self.turned(x)), x.v[:6])
        return np.concatenate([x.q[:7], twist, *joints, np.zeros(6), self.joints(x.tau)])

    def results(self, function, numbers, x):
        found = super().results(function, numbers, x)
        weight = pin.computeGeneralizedGravity(self.model, self.model.createData(), x.q)
        missing = weight * (1 - self.gravity / np.linalg.norm(self.model.gravity.linear))
        if function in ("bias", "both"):
            found[-1] = found[-1] + missing
        if function == "forward":
            found[0] = found[0] - np.linalg.solve(self.mass(x), missing)
        return found
