#!/usr/bin/env python3
"""Writes (or with --check compares) mjcf.json: the equations of models/*.xml, as MuJoCo has them.

    python mjcf.py            recreate
    python mjcf.py --check    recreate in memory and compare at 1e-12

The format is described in ../README.md.
"""

from pathlib import Path

import mujoco
import numpy as np

from figures import hold

HERE = Path(__file__).resolve().parent
MODELS = HERE / "models"
NAMES = ["chain", "several", "classes", "geoms", "walker", "balls", "loops"]
TOLERANCE = 1e-12
STATES = 6
SEED = 11
# Joints that turn by a quaternion, with the names of their coordinates: those that slide, then those of the quaternion.
TURN = ["qx", "qy", "qz", "qw"]
PARTS = {int(mujoco.mjtJoint.mjJNT_FREE): ["x", "y", "z", *TURN], int(mujoco.mjtJoint.mjJNT_BALL): TURN}


def joints(model):
    """Name, kind and places of every joint, in MuJoCo's order."""
    for index in range(model.njnt):
        yield (model.joint(index).name, int(model.jnt_type[index]), model.jnt_qposadr[index],
               model.jnt_dofadr[index])


def names(model):
    """The coordinates that the reader makes of the joints."""
    found = []
    for name, kind, _, _ in joints(model):
        found += [f"{name}_{part}" for part in PARTS[kind]] if kind in PARTS else [name]
    return found


def state(model, random):
    """Positions and velocities drawn at random."""
    data = mujoco.MjData(model)
    for _, kind, place, _ in joints(model):
        if kind in PARTS:
            quaternion = random.normal(size=4)
            slides = len(PARTS[kind]) - 4
            data.qpos[place:place + slides] = random.uniform(-1, 1, slides)
            data.qpos[place + slides:place + slides + 4] = quaternion / np.linalg.norm(quaternion)
        else:
            data.qpos[place] = random.uniform(-1, 1)
    data.qvel[:] = random.uniform(-2, 2, model.nv)
    return data


def rates(model, data):
    """The rates of our coordinates by MuJoCo's velocities, a matrix.

    Those of a free joint are the origin's along the world's axes and the body's own turning, those of a ball this
    turning alone: the quaternion (w, v) changes by half of (-v, w + v x) times that. Ours has w last.
    """
    blocks = np.zeros((model.nq, model.nv))
    for _, kind, place, dof in joints(model):
        if kind not in PARTS:
            blocks[place, dof] = 1
            continue
        slides = len(PARTS[kind]) - 4
        blocks[place:place + slides, dof:dof + slides] = np.eye(slides)
        place, dof = place + slides, dof + slides
        w, x, y, z = data.qpos[place:place + 4]
        blocks[place:place + 4, dof:dof + 3] = 0.5 * np.array([
            [w, -z, y],
            [z, w, -x],
            [-y, x, w],
            [-x, -y, -z],
        ])
    return blocks


def positions(model, data):
    """Our coordinates."""
    ours = data.qpos.copy()
    for _, kind, place, _ in joints(model):
        if kind in PARTS:
            place += len(PARTS[kind]) - 4
            w, *v = data.qpos[place:place + 4]
            ours[place:place + 4] = [*v, w]
    return ours


def equalities(model):
    """The names of the constraints that the reader makes of the equalities, a row each."""
    found = []
    for index in range(model.neq):
        equality = model.equality(index)
        is_point = equality.type[0] == mujoco.mjtEq.mjEQ_CONNECT
        found += [f"{equality.name}_{axis}" for axis in "xyz"] if is_point else [equality.name]
    return found


def closed(model, data):
    """Residuals and Jacobians of the equalities by MuJoCo's velocities."""
    count = len(equalities(model))
    jacobian = np.array(data.efc_J).reshape(-1, model.nv)
    assert (data.efc_type[:count] == mujoco.mjtConstraint.mjCNSTR_EQUALITY).all()
    return {"residual": data.efc_pos[:count].tolist(), "jacobian": jacobian[:count].tolist()}


def case(model, random):
    """One state, with the equations there."""
    data = state(model, random)
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    by_rates = rates(model, data)
    # Straight from the velocity: the rates must be what mj_integratePos takes them for.
    step = 1e-7
    moved = data.qpos.copy()
    mujoco.mj_integratePos(model, moved, data.qvel, step)
    later = mujoco.MjData(model)
    later.qpos[:] = moved
    difference = (positions(model, later) - positions(model, data)) / step
    assert np.abs(difference - by_rates @ data.qvel).max() < 1e-5
    return {
        "q": positions(model, data).tolist(),
        "v": (by_rates @ data.qvel).tolist(),
        "velocity": data.qvel.tolist(),
        "rates": by_rates.tolist(),
        "M": mass.tolist(),
        "bias": data.qfrc_bias.tolist(),
        "spring": data.qfrc_spring.tolist(),
        "damper": data.qfrc_damper.tolist(),
    } | (closed(model, data) if model.neq else {})


def robot(name, random):
    """A model with its constants and some states."""
    model = mujoco.MjModel.from_xml_path(str(MODELS / f"{name}.xml"))
    drives = []
    for index in range(model.nu):
        joint = model.actuator_trnid[index, 0]
        drives.append({"name": model.actuator(index).name, "joint": model.joint(joint).name,
                       "gear": float(model.actuator_gear[index, 0])})
    return {
        "coordinates": names(model),
        "drives": drives,
        "friction": model.dof_frictionloss.tolist(),
        "equalities": equalities(model),
        "states": [case(model, random) for _ in range(STATES)],
    }


def figures():
    """Everything, as it is written."""
    random = np.random.default_rng(SEED)
    found = {"mujoco_version": mujoco.__version__}
    return found | {name: robot(name, random) for name in NAMES}


def apart(a, b):
    """How far numbers are apart, as a share of the second where that is large."""
    return abs(a - b) / max(1.0, abs(b))


if __name__ == "__main__":
    hold(HERE / "mjcf.json", figures, TOLERANCE, __doc__.splitlines()[0], distance=apart)
