"""The sets of machines that never change."""

import tomllib
from pathlib import Path


def frozen():
    """What frozen.toml says."""
    return tomllib.loads((Path(__file__).parent / "frozen.toml").read_text())


def recipe(entry, index):
    """What machine `index` of a simulated set asks of `simulate.build`."""
    own = entry["machines"][index] if "machines" in entry else {}
    found = {"verdict": entry.get("class"), "only": entry.get("effect"), "width": entry.get("width"),
             "system": own.get("system"), "given": own.get("effects")}
    found |= {name: entry[name] for name in ("sensed", "misread") if name in entry}
    if "feedback" in entry:
        found["feedback"] = entry["feedback"]
    if "disturbed" in entry:
        found["disturbed"] = entry["disturbed"][index % len(entry["disturbed"])]
    return found
