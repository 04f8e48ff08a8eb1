#!/usr/bin/env python3
"""Writes humanoid.urdf: a humanoid of 29 joints, with figures of our own.

    python humanoid.py > humanoid.urdf

Two legs of six joints, a waist of three and two arms of seven, as on the humanoids that are sold
today. Masses and lengths are round numbers of a person of 1.3 m; centres of mass lie beside the
axes and tensors are full, so that nothing is zero by accident.
"""

LEG = [("hip_pitch", "y"), ("hip_roll", "x"), ("hip_yaw", "z"), ("knee", "y"),
       ("ankle_pitch", "y"), ("ankle_roll", "x")]
LEG_OFFSETS = [(0, 0.07, -0.1), (0.01, 0.05, -0.03), (0, 0, -0.12), (0, 0, -0.2),
               (0, 0, -0.3), (0, 0, -0.02)]
LEG_MASSES = [1.3, 1.5, 1.7, 1.9, 0.1, 0.6]
ARM = [("shoulder_pitch", "y"), ("shoulder_roll", "x"), ("shoulder_yaw", "z"), ("elbow", "y"),
       ("wrist_roll", "x"), ("wrist_pitch", "y"), ("wrist_yaw", "z")]
ARM_OFFSETS = [(0, 0.1, 0.24), (0, 0.04, -0.01), (0, 0, -0.1), (0.02, 0, -0.08),
               (0.1, 0, 0), (0.04, 0, 0), (0.05, 0, 0)]
ARM_MASSES = [0.7, 0.6, 0.7, 0.6, 0.1, 0.5, 0.3]
WAIST = [("waist_yaw", "z"), ("waist_roll", "x"), ("waist_pitch", "y")]
WAIST_OFFSETS = [(0, 0, 0), (0, 0, 0.04), (0, 0, 0.01)]
WAIST_MASSES = [0.2, 0.05, 8.0]
AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


def link(name, mass, number):
    """A link whose mass lies beside its axis."""
    center = (0.01 + 0.002 * (number % 5), 0.004 * (number % 3) - 0.006, -0.03 - 0.01 * (number % 4))
    size = 0.002 * mass
    print(f'  <link name="{name}">\n    <inertial>')
    print('      <origin xyz="{:.4g} {:.4g} {:.4g}"/>'.format(*center))
    print(f'      <mass value="{mass}"/>')
    print(f'      <inertia ixx="{5 * size:.4g}" iyy="{6 * size:.4g}" izz="{4 * size:.4g}"')
    print(f'               ixy="{0.3 * size:.4g}" ixz="{-0.2 * size:.4g}" iyz="{0.4 * size:.4g}"/>')
    print("    </inertial>\n  </link>\n")


def joint(name, parent, child, offset, axis):
    """A revolute joint."""
    print(f'  <joint name="{name}" type="revolute">')
    print(f'    <parent link="{parent}"/>\n    <child link="{child}"/>')
    print('    <origin xyz="{:.4g} {:.4g} {:.4g}"/>'.format(*offset))
    print(f'    <axis xyz="{AXES[axis]}"/>')
    print('    <limit lower="-3" upper="3" effort="100" velocity="20"/>\n  </joint>\n')


def chain(parent, prefix, joints, offsets, masses, side, number):
    """Links one behind the other; `side` mirrors their offsets."""
    for (name, axis), offset, mass in zip(joints, offsets, masses):
        child = f"{prefix}{name}_link"
        joint(f"{prefix}{name}", parent, child, (offset[0], side * offset[1], offset[2]), axis)
        link(child, mass, number)
        parent, number = child, number + 1
    return parent


def main():
    print('<?xml version="1.0"?>\n<!-- A humanoid of 29 joints; made by humanoid.py. -->')
    print('<robot name="humanoid">\n')
    link("pelvis", 3.8, 0)
    chain("pelvis", "left_", LEG, LEG_OFFSETS, LEG_MASSES, 1, 1)
    chain("pelvis", "right_", LEG, LEG_OFFSETS, LEG_MASSES, -1, 7)
    torso = chain("pelvis", "", WAIST, WAIST_OFFSETS, WAIST_MASSES, 1, 13)
    chain(torso, "left_", ARM, ARM_OFFSETS, ARM_MASSES, 1, 16)
    chain(torso, "right_", ARM, ARM_OFFSETS, ARM_MASSES, -1, 23)
    print("</robot>")


if __name__ == "__main__":
    main()
