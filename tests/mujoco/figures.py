"""Files of reference figures: written anew, or with --check compared with what is found."""

import argparse
import json
import sys


def flat(value):
    """All numbers, in order."""
    if isinstance(value, dict):
        return [x for part in value.values() for x in flat(part)]
    if isinstance(value, list):
        return [x for part in value for x in flat(part)]
    return [value] if isinstance(value, float) else []


def hold(path, figures, tolerance, about, distance=lambda a, b: abs(a - b), written=lambda value: value):
    """Writes what `figures` finds to `path`, each entry as `written` makes it and on a line of its own, or
    compares all numbers with those that stand there. `about` is what --help says."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--check", action="store_true")
    check, found = parser.parse_args().check, figures()
    if check:
        known = json.loads(path.read_text(encoding="utf-8"))
        off = max(distance(a, b) for a, b in zip(flat(known), flat(found), strict=True))
        if off > tolerance:
            sys.exit(f"{path.name}: off by {off:.1e}")
        print(f"{path.name}: as known, within {off:.1e}")
        return
    lines = [f' "{name}": {json.dumps(written(value))}' for name, value in found.items()]
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
