"""The tables, on the terminal and as docs/comparison.md."""

import math

import figure
from speed.libraries import FUNCTIONS

OURS, PINOCCHIO = "ours, C", "Pinocchio C++"
LIBRARIES = (OURS, PINOCCHIO, "CasADi C from Pinocchio", "MuJoCo", "dynibo")
TOOLS = ("ours, trace", "ours, fit", "MuJoCo sysid", "PySINDy", "plain regression")
COUNTED = ("mass", "bias", "both")
NAMES = {"symbolic": "CasADi's C from Pinocchio's model", "mujoco": "MuJoCo"}
CLOSE = 1.15
"""Times the floor up to which an error is at the floor."""


def table(head, rows):
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def nanoseconds(value):
    """A time of one evaluation; none where a library has no such function."""
    return "–" if value is None else f"{value:.0f}"


def times(robot):
    """Times of one robot, and how many times as fast ours are as Pinocchio's C++."""
    rows = []
    for function, name in FUNCTIONS.items():
        found = robot["nanoseconds"][function]
        ratio = found[PINOCCHIO] / found[OURS]
        rows.append([name, *(nanoseconds(found.get(library)) for library in LIBRARIES), f"{ratio:.1f}"])
    return table([robot["title"], *LIBRARIES, "Pinocchio C++ over ours"], rows)


def operations(robots):
    """Operations of ours and CasADi's code."""
    rows = []
    for robot in robots:
        mine, theirs = robot["operations"]["ours"], robot["operations"].get("casadi")
        if theirs:
            rows += [[robot["title"], FUNCTIONS[f], mine[f], theirs[f], f"{mine[f] / theirs[f]:.2f}"] for f in COUNTED]
    return table(["robot", "function", "ours", "CasADi from Pinocchio", "share"], rows)


def slower(robots):
    """Where ours is not the fastest."""
    found = []
    for robot in robots:
        for function, name in FUNCTIONS.items():
            times_of = robot["nanoseconds"][function]
            quicker = [(t, l) for l, t in times_of.items() if l != OURS and t < 1.02 * times_of[OURS]]
            if quicker:
                time, library = min(quicker)
                found.append(f"{robot['title']}, {name}: {library} takes {time / times_of[OURS]:.2f} of our time")
    return found


def missing(reasons):
    """Lines about what is not compared."""
    return "".join(f"\n\nNot compared: {NAMES.get(name, name)} ({why})." for name, why in reasons.items())


def speed_tables(speed):
    """Everything about speed."""
    parts = [times(robot) for robot in speed["robots"]]
    gap = max(robot["gap"] for robot in speed["robots"])
    lacking = missing(speed["missing"])
    parts.append(f"Results differ from Pinocchio's by {gap:.0e} of the largest entry at most.{lacking}")
    parts.append(operations(speed["robots"]))
    found = slower(speed["robots"])
    if found:
        parts.append("Where ours is not the fastest:\n\n" + "\n".join(f"- {line}" for line in found))
    return "\n\n".join(parts)


def share(value):
    """An error."""
    return "–" if value is None or math.isnan(value) else f"{value:.4f}"


def by_tool(machine):
    """Answers of a machine by tool."""
    return {answer["tool"]: answer for answer in machine["answers"]}


def there(machines):
    """Tools that were compared."""
    return [tool for tool in TOOLS if tool in by_tool(machines[0])]


def errors(machines):
    """Errors before, at the floor and after each tool; those at the floor are bold."""
    rows = []
    for machine in machines:
        answers = by_tool(machine)
        cells = []
        for tool in there(machines):
            error = answers[tool]["error"]
            at_floor = error <= CLOSE * machine["floor"]
            cells.append(f"**{share(error)}**" if at_floor else share(error))
        rows.append([machine["title"], share(machine["before"]), share(machine["floor"]), *cells])
    return table(["machine, and what its model lacks", "before", "floor", *there(machines)], rows)


def costs(half):
    """Processor seconds of each tool, and the lines that its user writes."""
    machines = half["machines"]
    rows = []
    for tool in there(machines):
        seconds = [by_tool(machine)[tool]["seconds"] for machine in machines]
        rows.append([tool, f"{sorted(seconds)[len(seconds) // 2]:.1f}", f"{max(seconds):.1f}", half["lines"][tool]])
    return table(["tool", "processor seconds, median", "worst", "lines"], rows)


def sayings(machines):
    """What each tool says of each machine."""
    parts = []
    for machine in machines:
        answers = by_tool(machine)
        lines = [f"- {tool}: {answers[tool]['says']}" for tool in there(machines)]
        parts.append(f"**{machine['title']}.** The truth: {machine['truth']}.\n\n" + "\n".join(lines))
    return "\n\n".join(parts)


