"""What a fleet's tables say of its machines: `python summary.py TABLES`.

Writes `TABLES/fleet.html`, a page, and `TABLES/fleet.json`, the same for programs:

- A machine *has* what is found in more than half of its readable logs.
- A number *drifts* if Kendall's test of it against time has a p-value below 1 % divided by the
  number of tests made. The drift is Theil's and Sen's slope.
- A log is an *outlier* if what is found in it is not what its machine has, nor something that the log
  cannot tell from it; or if a number lies further from the machine's line over time than five
  standard deviations: the spread about the line, as the median says it, together with its own.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from page import page
from scipy import stats

SIGNIFICANCE = 0.01
FAR = 5.0
MAD_TO_STD = 1.4826


def usual(logs: pd.DataFrame, found: pd.Series[str]) -> list[str]:
    """What a machine has; `found` has a row for every log and finding."""
    counts = found.groupby(found).size()
    return sorted(str(name) for name, count in counts.items() if count > len(logs) / 2)


def lines(numbers: pd.DataFrame, origin: pd.Timestamp) -> list[dict[str, Any]]:
    """Each number of a machine over time, in years from `origin`."""
    result = []
    for (finding, parameter), of in numbers.groupby(["finding", "parameter"]):
        years = ((of["time"] - origin) / pd.Timedelta(days=365.25)).to_numpy()
        values = of["value"].to_numpy()
        if len(of) < 3:
            continue
        slope, intercept, _, _ = stats.theilslopes(values, years)
        off = values - (intercept + slope * years)
        spread = np.hypot(MAD_TO_STD * np.median(np.abs(off)), of["std"].to_numpy())
        result.append(
            {
                "finding": finding,
                "parameter": parameter,
                "unit": of["unit"].iloc[0],
                "median": float(np.median(values)),
                "per_year": float(slope),
                "p_value": float(stats.kendalltau(years, values).pvalue),
                "far": list(of["log"][np.abs(off) > FAR * spread]),
                "dates": list(of["date"]),
                "values": values.tolist(),
            }
        )
    return result


def differing(machine: dict[str, Any], rivals: dict[str, str]) -> set[str]:
    """The logs that contradict what a machine has; `rivals` are by log and finding."""

    def agrees(log: str, found: str) -> bool:
        could_be = {found, *rivals.get(log + found, "").split("; ")}
        return not could_be.isdisjoint(machine["has"])

    return {
        log
        for log, found in machine["logs"].items()
        if len(found) != len(machine["has"]) or not all(agrees(log, f) for f in found)
    }


def fleet(logs: pd.DataFrame, numbers: pd.DataFrame) -> dict[str, Any]:
    """What is said of the fleet."""
    numbers = numbers.assign(
        finding=numbers["effect"] + " (" + numbers["on"] + ")", time=pd.to_datetime(numbers["date"])
    )
    rivals = dict(zip(numbers["log"] + numbers["finding"], numbers["rivals"], strict=True))
    machines = {}
    for name, of in logs.groupby("machine"):
        readable = of[of["error"].isna()]
        own = numbers[numbers["machine"] == name]
        each = own.drop_duplicates(["log", "finding"])
        by_log = {
            log: sorted(each["finding"][each["log"] == log]) or [str(verdict)]
            for log, verdict in zip(readable["log"], readable["verdict"], strict=True)
        }
        # "none" and "unknown" are findings here: every log has one.
        has = usual(readable, pd.Series([f for found in by_log.values() for f in found], dtype="str"))
        machines[str(name)] = {
            "has": has,
            "logs": by_log,
            "numbers": lines(own[own["finding"].isin(has)], numbers["time"].min()),
        }
    tests = sum(len(machine["numbers"]) for machine in machines.values())
    for machine in machines.values():
        for line in machine["numbers"]:
            line["drifts"] = line["p_value"] < SIGNIFICANCE / tests
        far = {log for line in machine["numbers"] for log in line["far"]}
        machine["outliers"] = sorted(far | differing(machine, rivals))
    unusable = logs[logs["error"].notna()]
    return {
        "logs": len(logs),
        "tests_of_drift": tests,
        "machines": machines,
        "unusable": dict(zip(unusable["log"], unusable["error"], strict=True)),
    }


def main() -> None:
    """Writes the page and its numbers."""
    tables = Path(sys.argv[1])
    logs = pd.read_parquet(tables / "logs.parquet")
    said = fleet(logs, pd.read_parquet(tables / "findings.parquet"))
    (tables / "fleet.json").write_text(json.dumps(said, indent=2) + "\n")
    (tables / "fleet.html").write_text(page(said))
    print(f"{len(said['machines'])} machines in {tables / 'fleet.html'}")


if __name__ == "__main__":
    main()
