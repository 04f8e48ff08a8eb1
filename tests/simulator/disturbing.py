"""What sensors, clocks and drives do beyond white noise: coloured noise, stamps that jitter, wild samples,
noise in the torque column, controllers faster than the log, forces that follow no law."""

from dataclasses import dataclass

import numpy as np

NAMES = ("coloured", "jitter", "outliers", "torque", "faster", "nameless")


@dataclass(frozen=True)
class Disturbance:
    """Zero where there is nothing of a kind."""

    colour: float = 0.0
    """Correlation time of the sensors' noise, s; its standard deviation stays."""
    jitter: float = 0.0
    """How far a sample is early or late at most, in samples; its stamp says so."""
    outliers: float = 0.0
    """Share of the cells that are wild."""
    torque: float = 0.0
    """Noise of each input as it is logged, which the machine never felt, as a share of its root mean
    square."""
    faster: int = 0
    """Samples of the controller from one row of the log to the next, if it has a rate of its own."""
    nameless: tuple = (0.0, 0.0)
    """Forces that follow no law: their size as a share of each coordinate's force, and how long they
    last, s."""

    def truth(self):
        """What truth.json says of it: the names that apply, with their numbers."""
        numbers = dict(zip(NAMES, (self.colour, self.jitter, self.outliers, self.torque, self.faster)))
        found = {name: float(f"{x:.4g}") for name, x in numbers.items() if x}
        if self.nameless[0]:
            found["nameless"] = [float(f"{x:.4g}") for x in self.nameless]
        return found

    def noise(self, white, rate):
        """White noise given this colour: what a first-order lag makes of it, at the same deviation."""
        if not self.colour:
            return white
        kept = np.exp(-1 / (rate * self.colour))
        found = white.copy()
        for k in range(1, len(white)):
            found[k] = kept * found[k - 1] + np.sqrt(1 - kept**2) * white[k]
        return found

    def lateness(self, count, rate, rng):
        """How late each sample is, s, in whole microseconds, as the log writes stamps; the first is not."""
        late = np.round(rng.uniform(-1, 1, count) * self.jitter / rate, 6)
        late[0] = 0
        return late

    def wild(self, rows, rng):
        """(row, column) of the cells that are wild, without the stamps, and what is added to each:
        0.3 to 30 times the spread of its channel."""
        cells = np.argwhere(rng.random(rows[:, 1:].shape) < self.outliers) + [0, 1]
        size = np.exp(rng.uniform(np.log(0.3), np.log(30), len(cells))) * rng.choice([-1, 1], len(cells))
        return cells, size * rows.std(axis=0)[cells[:, 1]]


def draw(names, rng):
    """A disturbance of these kinds: noise that remembers 2 to 30 ms, samples up to a fifth early or late,
    one cell in a hundred wild, torques with 0.3 to 7 % of noise, a controller at 1 kHz beside a log at
    200 to 500 Hz, forces beside all laws of 3 to 20 % that last 10 ms to 1 s."""
    colour, jitter = np.exp(rng.uniform(np.log([2e-3, 0.02]), np.log([3e-2, 0.2])))
    found = {"colour": colour if "coloured" in names else 0.0, "jitter": jitter if "jitter" in names else 0.0,
             "outliers": 0.01 if "outliers" in names else 0.0}
    if "torque" in names:
        found["torque"] = float(np.exp(rng.uniform(np.log(0.003), np.log(0.07))))
    if "faster" in names:
        found["faster"] = int(rng.choice([2, 4, 5]))
    if "nameless" in names:
        found["nameless"] = tuple(np.exp(rng.uniform(np.log([0.03, 0.01]), np.log([0.2, 1.0]))).tolist())
    return Disturbance(**found)
