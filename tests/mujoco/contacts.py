#!/usr/bin/env python3
"""Writes (or with --check compares) contacts.json: machines on a floor, as MuJoCo moves them.

    python contacts.py            recreate
    python contacts.py --check    recreate in memory and compare at 1e-6

MuJoCo's contacts are soft: they are inside of the floor by some micrometres and slip a little where
Coulomb's law sticks. Both go with the step and the stiffness, which are small and hard here. The
format is described in ../README.md.
"""

from pathlib import Path

import mujoco
import numpy as np

from figures import hold

HERE = Path(__file__).resolve().parent
SOLO = HERE.parents[1] / "models" / "solo12.urdf"
TOLERANCE = 1e-6
STEP = 1e-4
SAMPLES = 20

OPTIONS = f"""
  <option timestep="{STEP}" gravity="0 0 -9.81" cone="elliptic" impratio="100" solver="Newton"
          tolerance="1e-14" iterations="200" integrator="implicitfast"/>
  <default><geom solref="{2 * STEP} 1" solimp="0.99 0.9999 0.0001" condim="3"/></default>
"""


def scene(name, body):
    """A floor with a body on it."""
    return f"""
<mujoco model="{name}">{OPTIONS}
  <worldbody><geom type="plane" size="10 10 0.1" friction="1e-5 0 0" priority="0"/>{body}</worldbody>
</mujoco>"""


def move(model, position, velocity, duration, seen):
    """Moves from a state; what is seen of it at equal times."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = position, velocity
    mujoco.mj_forward(model, data)
    rows = []
    steps = round(duration / STEP)
    for step in range(steps + 1):
        if step % (steps // SAMPLES) == 0:
            rows.append([data.time] + seen(data))
        mujoco.mj_step(model, data)
    return rows


def box():
    """A box that slides and turns on the floor until friction has stopped it."""
    body = """
    <body pos="0 0 0.05"><freejoint/>
      <geom type="box" size="0.2 0.1 0.05" friction="0.3 0 0" priority="1" mass="0"/>
      <inertial pos="0 0 0" mass="2" diaginertia="0.02 0.03 0.04"/></body>"""
    model = mujoco.MjModel.from_xml_string(scene("box", body))
    place = [0, 0, 0.05, 1, 0, 0, 0]

    def seen(data):
        w, z = data.qpos[3], data.qpos[6]
        return [data.qpos[0], data.qpos[1], 2 * float(np.arctan2(z, w))]

    return move(model, place, [1.5, 0.5, 0, 0, 0, 4], 1.0, seen)


def wheel():
    """A thin disc that is pushed over and rolls on."""
    body = """
    <body><freejoint/>
      <geom type="cylinder" size="0.25 0.00001" euler="90 0 0" friction="0.9 0 0" priority="1" mass="0"/>
      <inertial pos="0 0 0" mass="1.3" diaginertia="0.0203125 0.040625 0.0203125"/></body>"""
    model = mujoco.MjModel.from_xml_string(scene("wheel", body))
    tilt = 0.2
    place = [0, 0, 0.25 * np.cos(tilt), np.cos(tilt / 2), np.sin(tilt / 2), 0, 0]
    # Turning about its axis alone, its centre moves along x; velocities of turning are the body's.
    spin = 12.0
    return move(model, place, [0.25 * spin, 0, 0, 0, spin, 0], 1.0,
                lambda data: list(data.qpos[:3]))


def walker():
    """The quadruped of models/solo12.urdf, dropped on its feet; springs and dampers are its motors."""
    spec = mujoco.MjSpec.from_file(str(SOLO))
    spec.compiler.fusestatic = False
    spec.option.timestep = STEP
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 100
    spec.option.tolerance = 1e-14
    spec.option.iterations = 200
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    base = spec.body("base_link")
    base.add_freejoint()
    hard = {"solref": [2 * STEP, 1], "solimp": [0.99, 0.9999, 0.0001, 0.5, 2], "condim": 3}
    floor = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(type=floor, size=[10, 10, 0.1], friction=[0.8, 0, 0], contype=1,
                            conaffinity=1, **hard)
    for leg in ("FL", "FR", "HL", "HR"):
        foot = spec.body(f"{leg}_FOOT")
        ball = mujoco.mjtGeom.mjGEOM_SPHERE
        foot.add_geom(type=ball, size=[0.016, 0, 0], mass=0, friction=[0.8, 0, 0], contype=1,
                      conaffinity=1, **hard)
    rest = {"HAA": 0.0, "HFE": 0.7, "KFE": -1.4}
    angles = {}
    for joint in spec.joints:
        leg, _, kind = joint.name.partition("_")
        if kind not in rest:
            continue
        angles[joint.name] = rest[kind] * (-1 if leg.startswith("H") else 1)
        # Both are polynomials: of the deflection, of the rate.
        joint.stiffness, joint.damping = [15, 0, 0], [0.3, 0, 0]
        joint.springref, joint.frictionloss, joint.armature = angles[joint.name], 0, 0
    model = spec.compile()
    place = np.zeros(model.nq)
    place[2], place[3] = 0.35, 1
    for name, angle in angles.items():
        place[model.jnt_qposadr[model.joint(name).id]] = angle
    return move(model, place, np.zeros(model.nv), 1.0, lambda data: [data.qpos[0], data.qpos[2]])


def figures():
    """Everything, as it is written."""
    return {
        "mujoco_version": mujoco.__version__,
        "step": STEP,
        "box": box(),
        "wheel": wheel(),
        "walker": walker(),
    }


def rounded(value):
    """Numbers to nine digits."""
    return [[float(f"{x:.9g}") for x in row] for row in value] if isinstance(value, list) else value


if __name__ == "__main__":
    hold(HERE / "contacts.json", figures, TOLERANCE, __doc__.splitlines()[0], written=rounded)
