"""Draws docs/pictures/loop.svg from one run of `dynamics trace`:

    cargo run --release -- trace models/pendulum2.model \
        tests/data/scenarios/o01_pendulum2/train.csv.gz \
        --test tests/data/scenarios/o01_pendulum2/test.csv.gz --report target/loop
    python3 docs/pictures/loop.py target/loop > docs/pictures/loop.svg

Needs nothing but Python. Every curve, dot and number is read from the report.
"""

import json
import sys
from pathlib import Path
from xml.sax.saxutils import escape

BEFORE, AFTER, FLOOR, MEASURED = "#d55e00", "#0072b2", "#7d8790", "#b9bfc7"
INK, SOFT, RULE = "#1c2228", "#5b6570", "#d5dae0"
SANS = "system-ui,'Segoe UI','Helvetica Neue','DejaVu Sans',sans-serif"
MONO = "ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace"
WIDTH, HEIGHT = 1000, 500


class Picture:
    def __init__(self):
        self.parts = []

    def add(self, text):
        self.parts.append(text)

    def text(self, x, y, words, size=15, colour=INK, anchor="start", weight="normal", mono=False):
        font = f' font-family="{MONO}" xml:space="preserve"' if mono else ""
        self.add(
            f'<text x="{x:g}" y="{y:g}" font-size="{size}" fill="{colour}" text-anchor="{anchor}"'
            f' font-weight="{weight}"{font}>{escape(words)}</text>'
        )

    def title(self, x, y, number, words):
        self.add(f'<circle cx="{x + 11}" cy="{y - 5}" r="11" fill="{INK}"/>')
        self.text(x + 11, y, str(number), 14, "#fff", "middle", "bold")
        self.text(x + 30, y, words, 16, weight="bold")

    def box(self, x, y, width, height, fill="#f6f8fa"):
        self.add(
            f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="5" fill="{fill}"'
            f' stroke="{RULE}"/>'
        )

    def line(self, points, colour, width=2.0, dash=""):
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.add(
            f'<polyline fill="none" stroke="{colour}" stroke-width="{width}"{dash}'
            f' stroke-linejoin="round" points="{points}"/>'
        )

    def arrow(self, x, y, length=20):
        self.line([(x, y), (x + length - 5, y)], INK, 2)
        self.add(f'<path d="M{x + length} {y} l-9 -5 v10 z" fill="{INK}"/>')


class Axes:
    """Data to places inside a rectangle."""

    def __init__(self, place, x, y):
        self.left, self.top, self.width, self.height = place
        self.x, self.y = x, y

    def at(self, x, y):
        across = (x - self.x[0]) / (self.x[1] - self.x[0])
        up = (y - self.y[0]) / (self.y[1] - self.y[0])
        return self.left + across * self.width, self.top + (1 - up) * self.height

    def frame(self, picture, xs, ys, form):
        for y in ys:
            place = self.at(self.x[0], y)[1]
            picture.line([(self.left, place), (self.left + self.width, place)], RULE, 1)
            picture.text(self.left - 6, place + 4, form.format(y), 12, SOFT, "end")
        bottom = self.top + self.height
        for x in xs:
            place = self.at(x, self.y[0])[0]
            picture.line([(place, bottom), (place, bottom + 4)], SOFT, 1)
            picture.text(place, bottom + 18, f"{x:g}", 12, SOFT, "middle")