def machine_tables(half):
    """Everything about the eight machines."""
    machines = half["machines"]
    return "\n\n".join([errors(machines) + missing(half["missing"]), costs(half), sayings(machines)])


PAGE = """# Comparison

Ours beside others, all in one run on one machine: how fast equations of motion are, and what is made of logs. This page
and its figure are written by

```sh
python benches/comparison/run.py
```

which needs pip, cargo and a C++ compiler. The run of this page took {minutes:.0f} minutes on two cores that others used as
well, and {processor_minutes:.0f} minutes of processor time; a first run compiles for about five minutes of it besides. It
prints what it used:

```text
{environment}
```

![Times of one evaluation for an arm, a quadruped and a humanoid, and errors of predictions before and after, for five \
tools and eight machines](pictures/comparison.svg)

## How fast equations are

Three robots: a seven-joint arm (`models/iiwa7.urdf`), a quadruped with twelve joints (`models/solo12.urdf`) and a
humanoid with twenty-nine (`tests/pinocchio/humanoid.urdf`), the last two with a floating base, whose velocities are its
twist. Nanoseconds of one evaluation on one core: the same 64 states in the same order, the libraries taking turns, the
fastest of a hundred rounds each. All results are compared with Pinocchio's before anything is timed.

- *ours*: C of `dynamics generate`. (Our Rust is timed by `cargo bench`: [performance](performance.md).)
- *Pinocchio C++*: its headers, compiled with our flags, its default algorithms: `crba`, `nonLinearEffects`, `aba`,
  `computeRNEADerivatives`, `computeABADerivatives`. They compute any robot from data; ours is code for one. The list
  of joint types is shortened to those of these robots, which spares the compiler ten minutes.
- *CasADi C*: Pinocchio's algorithms over CasADi's expressions, equal subexpressions shared, compiled with our flags.
  Functions of more than 20 000 operations are counted only: a compiler takes minutes for them.
- *MuJoCo*: its C library as it comes, called for what each quantity needs and no more. It has no analytic derivatives.
- *dynibo*: the Rust crate. It has no derivatives.

Rotations are snapped for Pinocchio and CasADi as they are for ours: entries near 0 and ±1 become 0 and ±1. Filling the
lower triangle, or unpacking a sparse matrix, is not timed for those that leave it to the user; ours fills all.

{speed}

## What is made of logs

Eight machines of our simulator (`tests/simulator`, which shares no code with ours), drawn from a seed. Their logs have
noisy positions and inputs at 200 or 250 Hz, about 17 s to learn from, and another about 10 s to judge by. Our library has
every one of these effects, as MuJoCo's joints have all but cogging; of PySINDy's terms a sign is nearly the dry friction,
and a line the spring. That is in our favour. What these tools make of effects that none has a name for is not compared
here.

One definition of error for all: open-loop predictions over one second, started twice a second from the same smoothed
states of the log that is judged by, as a share of what each position varies by. The *floor* is the error of the true
machine. **Bold**: within 15 % of the floor.

- *ours*: `dynamics trace` and `dynamics fit`, with nothing but the model and the log to learn from, of which they keep a
  third apart themselves. `fit` explains measured forces, which takes accelerations; logs of positions alone are not
  what it is best at. It looks for friction, rotors, couplings, constant forces, a payload and inertias: of a spring or of
  cogging it makes what comes nearest, which is wrong.
- *MuJoCo sysid*: one-second shooting; damping, dry friction, armature and a spring of each joint, masses and a delay
  are free, started off their bounds, as it advises. It estimates what a user names, and does not choose; stated are the
  five that moved most, with intervals of 95 %. Not all of this can be told from one log (where a spring without stiffness
  rests, a cart's mass from its armature): the intervals say so. It stops after forty iterations. Who frees less, knowing
  what is missing, gets a sharper answer in less time.
- *PySINDy*: STLSQ on the residual forces of the model, polynomials of degree 2, sines and cosines, signs, of positions,
  velocities and inputs; the last third of the log chooses the threshold.
- *plain regression*: least squares of the residual forces on viscous friction, dry friction and an offset in each joint.

*Lines*: what a user writes besides a description of the machine; for ours it is one command.

{machines}
"""


def write(results, docs):
    """Writes the page and the figure."""
    figure.draw(results, docs / "pictures/comparison.svg")
    text = PAGE.format(
        minutes=results["minutes"], processor_minutes=results["processor_minutes"],
        environment="\n".join(results["environment"]),
        speed=speed_tables(results["speed"]), machines=machine_tables(results["machines"]))
    (docs / "comparison.md").write_text(text)
