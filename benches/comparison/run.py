#!/usr/bin/env python3
"""Ours beside others, in one run: prints versions, flags and tables, and writes docs/comparison.md with its figure.

    python benches/comparison/run.py [--program PATH] [--only speed|machines] [--docs DIR]

It makes an environment for Python in target/comparison, builds our program unless it is given, compiles what is timed,
and takes a quarter of an hour at most on two cores. Everything it needs besides is pip, cargo and a C++ compiler. A
library that cannot be had is named as not compared.
"""

import argparse
import json
import resource
import time
from pathlib import Path

import environment

ROOT = environment.ROOT


def arguments():
    """What is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, help="our command line; built if it is not stated")
    parser.add_argument("--out", type=Path, default=ROOT / "target/comparison", help="a folder for what is built")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", help="where the page and its figure go")
    parser.add_argument("--only", choices=("speed", "machines"), help="one half, printed and not written")
    parser.add_argument("--here", action="store_true", help="use this Python as it is")
    parser.add_argument("--again", action="store_true", help="write the page anew from the last run's results")
    return parser.parse_args()


def main():
    asked = arguments()
    out = asked.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    if not asked.here:
        environment.enter(out)
    import page

    kept = out / "results.json"
    if asked.again:
        page.write(json.loads(kept.read_text()), asked.docs)
        return
    import halves

    start = time.monotonic()
    program = asked.program.resolve() if asked.program else environment.program()
    results = {"environment": environment.report(program, *halves.flags())}
    print("\n".join(results["environment"]), flush=True)
    if asked.only != "machines":
        results["speed"] = halves.speed(out, program)
        print(page.speed_tables(results["speed"]), flush=True)
    if asked.only != "speed":
        results["machines"] = halves.machines(out, program)
        print(page.machine_tables(results["machines"]), flush=True)
    results["minutes"] = (time.monotonic() - start) / 60
    results["processor_minutes"] = sum(sum(resource.getrusage(who)[:2]) for who in (
        resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) / 60
    print(f"{results['minutes']:.1f} minutes, {results['processor_minutes']:.1f} of one processor")
    if not asked.only:
        kept.write_text(json.dumps(results, indent=1))
        page.write(results, asked.docs)


if __name__ == "__main__":
    main()
