"""Rates with Wilson intervals, errors, calibration and times of traced machines, and two runs beside each other."""

import math
from collections import defaultdict


def wilson(hits, count, z=1.96):
    """95 % interval of a rate."""
    if count == 0:
        return 0.0, 1.0
    rate, square = hits / count, z * z
    middle = (rate + square / (2 * count)) / (1 + square / count)
    half = z / (1 + square / count) * math.sqrt(rate * (1 - rate) / count + square / (4 * count * count))
    return max(0.0, middle - half), min(1.0, middle + half)


def rate(lines, field):
    """A rate with its interval, as text."""
    hits = sum(bool(x[field]) for x in lines)
    low, high = wilson(hits, len(lines))
    return f"{hits:3d}/{len(lines):<3d} {100 * hits / max(len(lines), 1):5.1f} % [{100 * low:3.0f}, {100 * high:3.0f}]"


def quantile(values, share):
    """The value below which this share lies, as one of them; not a number of none."""
    ordered = sorted(values)
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)] if ordered else math.nan


def rates(lines, details):
    """The tables of rates; `details` also by effect, system, noise and size."""
    def block(title, group):
        print(f"\n{title:28s} {'exact':24s} {'accepted':24s} leading")
        groups = defaultdict(list)
        for x in lines:
            for g in group(x):
                groups[g].append(x)
        for g in sorted(groups):
            print(f"{g:28s} {rate(groups[g], 'exact')}  {rate(groups[g], 'accepted')}  {rate(groups[g], 'leading')}")
    block("class / wanted verdict", lambda x: [f"{x['class']} -> {x['wanted']}", "all"])
    if any("disturbed" in x for x in lines):
        block("disturbed by", lambda x: [" + ".join(x["disturbed"]) or "nothing"] if "disturbed" in x else [])
    if details:
        block("effect", lambda x: sorted({t[0] for t in x["truth"]}) or ["-"])
        block("system", lambda x: [x["system"]])
        block("noise level", lambda x: [str(x["noise"])])
        block("size (times the floor)", lambda x: [] if x["size"] is None else
              ["2 to 3" if x["size"] < 3 else "3 to 6" if x["size"] < 6 else "6 and more"])
    named = [x for x in lines if x["class"] != "none" and x["wanted"] != "unknown"]
    print(f"\nfirst finding strictly true: {rate(named, 'leading')}; where the truth has no twin: "
          f"{rate([x for x in named if not x['twin']], 'leading')}")
    print(f"exact where the truth has no twin: {rate([x for x in lines if not x['twin']], 'exact')}")


def figures(lines):
    """Errors over the floor, calibration of the standard errors, and processor time."""
    over = [x["score"]["after"][0] / x["floor"] for x in lines
            if x.get("score") and x["floor"] and x["wanted"] != "unknown"]
    if over:
        print(f"error after over that of the true machine: median {quantile(over, 0.5):.3f}, "
              f"90 % {quantile(over, 0.9):.3f}, worst {max(over):.3f}")
    inside = [abs(t - v) / s for x in lines for _, t, v, s in x.get("estimates", []) if s and math.isfinite(s)]
    if inside:
        print(f"estimates: {len(inside)}; within 1, 2, 3 standard errors:",
              *(f"{sum(z < k for z in inside) / len(inside):.3f}" for k in (1, 2, 3)))
    times = [x["cpu"] for x in lines]
    print(f"processor seconds: median {quantile(times, 0.5):.1f}, 90 % {quantile(times, 0.9):.1f}, "
          f"worst {max(times):.1f}, in all {sum(times):.0f}; largest memory {max(x['memory'] for x in lines):.0f} MB")


def show(keys):
    """Effects at their places, as text."""
    return " + ".join(f"{name}({','.join(on)})" for name, on in keys) or "-"


def missed(lines):
    """What was not accepted, machine by machine."""
    print("\nnot accepted:")
    for x in lines:
        if not x["accepted"]:
            print(f"  {x['id']:32s} {x['wanted']:9s} {show(x['truth']):44s} -> {x['verdict']}: {show(x['found'])}"
                  f"{' ' + x['error'] if 'error' in x else ''}")


def measured(lines):
    """What is said of measured logs."""
    print(f"\n{'measured log':20s} {'verdict':9s} {'before':>8s} {'after':>8s} {'floor':>8s} {'cpu s':>7s}  findings")
    for x in lines:
        # A model that cannot move as given has no error.
        errors = (x["score"][k][0] if x.get("score") else None for k in ("before", "after", "noise_floor"))
        before, after, floor = (math.nan if error is None else error for error in errors)
        print(f"{x['id']:20s} {x['verdict']:9s} {before:8.4f} {after:8.4f} {floor:8.4f} {x['cpu']:7.1f}  "
              f"{show(x['found'])}{' ' + x['error'] if 'error' in x else ''}")


def beside(first, second, look):
    """Two runs on the same machines: what changed class by class and, where one may look, machine by machine."""
    known = {x["id"]: x for x in first}
    pairs = [(known[x["id"]], x) for x in second if x["id"] in known]
    if not pairs:
        print("no machine is in both runs")
        return
    print(f"{len(pairs)} machines in both runs; exact before and after, gained, lost")
    groups = defaultdict(list)
    for a, b in pairs:
        for g in (f"{b['class']} -> {b['wanted']}", "all"):
            groups[g].append((a, b))
    for g in sorted(groups):
        both = groups[g]
        gained = sum(b["exact"] and not a["exact"] for a, b in both)
        lost = sum(a["exact"] and not b["exact"] for a, b in both)
        print(f"  {g:28s} {sum(a['exact'] for a, _ in both):3d} -> {sum(b['exact'] for _, b in both):3d} of {len(both):3d}"
              f"   +{gained} -{lost}")
    ratios = [b["cpu"] / a["cpu"] for a, b in pairs if a["cpu"] > 0]
    for name, share in (("median", 0.5), ("90 %", 0.9)):
        before, after = (quantile([x[i]["cpu"] for x in pairs], share) for i in (0, 1))
        print(f"  processor seconds, {name}: {before:.1f} -> {after:.1f} ({after / before:.2f} times)")
    print(f"  machine by machine: {quantile(ratios, 0.5):.2f} times in the median, {max(ratios):.2f} at most")
    if look:
        for a, b in pairs:
            if a["exact"] != b["exact"] or a["verdict"] != b["verdict"]:
                print(f"  {b['id']:32s} {show(b['truth'])}: {a['verdict']} {show(a['found'])} -> {b['verdict']} "
                      f"{show(b['found'])}")
