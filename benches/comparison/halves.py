"""The two halves of the comparison: how fast equations are, and what is made of logs."""

import os
import tomllib
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from importlib import import_module

import robots
from machines import eight, ours, scoring
from machines.answer import lines
from speed import build, race

TOOLS = {"MuJoCo sysid": "machines.sysid", "PySINDy": "machines.sindy", "plain regression": "machines.regression"}


def flags():
    """Flags of C and Rust, and the version of the crate that is compiled."""
    crate = tomllib.loads((build.HERE / "dynibo/Cargo.toml").read_text())["dependencies"]["dynibo"]
    return build.FLAGS, build.RUSTFLAGS, crate.lstrip("=")


def speed(out, program):
    """Times and operations of the three robots, and why a library is missing."""
    built = race.Build(out)
    found = []
    for robot in robots.ROBOTS:
        print(f"{robot.title} …", flush=True)
        result = race.measure(robot, out, program, built)
        found.append({"robot": robot.name, "title": robot.title, "nanoseconds": result.nanoseconds,
                      "operations": result.operations, "gap": result.gap})
    return {"robots": found, "missing": built.missing}


def tools():
    """Modules of the tools that can be imported, and why the others cannot."""
    found, missing = {}, {}
    for name, module in TOOLS.items():
        try:
            found[name] = import_module(module)
        except (ImportError, AttributeError) as why:
            missing[name] = str(why)
    return found, missing


def one(choice, out, program):
    """Everything about one machine."""
    machine = eight.make(choice, out)
    train, task = scoring.prepare(machine, "train"), scoring.prepare(machine, "test")
    answers = [ours.trace(machine, task, program), ours.fit(machine, task, program)]
    answers += [module.answer(machine, train, task) for module in tools()[0].values()]
    return {"title": choice.title, "truth": machine.truth(), "before": scoring.before(machine, task),
            "floor": scoring.floor(machine, task), "answers": [vars(answer) for answer in answers]}


def machines(out, program):
    """Answers about the eight machines, two at a time, each on one core."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = "1"
    folder = out / "machines"
    folder.mkdir(exist_ok=True)
    work = partial(one, out=folder, program=program)
    found = [work(eight.CHOICES[0])]  # compiles what the simulator needs, before the others look for it
    with ProcessPoolExecutor(2) as pool:
        for answer in pool.map(work, eight.CHOICES[1:]):
            found.append(answer)
            print(f"{answer['title']} …", flush=True)
    modules, missing = tools()
    written = {"ours, trace": lines(ours), "ours, fit": lines(ours)}
    written |= {name: lines(module) for name, module in modules.items()}
    return {"machines": found, "lines": written, "missing": missing}
