"""One random machine: drawn, simulated, calibrated to a wanted visibility, written."""

from dataclasses import dataclass

import numpy as np

import effects as fx
import excitation
import oracle
import plant
import rollout
from disturbing import Disturbance
from systems import no_effects

VISIBLE = 2.0


class Untamed(RuntimeError):
    """No command amplitude keeps the nominal machine in range."""


@dataclass
class Run:
    """A noise-free simulation at the log's samples, with its (fixed) noise draws."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    command: np.ndarray
    acting: np.ndarray
    z: np.ndarray
    multipliers: np.ndarray

    def every(self, count):
        """Every so many samples of it."""
        return Run(*(x[::count] for x in vars(self).values())) if count > 1 else self


def _misread(effect, q, v, a, step):
    """Position, velocity and acceleration of a coordinate as a faulty sensor reads them."""
    x = effect.parameters()
    if effect.kind.name == "measurement_offset":
        return q + x["offset"], v, a
    if effect.kind.name == "measurement_scale":
        return x["scale"] * q, x["scale"] * v, x["scale"] * a
    whole = int(np.floor(-x["tau"] / step))
    s = -x["tau"] / step - whole
    last = len(q) - 1
    here = np.clip(np.arange(len(q)) + whole, 0, last)
    there = np.clip(here + 1, 0, last)

    def between(y, slope):
        """The cubic through both values and slopes."""
        return ((2 * s**3 - 3 * s**2 + 1) * y[here] + (s**3 - 2 * s**2 + s) * step * slope[here]
                + (3 * s**2 - 2 * s**3) * y[there] + (s**3 - s**2) * step * slope[there])

    return between(q, v), between(v, a), (1 - s) * a[here] + s * a[there]


class Machine:
    """A system with nominal numbers, a sensor, two motions and a list of effects."""

    def __init__(self, system, rng, noise_scale=1.0, feedback="true", disturbance=None, width=None):
        self.system, self.rng = system, rng
        self.disturbed, self.disturbance = disturbance is not None, disturbance or Disturbance()
        # A stated width may be narrow: four times the steps, so that the log is that of its numbers.
        self.width, self.finer = width, 1 if width is None else 4
        self.driven = np.array(system.driven, dtype=np.int64)
        self.nominal = system.sample(rng)
        self.rate = int(rng.choice([200, 200, 250]))
        self.first_order = bool(rng.random() < 0.75)
        # What commands the machine, and how many of its samples make one of the log.
        self.faster, self.control_rate = 1, self.rate
        if self.disturbance.faster:
            self.faster, self.control_rate, self.first_order = self.disturbance.faster, 1000, False
            self.rate = self.control_rate // self.faster
        self.columns = [["q", "u"], ["q", "dq", "u"], ["q", "dq", "ddq", "u"]][
            rng.choice(3, p=[0.35, 0.4, 0.25])]
        self.durations = {"train": int(rng.integers(14, 19)), "test": int(rng.integers(9, 13))}
        self._sensor(rng, noise_scale)
        self.effects, self.suite = [], None
        p = system.vector(self.nominal)
        self.start = {k: system.start(rng, p) for k in self.durations}
        self.typical, self.gains = excitation.scales(system, p, self.start["train"][0], rng)
        self._motions(p, feedback)

    def _sensor(self, rng, noise_scale):
        level = noise_scale * rng.choice([0.5, 1.0, 2.0])
        angular = np.array(self.system.angular)
        turn = 2 * np.pi / 2**rng.choice([14, 15, 16])
        self.noise_level = float(level)
        self.quantum = np.where(angular, turn, 5e-5) * (noise_scale > 0)
        self.q_sd = np.where(angular, 2e-4, 1.5e-4) * level
        self.dq_sd = np.where(angular, 0.015, 0.008) * level
        self.ddq_sd = np.where(angular, 0.15, 0.05) * level

    def _motions(self, p, feedback):
        """Command and noise of both logs; the amplitude shrinks until the nominal machine behaves."""
        if self.disturbance.torque or self.disturbance.nameless[0]:
            self.own_seed = int(self.rng.integers(0, 2**63))
        self.force = np.zeros(len(self.system.coords))
        seeds = {k: self.rng.integers(0, 2**63) for k in self.durations}
        for amplitude in 0.85**np.arange(16):
            self.open_loop, self.noise = {}, {}
            for k, duration in self.durations.items():
                rng = np.random.default_rng(seeds[k])
                self.open_loop[k] = excitation.draw(self.system, rng, duration, self.control_rate, self.typical,
                                                    amplitude * (1.0 if k == "train" else 1.1))
                shape = (len(self.open_loop[k][0]) - 1, len(self.system.coords))
                self.noise[k] = {name: self.disturbance.noise(rng.standard_normal(shape) * sd, self.control_rate)
                                 for name, sd in (("q", self.q_sd), ("dq", self.dq_sd), ("ddq", self.ddq_sd))}
            self.seen = feedback == "measured"
            runs = [self.run(k) for k in self.durations]
            if all(self.tame(r, 0.7) for r in runs):
                self._references(p, runs[0])
                return
        raise Untamed(self.system.name)

    def tame(self, run, share=1.0):
        """Whether a run stays within a share of the range a real machine would keep to."""
        speed = np.where(self.system.angular, 45.0 if self.system.name == "fourbar" else 25.0, 12.0)
        reach = np.where(self.system.angular, 1e6 if self.system.name in ("fourbar", "unicycle2d") else 7.0, 4.0)
        return bool(np.all(np.isfinite(run.q)) and np.all(np.abs(run.v) < share * speed)
                    and np.all(np.abs(run.q) < share * reach))

    def _references(self, p, run):
        """Typical force, speed, reach of each coordinate, of the nominal machine."""
        n = len(self.system.coords)
        force = np.zeros_like(run.a)
        for k in range(0, len(run.q), 10):
            M, Q = self.system.mass_matrix(p, run.q[k])
            force[k] = np.abs(M @ run.a[k]) + np.abs(Q)
        self.force = np.sqrt((force[::10]**2).mean(axis=0))
        self.speed = np.maximum(np.sqrt((run.v**2).mean(axis=0)), 1e-3)
        self.reach = np.maximum(run.q.std(axis=0), 1e-3)
        self.middle = run.q.mean(axis=0)
        self.input_rms = np.sqrt((run.command**2).mean(axis=0))
        self.inertia = np.mean([np.diag(self.system.mass_matrix(p, q)[0]) for q in run.q[::100]], axis=0)
        self.lightness = np.max([np.diag(np.linalg.inv(self.system.mass_matrix(p, q)[0]))
                                 for q in run.q[::100]], axis=0).reshape(n)

    def effect(self, name, where, on, shape):
        """An effect at its first strength, with the reference sizes of its place."""
        kind = fx.KINDS[name]
        ref = {"planar": self.system.name == "unicycle2d", "width": self.width}
        if kind.family == "input":
            chosen = list(where) if isinstance(where, tuple) else [where]
            ref["U"] = float(self.input_rms[chosen].mean())
        elif name in ("payload", "com_offset"):
            ref |= self._payload_reference(where)
        elif kind.family != "parameter":
            if name in ("speed_drag", "rolling_resistance", "contact_friction"):
                ref |= {"F": float(self.force[:2].mean()), "V": float(np.hypot(*self.speed[:2]))}
            else:
                ref |= {"F": float(self.force[where]), "V": float(self.speed[where])}
            ref |= {"X": float(self.reach[where]), "mean": float(self.middle[where]),
                    "M": float(self.inertia[where]), "angular": self.system.angular[where]}
        return fx.Effect(kind, where, on, shape, kind.first, ref)

    def _payload_reference(self, link):
        if self.system.code == plant.CHAIN:
            p = self.system.vector(self.nominal)
            return {"mass": float(p[4 * link]), "length": float(p[4 * link + 1])}
        if self.system.code == plant.CARTPOLE:
            return {"mass": self.nominal["mp"], "length": 2 * self.nominal["l"]}
        return {"mass": self.nominal["m"], "length": 0.0}

    def true_parameters(self, effects=None):
        """Nominal parameters with the wrong ones put right."""
        found = dict(self.nominal)
        for e in self.effects if effects is None else effects:
            if e.kind.family == "parameter":
                found[e.where] = e.wrong_value(self.nominal[e.where])
        return found

    def substeps(self, records):
        """Steps per sample: 1 ms, finer where a smooth sign is steep for a light coordinate."""
        stiff = 0.0
        for kind, target, x in zip(*records):
            if kind == plant.ROLLING_RESISTANCE:
                stiff = max(stiff, x[0] / x[1] * self.lightness[:2].max())
            elif kind == plant.JOINT_COUPLING:
                stiff = max(stiff, x[2] / x[3] * 2 * self.lightness[target:target + 2].sum())
            slope = {plant.COULOMB: (0, 1), plant.ASYMMETRIC_COULOMB: (0, 2), plant.STRIBECK: (1, 3),
                     plant.CONTACT_FRICTION: None}.get(kind)
            if slope:
                stiff = max(stiff, max(x[0], x[slope[0]]) / x[slope[1]] * self.lightness[target])
            elif kind == plant.LOAD_FRICTION:
                torque = 3 * self.input_rms[self.driven == target].sum()
                stiff = max(stiff, x[0] * torque / x[1] * self.lightness[target])
        finer = self.finer
        rate = self.control_rate
        return int(min(40 * finer, max(round(1000 / rate), np.ceil(finer * stiff / rate))))

    def run(self, which, effects=None, projected=True, late=None):
        """Simulates one of the two logs with the machine's effects (or those given); `late`: how late
        each sample is, where stamps jitter."""
        chosen = self.effects if effects is None else effects
        records = fx.encode(chosen)
        p = self.system.vector(self.true_parameters(chosen))
        q, v = self._consistent_start(p, records, which)
        open_loop, speeds = self.open_loop[which]
        noise = self.noise[which]
        substeps = self.substeps(records) if len(records[0]) else round(1000 / self.control_rate)
        seen = 1.0 if self.seen else 0.0
        late = np.zeros(len(open_loop)) if late is None else np.append(late, late[-1])
        run = Run(*rollout.simulate(
            self.system.code, p, self.system.constraints, self.driven, *records, q, v, open_loop, self.gains, speeds,
            seen * noise["q"], seen * noise["dq"], 1 / self.control_rate, late, substeps, self.first_order, projected,
            self.nameless(which)))
        return run.every(self.faster)

    def _consistent_start(self, p, records, which):
        q, v = (x.copy() for x in self.start[which])
        for _ in range(5 if self.system.constraints else 0):
            rollout.project(self.system.code, p, self.system.constraints, q, v, 0.0, *records)
        return q, v

    def margin(self):
        """Samples at both ends of a run for which a sensor that is late or early has no reading."""
        late = [abs(e.parameters()["tau"]) for e in self.effects if e.kind.name == "time_shift"]
        if self.suite is not None:
            late.append(abs(self.suite.misread.get("params", {}).get("tau", 0.0)))
        return int(np.ceil(max(late, default=0.0) * self.rate - 1e-9))

    def measured(self, which, run, corrected=()):
        """Channels as the sensors give them, unrounded; errors of the `corrected` effects apart."""
        noise = {name: x[::self.faster] for name, x in self.noise[which].items()}
        position, v, a = run.q.copy(), run.v.copy(), run.a.copy()
        for e in self.effects:
            if e.kind.family == "sensor" and not any(e is c for c in corrected):
                channel = tuple(x[:, e.where] for x in (position, v, a))
                for own, read in zip(channel, _misread(e, *channel, 1 / self.rate)):
                    own[:] = read
        q = position + noise["q"]
        quantum = np.where(self.quantum > 0, self.quantum, 1.0)
        q = np.where(self.quantum > 0, np.round(q / quantum) * quantum, q)
        every = {"q": q, "dq": v + noise["dq"], "ddq": a + noise["ddq"]}
        return {k: every[k] for k in self.columns if k != "u"}

    def nameless(self, which):
        """Forces that follow no law, at the controller's samples: an Ornstein-Uhlenbeck process in each
        coordinate, as large as the stated share of its force."""
        count, n = len(self.open_loop[which][0]), len(self.system.coords)
        share, lasting = self.disturbance.nameless
        if not share:
            return np.zeros((count, n))
        rng = np.random.default_rng([self.own_seed, 1, list(self.durations).index(which)])
        lasting = Disturbance(colour=lasting)
        return share * self.force * lasting.noise(rng.standard_normal((count, n)), self.control_rate)

    def torques(self, which, run):
        """The inputs as they are logged: those of the run with the noise of the torque column."""
        if not self.disturbance.torque:
            return run.command
        size = np.sqrt((run.command**2).mean(axis=0))
        white = np.random.default_rng([self.own_seed, 0, list(self.durations).index(which)])
        return run.command + self.disturbance.torque * size * white.standard_normal(run.command.shape)

    # --- visibility -----------------------------------------------------------

    def score(self):
        """Runs, logs, and per log the error of the true model, the nominal one, and the
        true one without each effect in turn."""
        found = {}
        for which in self.durations:
            run = self.run(which)
            if not np.all(np.isfinite(run.q)) or not self.tame(run):
                return None
            without = []
            for e in self.effects:
                rest = [o for o in self.effects if o is not e]
                without.append(self._error(which, run, rest)[0])
            true = oracle.Log(self, run, self.measured(which, run, self.effects), self.torques(which, run))
            found[which] = {"run": run, "floor": self._error(which, run, self.effects),
                            "nominal": self._error(which, run, []), "scale": true.scale, "without": without}
        return found

    def _error(self, which, run, kept):
        log = oracle.Log(self, run, self.measured(which, run, kept), self.torques(which, run))
        p = self.system.vector(self.true_parameters(kept))
        return log.error(p, fx.encode(kept), self._states(run, kept))

    def _states(self, run, kept):
        """Columns of the hidden states that belong to the kept effects."""
        picked, column = [], 0
        for e in self.effects:
            width = len(e.records())
            if any(e is o for o in kept):
                picked += range(column, column + width)
            column += width
        return np.ascontiguousarray(run.z[:, picked])

    def calibrate(self, targets):
        """Scales each effect until leaving it out raises the error to its target multiple of
        the floor (on the log where it shows less). Returns the last score."""
        ceilings = [e.kind.largest for e in self.effects]
        best, best_miss = None, np.inf
        for _ in range(6):
            strengths = [e.strength for e in self.effects]
            score = self.score()
            if score is None:  # out of range: smaller from here on
                ceilings = [0.8 * x for x in strengths]
                wanted = [0.4 * x for x in strengths]
            else:
                shown = self.visibility(score)
                miss = max((abs(np.log(s / w)) for s, w in zip(shown, targets)), default=0.0)
                if miss < best_miss:
                    best, best_miss = (score, strengths), miss
                factors = [np.sqrt((w**2 - 1) / max(s**2 - 1, 0.02)) for s, w in zip(shown, targets)]
                wanted = [float(np.clip(x * np.clip(f, 0.2, 4), 1e-4, c))
                          for x, f, c in zip(strengths, factors, ceilings)]
                if miss < 0.3 or np.allclose(wanted, strengths, rtol=0.05):
                    break
            for e, x in zip(self.effects, wanted):
                e.strength = x
        if best is None:
            return None
        for e, x in zip(self.effects, best[1]):
            e.strength = x
        return best[0]

    def visibility(self, score):
        """For each effect, the smaller over both logs of (error without it) / floor."""
        return [min(score[k]["without"][i] / score[k]["floor"][0] for k in score)
                for i in range(len(self.effects))]

    def look_alikes(self, score, least=0.9):
        """For each effect, single library effects or parameters whose acceleration pattern on
        the train log explains at least `least` of its own; strongest first."""
        run, p = score["train"]["run"], self.system.vector(self.nominal)
        base = oracle.signature(self, run, p, no_effects(), run.z[:, :0])
        rivals = [(name, on, self._signature(run, [self.effect(name, where, on, np.full(3, 0.4))]) - base)
                  for name, kind in fx.KINDS.items() if kind.source == fx.LIBRARY and kind.family in fx.ALONG_A_LOG
                  for where, on in fx.places(self.system, name)]
        found = []
        for e in self.effects:
            own = self._signature(run, [e]) - base
            near = []
            for name, on, pattern in rivals:
                share, sign = oracle.similarity(own, pattern)
                if name == e.kind.name and on == e.on:
                    continue
                either = name in ("parameter", "constant_force", "input_bias", "input_gain")
                if share >= least and (sign > 0 or either):
                    near.append({"type": name, "on": on, "r2": round(share, 4)})
            found.append(sorted(near, key=lambda x: (-x["r2"], x["type"], x["on"])))
        return found

    def _signature(self, run, kept):
        p = self.system.vector(self.true_parameters(kept))
        known = any(e is kept[0] for e in self.effects)
        z = self._states(run, kept) if known else np.zeros((len(run.q), len(fx.encode(kept)[0])))
        return oracle.signature(self, run, p, fx.encode(kept), z)
