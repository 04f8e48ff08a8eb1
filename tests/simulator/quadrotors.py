"""Random quadrotors in a vertical plane that see themselves through one inertial sensor.

Each lacks one effect, or nothing: every sixth. They fly along waves in closed loop, and their logs hold the
rotors' commands, a gyroscope and an accelerometer, no position and no angle. A machine is a folder with
sensed.model, train.csv, test.csv, nominal.json and truth.json.

Newton and Euler about the hull's origin, with mass M, centre of mass r and moment J about the origin:

    M (a + dw/dt x r - w^2 r) = F - M g,    J dw/dt + M r x (a + g) = T
"""

import json
from dataclasses import dataclass, field

import numpy as np

from wheelbots import between, either

SECONDS = {"train": 12.0, "test": 8.0}
RATE, STEPS = 100, 10
"""Samples per second; Runge-Kutta steps between them."""
GYRO, ACCELEROMETER = 3e-3, 0.03
"""Noise at the usual level, rad/s and m/s^2."""
CONTROLS_EVERY = 6
"""Of so many machines one is a control."""
GRAVITY = 9.81
MODEL = """\
model quadrotor;
coordinate x: m;
coordinate z: m;
coordinate theta: rad;
input left: N;
input right: N;
parameter m: kg = 0.6 in 0.05..5;
parameter arm: m = 0.18 in 0.02..1;
parameter j: kg*m^2 = 0.008 in 1e-4..1;
parameter drag: N*s/m = 0.35 in 0..5;
body hull {{ frame: translate(x, z, 0) * rotate_z(theta); mass: m; inertia: diag(0, 0, j); }}
gravity (0, -9.81, 0);
force x = -(left + right)*sin(theta) - drag*dot(x);
force z = (left + right)*cos(theta) - drag*dot(z);
force theta = arm*(right - left);
sensor imu_gyro: rad/s = gyroscope(hull);
sensor imu_felt: m/s^2 = accelerometer(hull) {{ rate: {rate}; }}
"""


@dataclass(frozen=True)
class Fault:
    """What a machine has and its model lacks."""

    effect: str = "none"
    on: tuple = ()
    parameters: dict = field(default_factory=dict)
    near: tuple = ()
    """What no log tells from it, as (effect, places)."""
    nominal: dict = field(default_factory=dict)
    """Parameters of the model that the machine has other values of."""
    gain: tuple = (1.0, 1.0)
    lag: tuple = (0.0, 0.0)
    carried: tuple = (0.0, 0.0, 0.0)
    """A load's mass, kg, and place on the hull, m."""
    centre: tuple = (0.0, 0.0)
    wind: float = 0.0
    damping: float = 0.0


def of_rotor(rotor, value, other):
    """A pair with a value for one rotor."""
    return (value, other) if rotor == "left" else (other, value)


def weak_rotor(rng, p):
    rotor, gain = str(rng.choice(["left", "right"])), float(rng.uniform(0.85, 0.96))
    return Fault("input_gain", (rotor,), {"c": gain}, gain=of_rotor(rotor, gain, 1.0))


def slow_rotor(rng, p):
    rotor, lag = str(rng.choice(["left", "right"])), between(rng, 0.02, 0.08)
    return Fault("input_lag", (rotor,), {"tau": lag}, lag=of_rotor(rotor, lag, 0.0))


def other_mass(rng, p):
    mass = p["m"] * float(rng.uniform(0.85, 0.95) if rng.uniform() < 0.5 else rng.uniform(1.05, 1.15))
    return Fault("parameter", ("m",), {"name": "m", "nominal": p["m"], "true": mass}, nominal={"m": mass})


def other_inertia(rng, p):
    inertia = p["j"] * float(rng.uniform(0.75, 0.9) if rng.uniform() < 0.5 else rng.uniform(1.1, 1.3))
    # The torque's arm and the moment of inertia appear as their ratio alone.
    return Fault("parameter", ("j",), {"name": "j", "nominal": p["j"], "true": inertia},
                 (("parameter", ["arm"]), ("armature", ["theta"])), nominal={"j": inertia})


