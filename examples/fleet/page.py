"""What `summary.py` says of a fleet, as a page of its own without scripts."""

from __future__ import annotations

from html import escape
from typing import Any

COLOURS = ["#4e79a7", "#f28e2b", "#59a14f", "#b07aa1", "#edc948", "#76b7b2", "#ff9da7", "#9c755f"]
NOTHING, OTHER = "#e4e4e4", "#444444"
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { text-align: left; padding: .15em .6em; vertical-align: top; }
.map td { width: 1.1em; min-width: 1.1em; height: 1.3em; padding: 0; border: 1px solid #fff; }
.map td.odd { border: 2px solid #c00; }
.map td.lost { text-align: center; line-height: 1; }
.map th { font-weight: normal; }
.map thead th { writing-mode: vertical-rl; padding: .3em 0; font-size: 80%; }
.key { display: inline-block; width: 1em; height: 1em; margin: 0 .3em 0 1em; vertical-align: -.15em; }
td:first-child { white-space: nowrap; }
svg { display: block; }
"""


def page(said: dict[str, Any]) -> str:
    """The page: a map of machines and dates, what each machine has, outliers, unusable logs."""
    machines, unusable = said["machines"], said["unusable"]
    colours = colour_of(machines)
    outliers = [log for machine in machines.values() for log in machine["outliers"]]
    drifting = [n for n, m in machines.items() if any(line["drifts"] for line in m["numbers"])]
    body = [
        f"<h1>{len(machines)} machines, {said['logs']} logs</h1>",
        f"<p>{len(drifting)} machines drift, {len(outliers)} logs are outliers, {len(unusable)}"
        " cannot be used.</p>",
        "<h2>Which effect on which machine</h2>",
        f"<p>{legend(colours)}</p>",
        heat_map(machines, unusable, colours),
        "<h2>Machines</h2>",
        table(["machine", "has", "number", "median", "drift per year", ""], machine_rows(machines)),
        f"<p>A drift is stated where chance makes it in one of {100 * said['tests_of_drift']} cases"
        f" or less: one in a hundred over all {said['tests_of_drift']} numbers.</p>",
        "<h2>Outliers</h2>",
        table(["log", "found", "the machine has"], outlier_rows(machines)),
        "<h2>Logs that cannot be used</h2>",
        table(["log", "why"], [[escape(log), pre(why)] for log, why in unusable.items()]),
    ]
    return (
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>A fleet</title>'
        f"<style>{STYLE}</style>\n" + "\n".join(body) + "\n</html>\n"
    )


def colour_of(machines: dict[str, Any]) -> dict[str, str]:
    """A colour for each finding, the commonest first; the rest share one."""
    found = ["; ".join(f) for machine in machines.values() for f in machine["logs"].values()]
    names = sorted(set(found) - {"none"}, key=lambda name: (-found.count(name), name))
    colours = {"none": NOTHING}
    return colours | {n: COLOURS[k] if k < len(COLOURS) else OTHER for k, n in enumerate(names)}


def legend(colours: dict[str, str]) -> str:
    """Names of the colours of the map."""
    keys = [f'<span class="key" style="background:{c}"></span>{escape(n)}' for n, c in colours.items()]
    return "".join(keys) + "<br>Outliers have a red frame; × is a log that cannot be used."


def heat_map(machines: dict[str, Any], unusable: dict[str, str], colours: dict[str, str]) -> str:
    """A row per machine, a column per date; what was found, as a colour."""
    logs = {log for machine in machines.values() for log in machine["logs"]} | set(unusable)
    dates = sorted({log.partition("_")[2] for log in logs})
    rows = []
    for name, machine in machines.items():
        cells = [cell(f"{name}_{date}", machine, unusable, colours) for date in dates]
        rows.append(f"<tr><th>{escape(name)}</th>{''.join(cells)}</tr>")
    head = "".join(f"<th>{escape(date)}</th>" for date in dates)
    return f'<table class="map"><thead><tr><th></th>{head}</tr></thead>{"".join(rows)}</table>'


def cell(log: str, machine: dict[str, Any], unusable: dict[str, str], colours: dict[str, str]) -> str:
    """A log on the map."""
    if log in unusable:
        return f'<td class="lost" title="{escape(log)}: cannot be used">×</td>'
    if log not in machine["logs"]:
        return "<td></td>"
    found = "; ".join(machine["logs"][log])
    kind = ' class="odd"' if log in machine["outliers"] else ""
    title = escape(f"{log}: {found}")
    return f'<td{kind} style="background:{colours[found]}" title="{title}"></td>'


def machine_rows(machines: dict[str, Any]) -> list[list[str]]:
    """What each machine has, with its numbers; a drawing where one drifts."""
    rows = []
    for name, machine in machines.items():
        has = escape("; ".join(machine["has"]) or "undecided")
        for line in machine["numbers"] or [None]:
            row = [escape(name), has]
            if line is not None:
                unit = escape(line["unit"].replace("*", "·"))
                drift = f"<b>{line['per_year']:+.3g} {unit}</b>" if line["drifts"] else ""
                row += [escape(line["parameter"]), f"{line['median']:.4g} {unit}", drift]
                row.append(spark(line["values"]) if line["drifts"] else "")
            rows.append(row)
    return rows


def outlier_rows(machines: dict[str, Any]) -> list[list[str]]:
    """Each log that is not as its machine is."""
    rows = []
    for machine in machines.values():
        has = "; ".join(machine["has"])
        for log in machine["outliers"]:
            date = log.partition("_")[2]
            far = [
                f"{line['parameter']} = {line['values'][line['dates'].index(date)]:.3g}, where the"
                f" median is {line['median']:.3g}"
                for line in machine["numbers"]
                if log in line["far"]
            ]
            rows.append([escape(log), escape("; ".join(machine["logs"][log] + far)), escape(has)])
    return rows


def spark(values: list[float]) -> str:
    """A number that drifts over time as a small drawing, zero at the bottom (or top)."""
    low, high = min(*values, 0.0), max(*values, 0.0)
    across, up = 120 / (len(values) - 1), 24 / (high - low)
    points = [(3 + k * across, 27 - (v - low) * up) for k, v in enumerate(values)]
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2"/>' for x, y in points)
    return f'<svg width="126" height="30" fill="#4e79a7">{dots}</svg>'


def table(head: list[str], rows: list[list[str]]) -> str:
    """A table; its cells are HTML already."""
    if not rows:
        return "<p>None.</p>"
    first = "".join(f"<th>{escape(name)}</th>" for name in head)
    rest = "".join("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>" for row in rows)
    return f"<table><tr>{first}</tr>{rest}</table>"


def pre(text: str) -> str:
    """A message with its line breaks."""
    return escape(text).replace("\n", "<br>")
