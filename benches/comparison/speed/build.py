"""Compiles every library's program: all C and C++ with the same flags, dynibo's Rust for the same processor."""

import os
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path

from speed.libraries import FUNCTIONS

try:
    import casadi as ca
except ImportError:
    ca = None
try:
    import mujoco
except ImportError:
    mujoco = None

HERE = Path(__file__).resolve().parent
FLAGS = ["-O3", "-march=native"]
"""Of all C and C++ that is timed."""
RUSTFLAGS = "-C target-cpu=native"
# What Pinocchio's own CMake files state for whoever includes its headers.
PINOCCHIO = ["-std=c++17", "-DNDEBUG", "-w", "-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
             "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "-DBOOST_FUSION_INVOKE_MAX_ARITY=12"]
LONGEST = 20_000
"""Operations of the longest of CasADi's functions that is compiled: with more, a C compiler takes minutes."""


class Missing(Exception):
    """A library cannot be compared here, and why."""


def run(command, **more):
    """Runs a command; its complaint is the error."""
    done = subprocess.run([str(part) for part in command], text=True, capture_output=True, check=False, **more)
    if done.returncode:
        raise Missing(f"{Path(str(command[0])).name} failed: {done.stderr.strip()[-400:]}")
    return done.stdout


def headers():
    """Where pip has put Pinocchio's and Eigen's headers."""
    prefix = Path(find_spec("cmeel").origin).parents[1] / "cmeel.prefix/include"
    return [f"-I{prefix}", "-isystem", prefix / "eigen3"]


def compile(program, command, *sources):
    """Runs a compiler, unless the program is there, was made by the same command, and is younger than its sources."""
    command = [str(part) for part in [*command, "-o", program]]
    note = program.with_suffix(".command")
    made = note.exists() and note.read_text() == "\n".join(command) and program.exists()
    if not (made and all(program.stat().st_mtime > source.stat().st_mtime for source in sources)):
        run(command)
        note.write_text("\n".join(command))
    return program


def ours(out, robot, generator):
    """Our generated C of a robot."""
    functions = ["mass_matrix", "bias_force", "mass_matrix+bias_force", "forward_dynamics",
                 "inverse_dynamics_derivatives", "forward_dynamics_derivatives"]
    run([generator, "generate", robot.model_file, "--to", "c", "--out", out, "--functions", ",".join(functions)])
    sources = [HERE / "ours.c", out / f"{robot.name}.c"]
    command = ["cc", *FLAGS, "-I", out, f'-DHEADER="{robot.name}.h"', f"-DMODEL={robot.name}", *sources, "-lm"]
    return compile(out / f"ours_{robot.name}", command, *sources)


def our_operations(out, robot):
    """Operations of our functions, from the head of the generated file."""
    names = {"mass_matrix": "mass", "bias_force": "bias", "mass_matrix_and_bias_force": "both"}
    found = {}
    for line in (out / f"{robot.name}.h").read_text().splitlines():
        words = line.split()
        if len(words) > 2 and words[1] in names:
            found.setdefault(names[words[1]], int(words[2]))
    return found


def pinocchio(out):
    """Pinocchio's C++, of any robot."""
    sources = [HERE / name for name in ("pinocchio.cpp", "robot.hpp", "driver.h")]
    return compile(out / "pinocchio", ["c++", *FLAGS, *PINOCCHIO, *headers(), sources[0]], *sources)


def symbolic(out):
    """The program that makes CasADi's functions out of Pinocchio's algorithms; it is not timed."""
    if ca is None:
        raise Missing("CasADi is not installed")
    sources, library = [HERE / name for name in ("symbolic.cpp", "robot.hpp")], Path(ca.__file__).parent
    command = ["c++", "-O0", *PINOCCHIO, *headers(), f"-I{library / 'include'}", sources[0], f"-L{library}", "-lcasadi",
               f"-Wl,-rpath,{library}"]
    return compile(out / "symbolic", command, *sources)


def operations(function):
    """How many operations a function of CasADi's has, reads, writes and constants apart."""
    free = (ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT)
    return sum(function.instruction_id(i) not in free for i in range(function.n_instructions()))


def expressions(description, name, maker):
    """A function of CasADi's, equal subexpressions shared."""
    function = ca.Function.deserialize(run([maker, description, name]))
    symbols = function.sx_in()
    return ca.Function(name, symbols, ca.cse(function.call(symbols)))


def casadi(out, robot, model, description, maker):
    """CasADi's C of a robot: the program, what it has, and the operations of all functions."""
    found = {name: expressions(description, name, maker) for name in FUNCTIONS}
    counts = {name: operations(function) for name, function in found.items()}
    compiled = [name for name in FUNCTIONS if counts[name] <= LONGEST]
    source = out / f"casadi_{robot.name}.c"
    generator = ca.CodeGenerator(source.name)
    for name in compiled:
        generator.add(found[name])
    text = generator.dump()
    if not (source.exists() and source.read_text() == text):
        source.write_text(text)
    names = " ".join(f"FUNCTION({name})" for name in compiled)
    command = ["cc", *FLAGS, "-w", f"-DFUNCTIONS={names}", f"-DPOSITIONS={model.nq}", f"-DVELOCITIES={model.nv}",
               HERE / "casadi.c", source, "-lm"]
    program = compile(out / f"casadi_{robot.name}", command, source, HERE / "casadi.c")
    return program, compiled, counts


def mujoco_program(out):
    """A program around MuJoCo's C library, which comes compiled."""
    if mujoco is None:
        raise Missing("MuJoCo is not installed")
    folder, source = Path(mujoco.__file__).parent, HERE / "mujoco.c"
    library = next(folder.glob("libmujoco.so*"))
    command = ["cc", *FLAGS, "-I", folder / "include", source, f"-L{folder}", f"-l:{library.name}",
               f"-Wl,-rpath,{folder}"]
    return compile(out / "mujoco", command, source)


def mujoco_model(out, robot):
    """A robot as MuJoCo reads it, and its joints in MuJoCo's order: without shapes and losses."""
    spec = mujoco.MjSpec.from_file(str(robot.exact(out)))
    spec.compiler.fusestatic = False
    if robot.floats:
        spec.bodies[1].add_freejoint()
    for geometry in list(spec.geoms):
        spec.delete(geometry)
    for joint in spec.joints:
        joint.armature = joint.frictionloss = 0
    # As it is in memory: the text of a model has six digits.
    model, path = spec.compile(), out / f"{robot.name}.mjb"
    mujoco.mj_saveModel(model, str(path))
    return path, [model.joint(i).name for i in range(int(robot.floats), model.njnt)]


def dynibo(out):
    """The crate dynibo, compiled for this processor."""
    if not shutil.which("cargo"):
        raise Missing("there is no cargo")
    run(["cargo", "build", "--release", "--quiet", "--locked", "--manifest-path", HERE / "dynibo/Cargo.toml"],
        env={**os.environ, "RUSTFLAGS": RUSTFLAGS, "CARGO_TARGET_DIR": str(out / "cargo")})
    return out / "cargo/release/dynibo-driver"
