"""Random open-loop commands and the soft feedback that keeps a machine in range."""

import numpy as np


def scales(system, p, q0, rng):
    """(typical command, centre/stiffness/damping rows) for the driven coordinates."""
    M, _ = system.mass_matrix(p, q0)
    inertia = np.diag(M)[list(system.driven)]
    spread = rng.uniform(-np.pi, np.pi, (64, len(q0)))
    gravity = np.max([np.abs(system.mass_matrix(p, q)[1]) for q in spread], axis=0)[list(system.driven)]
    zero = np.zeros(len(inertia))
    if system.name in ("pendulum", "pendulum2", "planar_arm"):
        return 0.45 * gravity + 4 * inertia, np.array([zero, 4 * inertia, 0.9 * inertia])
    if system.name == "fourbar":
        return 0.35 * gravity, np.array([zero, zero, 0.3 * inertia])
    if system.name == "cartpole":
        return 4 * inertia, np.array([zero, 6 * inertia, 1.0 * inertia])
    if system.name == "surface_particle":
        return inertia * [3, 3, 1.5], np.array([zero, inertia * [4, 4, 0], inertia * [0.5, 0.5, 0]])
    if system.name == "unicycle2d":
        return inertia * [1.5, 3], np.array([zero, inertia * [1, 0], inertia * [0.5, 0.8]])
    return inertia * 3, np.array([zero, zero, 0.1 * inertia])


def _multisine(rng, t):
    count = rng.integers(6, 10)
    frequency = np.exp(rng.uniform(np.log(0.12), np.log(2.5), count))
    amplitude = rng.uniform(0.5, 1, count) / np.sqrt(1 + frequency)
    phase = rng.uniform(0, 2 * np.pi, count)
    wave = (amplitude[:, None] * np.sin(2 * np.pi * frequency[:, None] * t + phase[:, None])).sum(axis=0)
    return wave / np.sqrt((amplitude**2).sum() / 2)


def _chirp(rng, t):
    low, high = rng.uniform(0.1, 0.3), rng.uniform(1.5, 2.5)
    length = t[-1]
    phase = 2 * np.pi * (low * t + (high - low) * t**2 / (2 * length)) + rng.uniform(0, 2 * np.pi)
    return np.sqrt(1.4) * np.sin(phase) + 0.5 * np.sin(2 * np.pi * low * t + rng.uniform(0, 6))


def draw(system, rng, duration, rate, typical, amplitude):
    """(open-loop command, wanted speed), each (samples + 1, inputs)."""
    count = round(duration * rate) + 1
    t = np.arange(count + 1) / rate
    command = np.empty((count + 1, len(system.inputs)))
    for j in range(command.shape[1]):
        shape = _chirp(rng, t) if rng.random() < 0.25 else _multisine(rng, t)
        command[:, j] = amplitude * typical[j] * shape
    speed = np.zeros_like(command)
    if system.name == "fourbar":
        level, swing = rng.uniform(2.5, 5), rng.uniform(0.5, 2)
        speed[:, 0] = level + swing * np.sin(2 * np.pi * rng.uniform(0.1, 0.4) * t)
    return command, speed