def load(rng, p):
    mass, place = between(rng, 0.03, 0.1), (float(rng.uniform(-0.12, 0.12)), float(rng.uniform(-0.1, -0.02)))
    return Fault("payload", ("hull",), {"m": mass, "x": place[0], "y": place[1]}, carried=(mass, *place))


def off_centre(rng, p):
    offset = either(rng) * between(rng, 0.003, 0.015)
    return Fault("com_offset", ("hull",), {"x": offset, "y": 0.0}, centre=(offset, 0.0))


def wind(rng, p):
    force = either(rng) * between(rng, 0.2, 0.8)
    return Fault("constant_force", ("x",), {"f": force}, wind=force)


def damped(rng, p):
    damping = between(rng, 0.004, 0.02)
    return Fault("viscous", ("theta",), {"d": damping}, damping=damping)


FAULTS = (weak_rotor, slow_rotor, other_mass, other_inertia, load, off_centre, wind, damped)


class Quadrotor:
    """One machine: parameters of its model, and its fault."""

    def __init__(self, nominal, fault):
        p = {**nominal, **fault.nominal}
        extra, *place = fault.carried
        self.fault, self.arm, self.drag = fault, p["arm"], p["drag"]
        self.mass = p["m"] + extra
        centre = np.array(fault.centre)
        self.centre = (p["m"] * centre + extra * np.array(place)) / self.mass
        self.inertia = p["j"] + p["m"] * centre @ centre + extra * float(np.dot(place, place))

    def accelerations(self, x, thrusts):
        """Of x, z and theta at positions, velocities and the rotors' thrusts."""
        angle, (vx, vz, w) = x[2], x[3:6]
        c, s = np.cos(angle), np.sin(angle)
        rx, rz = c * self.centre[0] - s * self.centre[1], s * self.centre[0] + c * self.centre[1]
        left, right = thrusts
        force = np.array([-(left + right) * s - self.drag * vx + self.fault.wind, (left + right) * c - self.drag * vz])
        torque = self.arm * (right - left) - self.fault.damping * w
        m = self.mass
        matrix = np.array([[m, 0, -m * rz], [0, m, m * rx], [-m * rz, m * rx, self.inertia]])
        right_side = np.array([force[0] + m * w * w * rx, force[1] + m * w * w * rz - m * GRAVITY,
                               torque - m * GRAVITY * rx])
        return np.linalg.solve(matrix, right_side)

    def rates(self, x, commands):
        """d/dt of (positions, velocities, thrusts that lag)."""
        lag = np.array(self.fault.lag)
        gain = np.array(self.fault.gain)
        thrusts = np.where(lag > 0, x[6:8], gain * commands)
        slow = np.where(lag > 0, (gain * commands - x[6:8]) / np.where(lag > 0, lag, 1.0), 0.0)
        return np.concatenate([x[3:6], self.accelerations(x, thrusts), slow]), thrusts

    def tick(self, x, begin, end, steps=STEPS):
        """The state a sample later; commands go straight from one to the other."""
        h = 1 / RATE / steps
        at = [begin + (end - begin) * k / (2 * steps) for k in range(2 * steps + 1)]
        for k in range(steps):
            first, middle, last = at[2 * k:2 * k + 3]
            a = self.rates(x, first)[0]
            b = self.rates(x + h / 2 * a, middle)[0]
            c = self.rates(x + h / 2 * b, middle)[0]
            d = self.rates(x + h * c, last)[0]
            x = x + h / 6 * (a + 2 * b + 2 * c + d)
        return x

    def felt(self, x, commands):
        """What a gyroscope and an accelerometer at the hull's origin show."""
        a = self.accelerations(x, self.rates(x, commands)[1])
        c, s = np.cos(x[2]), np.sin(x[2])
        up = a[1] + GRAVITY
        return np.array([x[5], c * a[0] + s * up, -s * a[0] + c * up])


def waves(rng, t, size, slowest, fastest):
    """A sum of three sines."""
    tones, phases = rng.uniform(slowest, fastest, 3), rng.uniform(0, 2 * np.pi, 3)
    return size / np.sqrt(1.5) * np.sin(t[:, None] * tones + phases).sum(axis=1)


