"""Lets the libraries' programs take turns: results compared first, then the fastest of many rounds of each."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

import robots
from speed import build
from speed.libraries import FUNCTIONS, CasadiC, Dynibo, Library, Mujoco, Ours

ROUNDS = 100
PIECE = 1e6
"""What a round lasts, about, in nanoseconds."""
AGREE = 1e-9
"""How far results may be off, as a share of the largest entry."""


def one_core():
    """Pins a program to the last of the cores that this process may use, where that can be had."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


class Program:
    """A running program of a library, for one robot."""

    def __init__(self, library, command, states, out):
        self.library, self.name, self.states = library, library.name, states
        path = out / f"states_{library.robot.name}_{type(library).__name__}.txt"
        rows = [" ".join(repr(float(x)) for x in library.row(s)) for s in states]
        path.write_text("\n".join([*rows, ""]))
        command = [str(part) for part in [command[0], path, *command[1:]]]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        preexec_fn=one_core)

    def ask(self, command):
        """The numbers of an answer."""
        try:
            self.process.stdin.write(command + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            pass  # the answer, which is none, says so
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.name} ended at `{command}`")
        return np.array(line.split(), dtype=float)

    def results(self, function, number):
        """Results at a state in Pinocchio's convention."""
        return self.library.results(function, self.ask(f"value {function} {number}"), self.states[number])

    def time(self, function, count):
        """Nanoseconds per evaluation."""
        return float(self.ask(f"time {function} {count}")[0])

    def end(self):
        """Lets the program end."""
        self.process.stdin.close()
        self.process.wait()


@dataclass
class Result:
    """What was measured of one robot."""

    robot: robots.Robot
    nanoseconds: dict = field(default_factory=dict)
    """By library and function."""
    operations: dict = field(default_factory=dict)
    """By library and function."""
    gap: float = 0.0
    """The largest difference of any result from Pinocchio's, as a share of its largest entry."""


def compare(programs, function, undriven):
    """The largest difference of any result at any state from that of the first program."""
    worst = 0.0
    for number in range(robots.STATES):
        expected, *others = [program.results(function, number) for program in programs]
        for program, found in zip(programs[1:], others):
            for mine, theirs in zip(expected, found):
                # Ours have no derivative by the forces on the base, which nothing makes.
                mine = mine[:, undriven:] if mine.shape != theirs.shape else mine
                gap = np.max(abs(mine - theirs)) / np.max(abs(mine))
                if not gap <= AGREE:
                    raise RuntimeError(f"{function} of {program.name} at state {number} is {gap:.1e} off Pinocchio's")
                worst = max(worst, gap)
    return worst


def race(programs, function):
    """The fastest round of each."""
    counts = {p: max(robots.STATES, int(PIECE / p.time(function, robots.STATES)) // robots.STATES * robots.STATES)
              for p in programs}
    best = dict.fromkeys(programs, np.inf)
    for _ in range(ROUNDS):
        for program in programs:
            best[program] = min(best[program], program.time(function, counts[program]))
    return {program.name: time for program, time in best.items()}


class Build:
    """What all robots share: programs that read the robot, or why there is none."""

    def __init__(self, out):
        self.missing, self.made = {}, {}
        makers = {"pinocchio": build.pinocchio, "symbolic": build.symbolic, "mujoco": build.mujoco_program,
                  "dynibo": build.dynibo}
        with ThreadPoolExecutor(2) as pool:
            jobs = {name: pool.submit(make, out) for name, make in makers.items()}
        for name, job in jobs.items():
            try:
                self.made[name] = job.result()
            except build.Missing as why:
                self.missing[name] = str(why)
        if "pinocchio" in self.missing:
            sys.exit(f"Pinocchio's headers, which all is compared with, cannot be used: {self.missing['pinocchio']}")


def casadi(robot, model, out, built, result):
    """CasADi's C, and its operations."""
    program, there, result.operations["casadi"] = build.casadi(out, robot, model, out / f"{robot.name}.txt",
                                                               built.made["symbolic"])
    library = CasadiC(robot, model)
    library.functions = tuple(there)
    return library, [program]


def mujoco(robot, model, out, built, _):
    """MuJoCo, with its own model of the robot."""
    path, joints = build.mujoco_model(out, robot)
    return Mujoco(robot, model, joints), [built.made["mujoco"], path]


def dynibo(robot, model, out, built, _):
    """dynibo, which says in which order it has the joints."""
    joints = build.run([built.made["dynibo"], robot.urdf]).split()
    base = "floating" if robot.floats else "fixed"
    return Dynibo(robot, model, joints), [built.made["dynibo"], robot.exact(out), base]


OTHERS = {"symbolic": casadi, "mujoco": mujoco, "dynibo": dynibo}


def starters(robot, model, out, generator, built, result):
    """(library, command) of everything that computes a robot; Pinocchio first."""
    description = out / f"{robot.name}.txt"
    description.write_text(robots.as_text(model))
    found = [(Library(robot, model), [built.made["pinocchio"], description]),
             (Ours(robot, model), [build.ours(out, robot, generator)])]
    result.operations["ours"] = build.our_operations(out, robot)
    for name, make in OTHERS.items():
        if name in built.made:
            try:
                found.append(make(robot, model, out, built, result))
            except build.Missing as why:
                built.missing[f"{name}, {robot.name}"] = str(why)
    return found


def measure(robot, out, generator, built):
    """Compares all results of a robot, then times everything."""
    model, result = robot.pinocchio(), Result(robot)
    states = robots.states(robot, model)
    programs = [Program(library, command, states, out)
                for library, command in starters(robot, model, out, generator, built, result)]
    try:
        for function in FUNCTIONS:
            able = [p for p in programs if function in p.library.functions]
            result.gap = max(result.gap, compare(able, function, 6 * robot.floats))
            result.nanoseconds[function] = race(able, function)
    finally:
        for program in programs:
            program.end()
    return result