def main(folder):
    report = json.loads((folder / "report.json").read_text())
    series = json.loads((folder / "series.json").read_text())["series"]
    joint = next(c for c in series["coordinates"] if c["name"] == "j2")
    finding = report["findings"][0]
    damping = finding["parameters"]["d"]
    assert (finding["effect"], finding["on"]) == ("viscous", ["j2"])
    picture = Picture()

    # The model.
    picture.title(20, 36, 1, "The model you have")
    picture.box(20, 50, 268, 124)
    lines = [
        "coordinate j2: rad;",
        "input j2: N*m;",
        "body link2 { mass: m2; … }",
        "gravity (0, -g, 0);",
        "force j2 = input(j2);",
    ]
    for i, line in enumerate(lines):
        picture.text(32, 73 + 22 * i, line, 14, mono=True)
    picture.text(20, 194, "or a URDF file; it also becomes Rust and C", 13, SOFT)

    # The log, and what the model makes of it.
    picture.title(20, 236, 2, "The log you measured")
    predicted = joint["prediction"]
    # Windows are set apart by samples without a time; three of them fit.
    times = series["prediction_t"]
    count = [i for i, t in enumerate(times) if t is None][2]
    known = [t for t in times[:count] if t is not None]
    axes = Axes((62, 258, 226, 152), (known[0], known[-1]), (0.0, 1.0))
    values = [v for name in ("measured", "before") for v in predicted[name][:count] if v is not None]
    low, high = min(values), max(values)
    axes.y = (low - 0.08 * (high - low), high + 0.08 * (high - low))
    ticks = [n / 2 for n in range(-20, 21) if axes.y[0] < n / 2 < axes.y[1]]
    axes.frame(picture, [0.5, 1.0, 1.5], ticks, "{:g}")
    for name, colour, width in (("measured", MEASURED, 6), ("before", BEFORE, 2)):
        piece = []
        for x, y in zip(times[:count], predicted[name]):
            if x is None or y is None:
                picture.line(piece, colour, width)
                piece = []
            else:
                piece.append(axes.at(x, y))
        if piece:
            picture.line(piece, colour, width)
    picture.text(62, 448, "angle of j2, rad, over time, s", 13, SOFT)
    picture.line([(62, 468), (80, 468)], MEASURED, 6)
    picture.text(86, 472, "measured", 13)
    picture.line([(158, 468), (176, 468)], BEFORE, 2)
    picture.text(182, 472, "model, 0.5 s ahead", 13)

    # The missing force.
    picture.arrow(298, 112)
    picture.arrow(298, 330)
    picture.title(330, 36, 3, "The force that is missing")
    axes = Axes((388, 56, 262, 322), (-6.5, 6.5), (-0.16, 0.16))
    axes.frame(picture, [-6, -3, 0, 3, 6], [-0.15, -0.1, -0.05, 0, 0.05, 0.1, 0.15], "{:g}")
    for v, force in zip(joint["velocity"], joint["force_before"]):
        x, y = axes.at(v, force)
        picture.add(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.4" fill="{BEFORE}" opacity=".55"/>')
    ends = [axes.at(v, -damping["value"] * v) for v in axes.x]
    picture.line(ends, AFTER, 3)
    picture.text(519, 412, "velocity of j2, rad/s", 13, SOFT, "middle")
    picture.text(519, 438, "force on j2, N·m, that acts and is not in", 13, SOFT, "middle")
    picture.text(519, 455, "the model; each dot is a logged instant", 13, SOFT, "middle")
    law = f"the law found: −{damping['value']:.5f} N·m·s · velocity"
    picture.line([(358, 475), (378, 475)], AFTER, 3)
    picture.text(385, 480, law, 13)

    # What is written.
    picture.arrow(660, 112)
    picture.title(692, 36, 4, "The line it writes")
    picture.box(692, 50, 288, 124)
    picture.text(702, 75, " force j2 = input(j2);", 12.5, mono=True)
    picture.add('<rect x="693" y="86" width="286" height="30" fill="#dff5e3"/>')
    added = f"+effect viscous(j2) {{ d = {damping['value']:.6f} }}"
    picture.text(702, 106, added, 12.5, "#0b5c25", mono=True)
    sure = f"d = {damping['value']:.4f} ± {damping['std']:.4f} N·m·s"
    picture.text(702, 142, f"{sure}", 13, SOFT)
    picture.text(702, 161, "the simulated machine has 0.02", 13, SOFT)

    # Errors.
    picture.title(692, 236, 5, "How much better it is")
    errors = [
        ("before", report["before"], BEFORE),
        ("after", report["after"], AFTER),
        ("floor", report["noise_floor"], FLOOR),
    ]
    largest = report["before"]["acceleration"]["total"]
    for i, (name, score, colour) in enumerate(errors):
        error = score["acceleration"]["total"]
        y = 262 + 46 * i
        picture.text(748, y + 19, name, 15, anchor="end")
        picture.add(
            f'<rect x="758" y="{y}" width="{150 * error / largest:.1f}" height="28" fill="{colour}"/>'
        )
        picture.text(766 + 150 * error / largest, y + 19, f"{100 * error:.1f} %", 15)
    words = [
        "Error of the acceleration as a share of",
        "its size, on a log that nothing was",
        "fitted to. Floor: what the sensors’ noise",
        "alone leaves of a perfect model.",
    ]
    for i, line in enumerate(words):
        picture.text(692, 420 + 19 * i, line, 13, SOFT)

    alt = (
        "A model and a log go in. The missing force in joint j2, plotted over its velocity, lies on a "
        "straight line: viscous friction. One line is added to the model, and the error of the "
        "acceleration falls from {:.0f} to {:.0f} percent, the noise floor."
    )
    alt = alt.format(*(100 * report[k]["acceleration"]["total"] for k in ("before", "after")))
    print(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img"'
        f' font-family="{SANS}">'
    )
    print(f"<title>{escape(alt)}</title>")
    print(f'<rect width="{WIDTH}" height="{HEIGHT}" rx="8" fill="#fff"/>')
    print("\n".join(picture.parts))
    print("</svg>")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