def fly(rng, nominal, fault, seconds):
    """(times, commands, readings without noise) of one flight."""
    machine, (m, arm, j) = Quadrotor(nominal, fault), (nominal[name] for name in ("m", "arm", "j"))
    t = np.arange(int(round(seconds * RATE)) + 1) / RATE
    to_x, to_z = waves(rng, t, 1.5, 0.5, 2.5), waves(rng, t, 0.8, 0.5, 2.0)
    shaken = waves(rng, t, 4.0 * j, 6.0, 15.0)
    x = np.zeros(8)
    x[6:8] = m * GRAVITY / 2
    commands, readings = np.zeros((len(t), 2)), np.zeros((len(t), 3))
    before = np.full(2, m * GRAVITY / 2)
    for k in range(len(t)):
        tilt = np.clip((1.5 * x[3] - 2.0 * (to_x[k] - x[0])) / GRAVITY, -0.6, 0.6)
        thrust = m * (GRAVITY + 3.0 * (to_z[k] - x[1]) - 2.5 * x[4]) / max(np.cos(x[2]), 0.5)
        torque = j * (60.0 * (tilt - x[2]) - 12.0 * x[5]) + shaken[k]
        thrust = np.clip(thrust, 0.2 * m * GRAVITY, 2.5 * m * GRAVITY)
        now = np.array([thrust / 2 - torque / (2 * arm), thrust / 2 + torque / (2 * arm)])
        if k:
            x = machine.tick(x, before, now)
        commands[k], before = now, now
        readings[k] = machine.felt(x, now)
    if np.abs(readings[:, 0]).max() > 20 or not np.isfinite(readings).all():
        raise RuntimeError("the quadrotor tumbles")
    return t, commands, readings


def write(path, log, level, every, rng):
    """A flight as its log: accelerometers are read every so many samples."""
    t, commands, readings = log
    noise = level * np.array([GYRO, ACCELEROMETER, ACCELEROMETER])
    readings = readings + noise * rng.standard_normal(readings.shape)
    readings[:, 1:] = readings[np.arange(len(t)) // every * every, 1:]
    np.savetxt(path, np.column_stack([t, commands, readings]), fmt=["%.2f", *["%.7g"] * 5], delimiter=",",
               header="t,u_left,u_right,imu_gyro_z,imu_felt_x,imu_felt_y", comments="")


def make(index, seed, out):
    """Writes one machine; returns a line about it."""
    rng = np.random.default_rng([seed, index])
    nominal = {"m": rng.uniform(0.4, 1.2), "arm": rng.uniform(0.12, 0.25), "drag": rng.uniform(0.1, 0.5)}
    nominal["j"] = nominal["m"] * nominal["arm"]**2 * rng.uniform(0.3, 0.5)
    nominal = {name: float(f"{value:.4g}") for name, value in nominal.items()}
    level, every = float(rng.choice([0.5, 1.0, 2.0])), int(rng.choice([1, 2]))
    fault = FAULTS[rng.integers(len(FAULTS))](rng, nominal) if index % CONTROLS_EVERY else Fault()
    name = f"s{seed}_{index:04d}_quadrotor"
    folder = out / name
    folder.mkdir(parents=True, exist_ok=True)
    for which, seconds in SECONDS.items():
        write(folder / f"{which}.csv", fly(rng, nominal, fault, seconds), level, every, rng)
    (folder / "sensed.model").write_text(MODEL.format(rate=RATE // every))
    (folder / "nominal.json").write_text(json.dumps({"nominal": nominal}, indent=1) + "\n")
    kind = {"none": "none", "parameter": "parameter"}.get(fault.effect, "effect")
    near = [{"type": effect, "on": on, "r2": 1.0} for effect, on in fault.near]
    effects = [{"type": fault.effect, "on": list(fault.on), "params": fault.parameters, "visibility": None,
                "near_equivalents": near}] if fault.effect != "none" else []
    truth = {"id": name, "system": "quadrotor", "class": kind, "effects": effects, "seed": seed, "index": index,
             "noise_level": level, "hold": "foh", "oracle": {"test": {"acc_nrmse_floor": None}}}
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n")
    return f"{name:22s} {fault.effect} on {','.join(fault.on) or '-'}  {fault.parameters or ''}"
