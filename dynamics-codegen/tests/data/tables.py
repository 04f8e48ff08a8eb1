#!/usr/bin/env python3
"""Writes tables.json: natural cubic splines by SciPy, which go on straight beyond their ends.

    python tables.py            write the file
    python tables.py --check    compare with what is there, at 1e-12
"""

import json
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

HERE = Path(__file__).resolve().parent


def straight(points, values, x, order):
    """Value or derivative of the spline, on the straight line beyond an end."""
    if len(points) == 2:
        points = np.array([points[0], np.mean(points), points[1]])
        values = np.array([values[0], np.mean(values, axis=0), values[1]])
    spline = CubicSpline(points, values, bc_type="natural")
    inside = np.clip(x, points[0], points[-1])
    if order == 0:
        return spline(inside) + (x - inside) * spline(inside, 1)
    if order == 2 and inside != x:
        return 0 * spline(inside)
    return spline(inside, order)


def line(rng, count):
    points = np.cumsum(rng.uniform(0.05, 2.0, count)) - count / 2
    values = rng.uniform(-3, 3, count)
    span = points[-1] - points[0]
    asked = [*points, points[0] - 2 * span, points[-1] + 0.3 * span, *rng.uniform(points[0], points[-1], 12)]
    answers = [[straight(points, values, x, order).item() for order in (0, 1, 2)] for x in asked]
    return {"points": points.tolist(), "values": values.tolist(), "at": [float(x) for x in asked],
            "answers": answers}


def grid(rng, rows, columns):
    x, y = np.cumsum(rng.uniform(0.2, 1.5, rows)), np.cumsum(rng.uniform(0.2, 1.5, columns))
    values = rng.uniform(-3, 3, (rows, columns))
    asked = [(x[0] - 1, y[1]), (x[-1] + 2, y[-1] + 1), (x[1], y[0]),
             *zip(rng.uniform(x[0], x[-1], 12), rng.uniform(y[0], y[-1], 12))]
    orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    answers = [[straight(x, np.array([straight(y, row, b, j).item() for row in values]), a, i).item()
                for i, j in orders] for a, b in asked]
    return {"x": x.tolist(), "y": y.tolist(), "values": values.tolist(),
            "at": [[float(a), float(b)] for a, b in asked], "answers": answers}


def main():
    rng = np.random.default_rng(20260)
    made = {"lines": [line(rng, n) for n in (2, 3, 4, 9, 40)],
            "grids": [grid(rng, 2, 3), grid(rng, 5, 4), grid(rng, 8, 11)]}
    file = HERE / "tables.json"
    if "--check" not in sys.argv[1:]:
        file.write_text(json.dumps(made) + "\n")
        return 0
    found = json.loads(file.read_text())
    for kind in made:
        for new, old in zip(made[kind], found[kind], strict=True):
            np.testing.assert_allclose(new["answers"], old["answers"], rtol=1e-12, atol=1e-12)
    return 0


if __name__ == "__main__":
    sys.exit(main())
