"""Files of one machine, in the layout of the shared logs."""

import json

import numpy as np

import sensing
from machine import VISIBLE
from systems import MODELS

JITTERED = "%.6f"
SENSOR = "%.6g"
NUMBER = {"t": "%.4f", "q": "%.6f", "dq": "%.5f", "ddq": "%.4f", "u": "%.5f"}
NOISE_FREE = {"t": "%.4f", "q": "%.12g", "dq": "%.12g", "ddq": "%.12g", "u": "%.5f"}
PIPELINE = {
    "states": "q, dq: Savitzky-Golay order 4, window 0.15 s; dq from q if not logged",
    "measured_acceleration": "ddq if logged; else derivative of dq if logged; else second derivative of q",
    "prediction": "forward dynamics at these states and the logged u (mean of the two held values at a "
                  "sample), smoothed alike unless ddq is logged",
    "nrmse": "sqrt(mean over coordinates of (rmse_i / scale_acc_i)^2), scale_acc_i = sd of the acceleration",
}


def _short(values, digits=6):
    return [float(f"{x:.{digits}g}") for x in np.ravel(values)]


def _sensor(machine):
    """Sensor object; null for what is not logged."""
    logged = machine.columns
    return {"q_quantum": _short(machine.quantum), "q_sd": _short(machine.q_sd),
            "dq_sd": _short(machine.dq_sd) if "dq" in logged else None,
            "ddq_sd": _short(machine.ddq_sd) if "ddq" in logged else None}


def _head(name, machine):
    s = machine.system
    return {"id": name, "system": s.name, "variant": s.variant, "coords": list(s.coords),
            "inputs": list(s.inputs), "n_constraints": s.constraints}


def nominal(name, machine):
    """Contents of nominal.json."""
    return {**_head(name, machine), "rate_hz": machine.rate,
            "input_hold": "foh" if machine.first_order else "zoh",
            "nominal": machine.system.nominal_document(machine.nominal),
            "columns": machine.columns, "sensor": _sensor(machine)}


def _effect(machine, effect, visibility, near):
    """One entry of truth.effects."""
    kind = effect.kind
    if kind.family == "parameter":
        name = effect.where
        params = {"name": name, "nominal": machine.nominal[name], "true": effect.wrong_value(machine.nominal[name])}
    else:
        params = effect.parameters()
        if kind.family == "input":
            params = {"inputs": effect.on, **params}
        elif kind.name == "joint_coupling":
            params = {"coords": effect.on, **params}
        elif kind.name not in ("speed_drag", "rolling_resistance", "contact_friction", "payload", "com_offset",
                               "gravity_tilt"):
            params = {"coord": effect.on[0], **params}
    found = {"type": kind.name, "on": effect.on, "family": kind.family, "formula": kind.formula, "params": params,
             "visibility": float(f"{visibility:.4g}"), "near_equivalents": near}
    if machine.width is not None:
        numbers = effect.parameters()
        found["statement"] = (f"effect {kind.name}({effect.on[0]}) "
                              f"{{ f_c = {numbers['Fc']!r}, v_s = {numbers['vs']!r} }}")
    return found


def truth(name, machine, verdict, score, seed, index):
    """Contents of truth.json."""
    shown = machine.visibility(score)
    near = machine.look_alikes(score)
    oracle = {"pipeline": PIPELINE}
    for which, s in score.items():
        (floor, floor_rmse), (base, base_rmse) = s["floor"], s["nominal"]
        oracle[which] = {"scale_acc": _short(s["scale"]), "acc_rmse_floor": _short(floor_rmse),
                         "acc_rmse_nominal": _short(base_rmse), "acc_nrmse_floor": float(f"{floor:.6g}"),
                         "acc_nrmse_nominal": float(f"{base:.6g}"), "ratio": float(f"{base / floor:.5g}")}
    wrong = [] if machine.suite is None or not machine.suite.misread else [machine.suite.misread]
    found = {
        **_head(name, machine), "class": "channel" if wrong else verdict,
        "effects": [_effect(machine, *e) for e in zip(machine.effects, shown, near)] + wrong,
        "identifiable": all(s >= VISIBLE for s in shown),
        "nominal": machine.system.nominal_document(machine.nominal),
        "true": machine.system.nominal_document(machine.true_parameters()),
        "seed": seed, "index": index, "rate_hz": machine.rate,
        "T_train": machine.durations["train"], "T_test": machine.durations["test"],
        "hold": "foh" if machine.first_order else "zoh",
        "feedback": "measured state" if machine.seen else "true state",
        "columns": machine.columns, "noise": _sensor(machine), "noise_level": machine.noise_level,
        "sim": {"method": "RK4, constraint projection after every step",
                "dt": 1 / machine.control_rate / _substeps(machine)},
        "oracle": oracle,
    }
    if machine.disturbed:
        found["disturbed"] = machine.disturbance.truth()
    return found


