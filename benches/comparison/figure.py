"""docs/pictures/comparison.svg: times above, errors below."""

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

INK, RULE = "#1c2228", "#d5dae0"
COLOURS = {
    "ours, C": "#0072b2", "Pinocchio C++": "#d55e00", "CasADi C from Pinocchio": "#e69f00", "MuJoCo": "#009e73",
    "dynibo": "#cc79a7", "ours, trace": "#0072b2", "ours, fit": "#56b4e9", "MuJoCo sysid": "#009e73",
    "PySINDy": "#e69f00", "plain regression": "#cc79a7",
}
MARKS = {"ours, trace": "o", "ours, fit": "s", "MuJoCo sysid": "^", "PySINDy": "D", "plain regression": "v"}
LIBRARY_MARKS = {"ours, C": "o", "Pinocchio C++": "s", "CasADi C from Pinocchio": "D", "MuJoCo": "^", "dynibo": "v"}
SHORT = {"mass": "M", "bias": "bias", "both": "both", "forward": "forward\ndynamics",
         "inverse_by": "∂ inverse\ndynamics", "forward_by": "∂ forward\ndynamics"}


def times(axes, robot):
    """Times of one robot, in microseconds."""
    libraries = [name for name in COLOURS if any(name in found for found in robot["nanoseconds"].values())]
    for i, function in enumerate(SHORT):
        found = robot["nanoseconds"][function]
        heights = [time / 1e3 for time in found.values()]
        axes.plot([i, i], [min(heights), max(heights)], color=RULE, linewidth=5, zorder=1, solid_capstyle="butt")
    for k, library in enumerate(libraries):
        there = [(i, robot["nanoseconds"][f][library] / 1e3) for i, f in enumerate(SHORT)
                 if library in robot["nanoseconds"][f]]
        x, y = zip(*there)
        shift = (k - (len(libraries) - 1) / 2) * 0.07
        axes.plot([i + shift for i in x], y, LIBRARY_MARKS[library], color=COLOURS[library], label=library, markersize=8,
                  markeredgecolor="white", markeredgewidth=0.6, zorder=3)
    axes.set_yscale("log")
    axes.set_xticks(range(len(SHORT)), SHORT.values())
    axes.set_title(robot["title"], fontsize=11, color=INK)


def dots(axes, machines):
    """Errors of predictions: from the model's, by a line, to the true machine's."""
    for i, machine in enumerate(machines):
        y = len(machines) - 1 - i
        axes.plot([machine["floor"], machine["before"]], [y, y], color=RULE, linewidth=6, zorder=1, solid_capstyle="butt")
        for x, words in ((machine["floor"], "floor"), (machine["before"], "before")):
            axes.plot([x, x], [y - 0.38, y + 0.38], color=INK, linewidth=1.5, zorder=2)
            if i == 1:
                axes.annotate(words, (x, y + 0.42), ha="center", va="bottom", fontsize=9, color=INK)
        for k, answer in enumerate(machine["answers"]):
            shift = (2 - k) * 0.13
            axes.plot(answer["error"], y + shift, MARKS[answer["tool"]], color=COLOURS[answer["tool"]], markersize=6.5,
                      markeredgecolor="white", markeredgewidth=0.6, zorder=3, label=answer["tool"] if i == 0 else None)
    axes.set_xscale("log")
    axes.set_yticks(range(len(machines)), [m["title"] for m in reversed(machines)])
    axes.set_xlabel("error of one-second predictions of a held-out log, as a share of what positions vary by", color=INK)


def draw(results, path):
    """Draws the figure."""
    plt.rcParams.update({"font.size": 10, "svg.hashsalt": "comparison", "axes.edgecolor": RULE, "text.color": INK,
                         "xtick.color": INK, "ytick.color": INK, "axes.spines.top": False, "axes.spines.right": False})
    robots, machines = results["speed"]["robots"], results["machines"]["machines"]
    picture = plt.figure(figsize=(12, 9.6), layout="constrained")
    above, below = picture.subfigures(2, 1, height_ratios=[1, 1.15])
    upper = above.subplots(1, len(robots), sharey=True)
    for axes, robot in zip(upper, robots):
        times(axes, robot)
        axes.grid(axis="y", color=RULE, linewidth=0.6)
        axes.set_axisbelow(True)
    for axes in upper:
        axes.yaxis.set_major_formatter("{x:g}")
        axes.tick_params(axis="x", labelsize=8.5)
    upper[0].set_ylabel("microseconds of one evaluation", color=INK)
    handles, labels = upper[0].get_legend_handles_labels()
    above.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    lower = below.subplots()
    dots(lower, machines)
    lower.xaxis.set_major_formatter("{x:g}")
    lower.grid(axis="x", color=RULE, linewidth=0.6)
    handles, labels = lower.get_legend_handles_labels()
    below.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.savefig(path, metadata={"Date": None}, facecolor="white")
    plt.close(picture)
