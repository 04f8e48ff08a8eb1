#!/usr/bin/env python3
"""Writes (or with --check compares) expected/<model>.json for the language models, and
expected/linearised_<model>.json for some.

    python derive.py            recreate every file
    python derive.py --check    recreate in memory, compare at 1e-12, run selfcheck

The format is described in ../README.md.
"""

import argparse
import json
import math
import sys
import zlib
from pathlib import Path

import casadi as ca
import numpy as np

import lagrange
import linearised
import selfcheck
from models import LINEARISED, MODELS

HERE = Path(__file__).resolve().parent
SEED = 20240601
# What differs between processors: a share of an array's size, as much as the tests allow, for a platform
# on three arms is put together in other digits by each (1.8e-11 was seen), and rounding of what is naught
# (the four-bar's closure is the sum of lengths of about a metre).
TOLERANCE = 1e-10
ROUNDING = 1e-14
# a state whose equilibrated saddle-point matrix is worse conditioned is drawn again:
# the figures shall be right to about 1e-13, whichever solver the reader uses
MAX_CONDITION = 300.0
# and so is one where friction feeds more than this share of a multiplier's change back
MAX_FEEDBACK = 0.5
VECTORS = ("bias", "Q", "b", "c", "c_dot", "a", "lambda", "z_dot")


def evaluate(function, state):
    """All outputs at one state as numpy arrays, by name."""
    values = function(*[state[name] for name in function.name_in()])
    return {name: np.array(value) for name, value in zip(function.name_out(), values)}


def condition(out):
    """Condition number of the saddle-point matrix after symmetric equilibration."""
    M, A = out["M"], out["A"]
    m = A.shape[0]
    d = 1 / np.sqrt(np.diag(M))
    scaled_a = A * d
    scaled_a = scaled_a / np.linalg.norm(scaled_a, axis=1, keepdims=True) if m else scaled_a
    K = np.block([[M * np.outer(d, d), scaled_a.T], [scaled_a, np.zeros((m, m))]])
    return np.linalg.cond(K)


def project(function, state):
    """Moves q onto c = 0 and v onto c_dot = 0 (c = 0 if nonholonomic) by Newton steps."""
    for _ in range(50):
        out = evaluate(function, state)
        holonomic = ~np.isnan(out["c_dot"][:, 0])
        A, c = out["A"], out["c"][:, 0]
        if np.any(holonomic):
            step = np.linalg.lstsq(A[holonomic], c[holonomic], rcond=None)[0]
            state["q"] = state["q"] - step
            out = evaluate(function, state)
        rate = np.where(holonomic, out["c_dot"][:, 0], out["c"][:, 0])
        state["v"] = state["v"] - np.linalg.lstsq(out["A"], rate, rcond=None)[0]
        out = evaluate(function, state)
        rate = np.where(holonomic, out["c_dot"][:, 0], out["c"][:, 0])
        error = max(np.abs(out["c"][holonomic, 0]).max(initial=0), np.abs(rate).max())
        if error < 1e-14:
            return True
    return False


def draw(model, rng):
    """One random state: parameters within 20 % of nominal, generic q, v, u, t."""
    width = np.array([model.scale.get(name, 1.0) for name in model.coordinates])
    nominal = np.array(list(model.parameters.values()))
    state = {
        "q": rng.uniform(-1, 1, len(width)) * width,
        "v": rng.uniform(-2, 2, len(width)),
        "u": rng.uniform(-5, 5, len(model.inputs)),
        "t": rng.uniform(0, 5),
        "p": nominal * rng.uniform(0.8, 1.2, len(nominal)),
    }
    if model.states:
        state["z"] = rng.uniform(-2, 2, len(model.states))
        state["late"] = rng.uniform(-5, 5, len(model.late))
    return state


def cases(model, function, constraints):
    """Random states; of a constrained model every second one lies on the constraint."""
    rng = np.random.default_rng([SEED, zlib.crc32(model.name.encode())])
    kept = []
    while len(kept) < model.cases:
        state = draw(model, rng)
        on_constraint = bool(constraints) and len(kept) % 2 == 0
        if on_constraint and not project(function, state):
            continue
        out = evaluate(function, state)
        if condition(out) > MAX_CONDITION or abs(out.pop("feedback", np.zeros(1))).max() > MAX_FEEDBACK:
            continue
        kept.append((state, out))
    return kept


