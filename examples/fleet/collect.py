"""Makes two tables of a fleet's answers: `python collect.py ANSWERS TABLES`.

`TABLES/logs.parquet` has a row per log: machine, date, verdict, errors before, after and at the
floor, or why it cannot be used. `TABLES/findings.parquet` has a row per number of a finding: log,
effect, on, parameter, value, standard deviation, unit, evidence, and what the log cannot tell it from.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pandas as pd

LOGS = {
    "log": "str",
    "machine": "str",
    "date": "str",
    "verdict": "str",
    "before": "float64",
    "after": "float64",
    "floor": "float64",
    "error": "str",
}
FINDINGS = {
    "log": "str",
    "machine": "str",
    "date": "str",
    "effect": "str",
    "on": "str",
    "parameter": "str",
    "value": "float64",
    "std": "float64",
    "unit": "str",
    "evidence": "float64",
    "rivals": "str",
}


def rivals(finding: dict[str, Any]) -> str:
    """What the log cannot tell from a finding, as `effect (on)`."""
    each = [f"{r['effect']} ({', '.join(r['on'])})" for r in finding["confounded_with"]]
    return "; ".join(each)


def rows(answer: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """The row of a log, and those of its findings."""
    machine, _, date = answer.stem.partition("_")
    whose = {"log": answer.stem, "machine": machine, "date": date}
    if answer.suffix == ".error":
        return whose | {"error": answer.read_text().strip()}, []
    found = json.loads(answer.read_text())
    # Shares of the accelerations' own size.
    scores = {"before": "before", "after": "after", "floor": "noise_floor"}
    errors = {name: found[score]["acceleration"]["total"] for name, score in scores.items()}
    numbers = [
        whose
        | {"effect": finding["effect"], "on": ", ".join(finding["on"])}
        | {"parameter": name, "evidence": finding["evidence"], "rivals": rivals(finding)}
        | {key: number[key] for key in ("value", "std", "unit")}
        for finding in found["findings"]
        for name, number in finding["parameters"].items()
    ]
    return whose | {"verdict": found["verdict"]} | errors, numbers


def main() -> None:
    """Writes the tables."""
    answers, tables = map(Path, sys.argv[1:])
    # What begins with a dot was being written when its program was killed.
    there = sorted(path for path in answers.iterdir() if not path.name.startswith("."))
    each = [rows(path) for path in there if path.suffix in (".json", ".error")]
    logs = [log for log, _ in each]
    findings = [number for _, numbers in each for number in numbers]
    tables.mkdir(parents=True, exist_ok=True)
    for name, table, columns in (("logs", logs, LOGS), ("findings", findings, FINDINGS)):
        frame = pd.DataFrame(table, columns=list(columns)).astype(columns)
        frame.to_parquet(tables / f"{name}.parquet", index=False)
        print(f"{len(frame)} rows in {tables / name}.parquet")


if __name__ == "__main__":
    main()
