"""Whether an answer of `dynamics trace` is right, given the truth of a simulated machine.

A machine counts as

    leading   the first finding is a true effect at its true place
    exact     all true effects are found and nothing else, and the verdict is right
    accepted  as exact, but a stated rival of a finding or a near-equivalent of the
              truth (r2 >= 0.9 between their accelerations) counts as the truth

A truth that has a twin, an effect of the library whose accelerations are the same in all digits
(a constant force on a driven coordinate and a bias of its input), is not identifiable: no log
tells which of the two is first.
"""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CHANNEL = ("input_", "dead_band", "saturation", "backlash", "measurement_", "time_shift", "mounting_")


def library():
    """Names of the effect templates that the program has."""
    return {p.stem for p in (ROOT / "models/effects").glob("*.model")}


def key(effect, on):
    """An effect at its places, as compared."""
    return effect, tuple(sorted(on))


def true_key(truth, effect):
    """The same of a true effect; an arm's parameters are called as its description's."""
    names = {"m": "mass", "lc": "cz", "I": "iyy"}
    on = effect["on"]
    if truth["system"] == "planar_arm" and effect["type"] == "parameter":
        split = [re.fullmatch(r"([a-zA-Z]+)(\d+)", name) for name in on]
        # A length is where the next joint stands.
        on = [f"j{int(m[2]) + 1}_origin_z" if m[1] == "l" else f"link{m[2]}_{names.get(m[1], m[1])}"
              for m in split]
    if truth["system"] == "unicycle2d":
        on = ["vehicle" if name == "body" else name for name in on]
    return key(effect["type"], on)


def wanted_verdict(truth, known):
    """What the report should say; `unknown` where the library lacks the effect."""
    if truth["class"] in ("none", "parameter"):
        return {truth["class"]}
    names = [e["type"] for e in truth["effects"]]
    if any(n not in known for n in names):
        return {"unknown"}
    if all(n.startswith(CHANNEL) for n in names):
        return {"channel"}
    return {"effect"}


def judge(name, truth, report, known):
    """One line of results of a simulated machine."""
    true = [true_key(truth, e) for e in truth["effects"]]
    near = [{true_key(truth, n) for n in e["near_equivalents"]} for e in truth["effects"]]
    visible = [e["visibility"] for e in truth["effects"] if e["visibility"] is not None]
    line = {"id": name, "system": truth["system"], "class": truth["class"], "noise": truth["noise_level"],
            "hold": truth["hold"], "truth": true, "wanted": sorted(wanted_verdict(truth, known))[0],
            "size": min(visible, default=None), "twin": has_twin(truth),
            "floor": truth["oracle"]["test"]["acc_nrmse_floor"], "estimates": []}
    if "disturbed" in truth:
        line["disturbed"] = sorted(truth["disturbed"])
    line |= answer(report, true, near, line["wanted"])
    return line if "error" in report else line | {"estimates": estimates(truth, report)}


def judge_scenario(name, entry, report, _):
    """One line of results of a log whose truth is written down as text, `coulomb(x)`."""
    true = [key(effect, on.split(",")) for effect, on in (t.rstrip(")").split("(") for t in entry["truth"])]
    line = {"id": name, "system": name.split("_", 1)[1], "class": "scenario", "noise": 1.0, "hold": "", "truth": true,
            "wanted": entry["wanted"], "size": None, "twin": False, "floor": entry["floor"], "estimates": []}
    return line | answer(report, true, [set()] * len(true), entry["wanted"])


def judge_measured(name, _, report, __):
    """One line of results of a measured log: nothing is right or wrong there, but to have an answer."""
    line = {"id": name, "truth": [], "wanted": ""} | answer(report, [], [], "")
    return line | {"accepted": "error" not in report}


def findings_of(report):
    """What is named: findings, and behind them what only comes nearest."""
    return report["findings"] + (report.get("nearest") or {}).get("findings", [])


def answer(report, true, near, wanted):
    """What a report says, and whether that is right; `near` are the equivalents of each true effect."""
    if "error" in report:
        return {"error": report["error"], "exact": False, "accepted": False, "leading": False, "verdict": "error",
                "found": []}
    findings = findings_of(report)
    found = [key(f["effect"], f["on"]) for f in findings]
    rivals = [{key(r["effect"], r["on"]) for r in f["confounded_with"]} | {own}
              for f, own in zip(findings, found)]
    exact = report["verdict"] == wanted and sorted(found) == sorted(true)
    if wanted == "unknown":
        exact = accepted = leading = report["verdict"] == "unknown"
    else:
        def is_one(i, own):
            return any(t in rivals[i] or own in near[j] for j, t in enumerate(true))
        covered = all(any(t in rivals[i] or found[i] in near[j] for i in range(len(found)))
                      for j, t in enumerate(true))
        # A name beside the verdict that nothing explains the log is no explanation.
        accepted = (report["verdict"] != "unknown" and covered and len(found) <= len(true)
                    and all(is_one(i, own) for i, own in enumerate(found)))
        leading = bool(true) and bool(found) and found[0] in true
    score = {k: (report[k]["acceleration"]["total"], report[k]["rollout"]["total"]) for k in
             ("before", "after", "noise_floor")}
    return {"verdict": report["verdict"], "found": found, "rivals": [sorted(r) for r in rivals], "exact": exact,
            "accepted": exact or accepted, "leading": leading, "score": score, "remaining": report.get("remaining"),
            "misfit": report.get("misfit_after")}


# Near-equivalents that are this near are the same law.
TWIN = 0.9999


def has_twin(truth):
    """Whether no log can tell one of the true effects from another effect."""
    return any(n["r2"] >= TWIN for e in truth["effects"] for n in e["near_equivalents"])


SAME = {"f_c": ("Fc", "f_c"), "v_s": ("vs", "v_s"), "q_0": ("q0",), "gain": ("c",), "bias": ("u0",), "c": ("c",), "d": ("d",),
        "k": ("k",), "f": ("f",), "tau": ("tau", "T"), "mu": ("mu",), "offset": ("offset",),
        "scale": ("scale",), "phi_x": ("phi_x",), "phi_y": ("phi_y",), "phi_z": ("phi_z",)}


def estimates(truth, report):
    """(name, true, value, standard error) where names can be matched."""
    found = []
    for e in truth["effects"]:
        for f in findings_of(report):
            if key(f["effect"], f["on"]) != key(e["type"], e["on"]):
                continue
            for name, p in f["parameters"].items():
                if e["type"] == "parameter":
                    found.append((name, e["params"]["true"], p["value"], p["std"]))
                for other in SAME.get(name, ()):
                    if other in e["params"]:
                        found.append((f"{e['type']}.{name}", e["params"][other], p["value"], p["std"]))
    return found