def document(model):
    """The document of one model, as plain lists and numbers."""
    function, constraints = lagrange.derive(model)
    listed = []
    for state, out in cases(model, function, constraints):
        entry = {k: state[k].tolist() for k in ("q", "v", "u", "z", "late") if k in state}
        entry["t"] = float(state["t"])
        entry["parameters"] = dict(zip(model.parameters, state["p"].tolist()))
        for name, value in out.items():
            vector = name in VECTORS or name.endswith("_dt")
            entry[name] = plain(value[:, 0] if vector else value)
        listed.append(entry)
    return {"model": model.name, "casadi_version": ca.__version__,
            "coordinates": list(model.coordinates), "inputs": list(model.inputs),
            "parameters": list(model.parameters), "constraints": constraints,
            "cases": listed}


def plain(array):
    """Nested lists; not-a-number (c_dot of a nonholonomic constraint) becomes None."""
    if isinstance(array, np.ndarray):
        return [plain(x) for x in array]
    value = float(array)
    return None if math.isnan(value) else value + 0.0  # + 0.0 turns -0 into 0


def write(value):
    """Compact JSON with 17 significant digits."""
    if isinstance(value, dict):
        return "{" + ",".join(f"{json.dumps(k)}:{write(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        separator = ",\n" if value and isinstance(value[0], dict) else ","
        return "[" + separator.join(write(v) for v in value) + "]"
    return f"{value:.17g}" if isinstance(value, float) else json.dumps(value)


def differences(expected, found, place):
    """Yields places where two documents differ by more than TOLERANCE of an array's size, and ROUNDING."""
    if isinstance(expected, dict) and isinstance(found, dict):
        if expected.keys() != found.keys():
            yield f"{place}: keys {sorted(set(expected) ^ set(found))}"
        for key in expected.keys() & found.keys():
            yield from differences(expected[key], found[key], f"{place}.{key}")
        return
    if any(isinstance(w, list) and w and isinstance(w[0], (dict, str)) for w in (expected, found)):
        if not isinstance(expected, list) or not isinstance(found, list) or len(expected) != len(found):
            yield f"{place}: length"
            return
        for i, (x, y) in enumerate(zip(expected, found)):
            yield from differences(x, y, f"{place}[{i}]")
        return
    if isinstance(expected, str) or isinstance(found, str):
        if expected != found:
            yield f"{place}: {expected!r} is not {found!r}"
        return
    x, y = (np.array(w, dtype=float) for w in (expected, found))
    if x.shape != y.shape or np.any(np.isnan(x) != np.isnan(y)):
        yield f"{place}: shape or null"
        return
    largest = TOLERANCE * np.nanmax(np.abs(x), initial=0) + ROUNDING
    if x.size and np.nanmax(np.abs(x - y), initial=0) > largest:
        yield f"{place}: {np.nanmax(np.abs(x - y)):.3g} apart, size {np.nanmax(np.abs(x)):.3g}"


def linearisation(model):
    """The document of one model's linearisations."""
    seed = [SEED, zlib.crc32(f"linearised {model.name}".encode())]
    return linearised.document(model, draw, project, evaluate, condition,
                               (MAX_CONDITION, MAX_FEEDBACK), seed)


def documents(wrong):
    """Every document with the name of its file; what the second route denies goes to `wrong`."""
    for model in MODELS:
        made = document(model)
        wrong += selfcheck.compare(made)
        yield model.name, made
    for model in LINEARISED:
        yield f"linearised_{model.name}", linearisation(model)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    parser.add_argument("--out", type=Path, default=HERE / "expected")
    arguments = parser.parse_args()
    wrong = []
    for name, made in documents(wrong):
        path = arguments.out / f"{name}.json"
        if arguments.check:
            try:
                stored = json.loads(path.read_text())
            except FileNotFoundError:
                wrong.append(f"{path.name}: missing, run derive.py")
                continue
            wrong += [f"{path.name} {d}" for d in differences(stored, made, name)]
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(write(made) + "\n")
            print(f"{path.name}: {len(made['cases'])} cases, {path.stat().st_size // 1024} kB")
    for line in wrong:
        print(line, file=sys.stderr)
    if wrong:
        return 1
    print(f"{len(MODELS)} models agree" if arguments.check else "both routes agree")
    return 0


if __name__ == "__main__":
    sys.exit(main())