def _substeps(machine):
    from effects import encode

    records = encode(machine.effects)
    return machine.substeps(records) if len(records[0]) else round(1000 / machine.control_rate)


def log(path, machine, which, run, rng):
    """Writes one CSV; returns the numbers of the rows with a wild cell, by column."""
    stamps, number = np.arange(len(run.q)) / machine.rate, NUMBER if machine.quantum.any() else NOISE_FREE
    if machine.disturbance.jitter:
        late = machine.disturbance.lateness(len(stamps), machine.rate, rng)
        stamps, number, run = stamps + late, {**number, "t": JITTERED}, machine.run(which, late=late)
        if not machine.tame(run):
            raise RuntimeError(f"{path}: with stamps that jitter the machine leaves its range")
    channels = {**machine.measured(which, run), "u": machine.torques(which, run)}
    header, columns, formats = ["t"], [stamps], [number["t"]]
    for channel in machine.columns if machine.suite is None else ["u"]:
        names = machine.system.inputs if channel == "u" else machine.system.coords
        header += [f"{channel}_{n}" for n in names]
        columns += list(channels[channel].T)
        formats += [number[channel]] * len(names)
    if machine.suite is not None:
        names, readings = sensing.shown(machine, machine.suite, run, rng)
        header, columns, formats = header + names, columns + readings, formats + [SENSOR] * len(names)
    blank = machine.margin()
    rows = np.stack(columns, axis=1)[blank:len(run.q) - blank]
    cells, wild = machine.disturbance.wild(rows, rng)
    rows[tuple(cells.T)] += wild
    np.savetxt(path, rows, fmt=formats, delimiter=",", header=",".join(header), comments="")
    return {name: cells[cells[:, 1] == i, 0].tolist() for i, name in enumerate(header) if i}


def write(folder, name, machine, verdict, score, seed, index):
    """Writes the four files of a machine (a URDF of an arm, where cells are wild); returns the truth."""
    folder.mkdir(parents=True, exist_ok=True)
    wild = {}
    for i, which in enumerate(machine.durations):
        rng = np.random.default_rng([seed, index, 2, i])
        wild[which] = log(folder / f"{which}.csv", machine, which, score[which]["run"], rng)
    if machine.disturbance.outliers:
        (folder / "wild.json").write_text(json.dumps(wild) + "\n")
    found = truth(name, machine, verdict, score, seed, index)
    (folder / "nominal.json").write_text(json.dumps(nominal(name, machine), indent=1) + "\n")
    (folder / "truth.json").write_text(json.dumps(found, indent=1) + "\n")
    if machine.system.name == "planar_arm":
        (folder / "model.urdf").write_text(urdf(name, machine))
    if machine.suite is not None:
        model = (MODELS / f"{machine.system.name}.model").read_text()
        (folder / "sensed.model").write_text(f"{model}\n{sensing.statements(machine, machine.suite)}")
    return found


def urdf(name, machine):
    """The nominal arm as a URDF: axes along y, zero hanging down, only the planar inertia non-trivial."""
    p = machine.nominal
    lines = [f'<robot name="{name}">', '  <link name="base"/>']
    for i in range(1, machine.system.links + 1):
        m, lc, inertia = (repr(p[f"{k}{i}"]) for k in ("m", "lc", "I"))
        above = "base" if i == 1 else f"link{i - 1}"
        drop = "0" if i == 1 else f"-{p[f'l{i - 1}']!r}"
        lines += [
            f'  <link name="link{i}"><inertial><origin xyz="0 0 -{lc}"/><mass value="{m}"/>'
            f'<inertia ixx="{inertia}" ixy="0" ixz="0" iyy="{inertia}" iyz="0" izz="{inertia}"/></inertial></link>',
            f'  <joint name="j{i}" type="continuous"><parent link="{above}"/><child link="link{i}"/>'
            f'<origin xyz="0 0 {drop}"/><axis xyz="0 1 0"/></joint>']
    return "\n".join([*lines, "</robot>", ""])
