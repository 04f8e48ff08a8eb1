"""Frames are where other people's programs have them."""

from __future__ import annotations

from pathlib import Path

import dynamics
import numpy as np
import pinocchio  # type: ignore[import-untyped]
import pytest
from conftest import MODELS


@pytest.mark.parametrize("name", ["panda.urdf", "ur5.urdf", "iiwa7.urdf"])
def test_links_are_where_pinocchio_has_them(name: str) -> None:
    model = dynamics.Model.load(MODELS / name)
    other = pinocchio.buildModelFromUrdf(str(MODELS / name))
    data = other.createData()
    q = np.random.default_rng(2).uniform(-1.0, 1.0, (4, len(model.coordinates)))
    # The joints of a model are in the order of the description, those of Pinocchio in its own.
    places = [other.joints[other.getJointId(joint)].idx_q for joint in model.coordinates]
    links = [f.name for f in other.frames if f.type == pinocchio.FrameType.BODY]
    # Theirs does not follow the joint that it mimics.
    links = [link for link in links if link != "panda_rightfinger"]
    assert set(links) <= set(model.frames)
    assert len(links) > 6
    for link in links:
        poses, jacobians = model.frame_pose(link, q), model.frame_jacobian(link, q)
        for row, pose, jacobian in zip(q, poses, jacobians, strict=True):
            theirs = np.zeros(other.nq)
            theirs[places] = row
            pinocchio.computeJointJacobians(other, data, theirs)
            pinocchio.updateFramePlacements(other, data)
            index = other.getFrameId(link)
            np.testing.assert_allclose(pose, data.oMf[index].homogeneous, atol=1e-9, err_msg=link)
            axes = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
            expected = pinocchio.getFrameJacobian(other, data, index, axes)[:, places]
            np.testing.assert_allclose(jacobian, expected, atol=1e-9, err_msg=link)


def test_frames_of_a_model_are_those_of_its_outputs(tmp_path: Path) -> None:
    path = tmp_path / "crane.model"
    path.write_text("""model crane;
coordinate slew: rad;
coordinate trolley: m;
body jib { frame: rotate_z(slew); mass: 100; inertia: diag(10, 80, 80); }
frame carriage = jib * translate(trolley, 0, 0.2);
body load { frame: carriage * translate(0, 0, -2); mass: 5; }
gravity (0, 0, -9.81);
output place = position(carriage);
output speed = velocity(load);
""")
    model = dynamics.Model.load(path)
    assert {"jib", "carriage", "load"} <= set(model.frames)
    rng = np.random.default_rng(4)
    q, v = rng.standard_normal((2, 7, 2))
    outputs = model.outputs(q, v)
    pose, jacobian = model.frame_pose("carriage", q), model.frame_jacobian("load", q)
    np.testing.assert_allclose(outputs[:, :3], pose[:, :3, 3], atol=1e-14)
    np.testing.assert_allclose(outputs[:, 3:], (jacobian @ v[..., None])[:, :3, 0], atol=1e-14)
    np.testing.assert_array_equal(pose[:, 3], np.tile([0.0, 0.0, 0.0, 1.0], (7, 1)))
    with pytest.raises(dynamics.Error, match="no frame `hook`.*carriage"):
        model.frame_pose("hook", q)
