"""The eight machines: simulated by tests/simulator, each lacking what its model does not say.

All log positions and inputs alone, with noise. A machine is drawn from its seed, so it is the same in every run. Which of
a seed's machines stands here was settled by its log, before any tool had seen it: the first that shows positions alone
and whose inputs go straight from sample to sample.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SIMULATOR = Path(__file__).resolve().parents[3] / "tests/simulator"
sys.path.insert(0, str(SIMULATOR))

import running  # noqa: E402
import simulate  # noqa: E402
import writing  # noqa: E402

SEED = 2026


@dataclass(frozen=True)
class Choice:
    """A machine of the seed, and what it has that its model lacks."""

    title: str
    system: str
    index: int
    effect: str = ""
    on: str = ""


CHOICES = (
    Choice("double pendulum, nothing", "pendulum2", 5),
    Choice("double pendulum, dry friction", "pendulum2", 5, "coulomb", "j1"),
    Choice("double pendulum, a spring", "pendulum2", 5, "spring", "j1"),
    Choice("cart-pole, late input", "cartpole", 2, "input_delay", "x"),
    Choice("cart-pole, dry friction", "cartpole", 2, "coulomb", "x"),
    Choice("arm of 3, a wrong mass", "planar_arm3", 12, "parameter", "m2"),
    Choice("arm of 3, a rotor", "planar_arm3", 12, "armature", "j2"),
    Choice("arm of 3, cogging", "planar_arm3", 12, "cogging", "j2"),
)


@dataclass
class Machine:
    """A simulated machine with its files."""

    choice: Choice
    folder: Path
    simulated: object
    """The machine of the simulator, which knows the truth."""
    case: object
    """What our program is given."""

    @property
    def system(self):
        """The simulator's system."""
        return self.simulated.system

    @property
    def nominal(self):
        """Parameters as the model has them."""
        return self.simulated.nominal

    def truth(self):
        """What it has that its model lacks, in words."""
        lines = []
        for effect in json.loads((self.folder / "truth.json").read_text())["effects"]:
            numbers = {k: v for k, v in effect["params"].items() if isinstance(v, (int, float))}
            if effect["type"] == "parameter":
                lines.append(f"{effect['on'][0]} is {numbers['true']:g}, not {numbers['nominal']:g}")
            else:
                values = ", ".join(f"{k} {v:g}" for k, v in numbers.items())
                lines.append(f"{effect['type']} on {', '.join(effect['on'])}: {values}")
        return "; ".join(lines) or "nothing"


def make(choice, out):
    """Simulates a machine and writes its logs."""
    given = {choice.effect: [choice.on]} if choice.effect else None
    verdict = {"": "none", "parameter": "parameter"}.get(choice.effect, "effect")
    name, machine, verdict, score = simulate.build(choice.index, SEED, system=choice.system, verdict=verdict, given=given)
    folder = out / f"{name}_{choice.effect or 'nothing'}"
    if machine.columns != ["q", "u"] or not machine.first_order:
        raise ValueError(f"{name} does not log what the comparison is about")
    writing.write(folder, name, machine, verdict, score, SEED, choice.index)
    return Machine(choice, folder, machine, running.simulated(folder))


@dataclass
class Log:
    """A log: times, positions and inputs of its samples."""

    t: np.ndarray
    q: np.ndarray
    u: np.ndarray


def read(machine, which):
    """`train` or `test` of a machine."""
    path = machine.folder / f"{which}.csv"
    names = path.read_text().splitlines()[0].split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    columns = {prefix: [i for i, name in enumerate(names) if name.startswith(prefix)] for prefix in ("q_", "u_")}
    return Log(table[:, 0], table[:, columns["q_"]], table[:, columns["u_"]])
