#!/usr/bin/env python3
"""Writes (or with --check compares) Mbias_unsnapped.c: mass matrix and bias force of
models/iiwa7.urdf as CasADi's C out of Pinocchio's algorithms, the way a user gets it
who rounds nothing. The C beside the workspace has the near-zero entries of its
rotations rounded away; `cargo bench` compares the batched call with both.

    pip install -r requirements.txt
    python derive.py [--check]

Pinocchio's templates over CasADi's expressions come compiled in casadi-kin-dyn. Its library
is linked against a CasADi of its own, older and of another binary interface than the Python
module that writes the C: so it runs in a process of its own, and hands over text.
"""

import argparse
import os
import subprocess
import sys
import types
from pathlib import Path

HERE = Path(__file__).resolve().parent
URDF = HERE / "../../../../models/iiwa7.urdf"
NAME = "Mbias_unsnapped"


def serialised(algorithm):
    """The text of a CasADi function that computes `crba` or `rnea`."""
    import cmeel  # only to learn where the libraries lie

    packages = Path(cmeel.__file__).resolve().parent.parent
    library = packages / "cmeel.prefix/lib/libcasadi.so.3.7"
    if not library.exists():
        raise FileNotFoundError(f"{library}: install the versions of requirements.txt")
    done = subprocess.run([sys.executable, __file__, "--algorithm", algorithm], text=True, check=True,
                          stdout=subprocess.PIPE, env={**os.environ, "LD_PRELOAD": str(library)})
    return done.stdout


def print_algorithm(algorithm):
    """In the process of its own. The binding asks the Python module to read the text it has."""
    function = type("Function", (), {"deserialize": staticmethod(lambda text: text)})
    sys.modules["casadi"] = types.ModuleType("casadi")
    sys.modules["casadi"].Function = function
    from casadi_kin_dyn import casadi_kin_dyn

    robot = casadi_kin_dyn.CasadiKinDyn(URDF.read_text())
    sys.stdout.write(getattr(robot, algorithm)())


def operations(function):
    """How many operations a function has, reads, writes and constants apart."""
    import casadi as ca

    free = (ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT)
    return sum(function.instruction_id(i) not in free for i in range(function.n_instructions()))


def source():
    """The C file, and how many operations it has."""
    import casadi as ca

    crba, rnea = (ca.Function.deserialize(serialised(name)) for name in ("crba", "rnea"))
    q, v = ca.SX.sym("q", 7), ca.SX.sym("v", 7)
    results = [crba(q), rnea(q, v, ca.SX.zeros(7))]
    function = ca.Function(NAME, [q, v], ca.cse([ca.densify(r) for r in results]))
    generator = ca.CodeGenerator(f"{NAME}.c")
    generator.add(function)
    return generator.dump(), operations(function)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    parser.add_argument("--algorithm", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.algorithm:
        print_algorithm(arguments.algorithm)
        return 0
    text, count = source()
    path = HERE / f"{NAME}.c"
    if not arguments.check:
        path.write_text(text)
    elif path.read_text() != text:
        print(f"{path.name} is not what derive.py makes", file=sys.stderr)
        return 1
    print(f"{path.name}: {count} operations")
    return 0


if __name__ == "__main__":
    sys.exit(main())
