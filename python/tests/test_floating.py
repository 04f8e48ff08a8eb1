"""Robots that float by their twists, as Pinocchio has them in its own convention."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import dynamics
import numpy as np
import pytest
from conftest import ROOT
from dynamics.gp import LatentForceRegressor

FIGURES = ROOT / "tests" / "pinocchio" / "floating"


def near(found: Any, expected: Any) -> None:
    size = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * size)


@pytest.fixture(scope="module")
def quadruped() -> dynamics.Model:
    return dynamics.Model.load(FIGURES / "solo12.model")


class Robot:
    """A model with Pinocchio's figures, whose joints may have another order."""

    def __init__(self, name: str) -> None:
        self.model = dynamics.Model.load(FIGURES / f"{name}.model")
        figures = json.loads((FIGURES / f"{name}.json").read_text())
        names = self.model.coordinates
        self.order = [*range(6), *(names.index(joint) for joint in figures["joints"])]
        self.inputs = [names.index(name) for name in self.model.inputs]
        self.links = figures["links"]
        self.states = figures["states"]

    def velocities(self, theirs: list[float]) -> Any:
        ours = np.zeros(len(theirs))
        ours[self.order] = theirs
        return ours

    def positions(self, theirs: list[float]) -> Any:
        ours = np.array(theirs)
        ours[[place + 1 for place in self.order[6:]]] = theirs[7:]
        return ours

    def matrix(self, theirs: list[list[float]]) -> Any:
        ours = np.zeros((len(self.order), len(self.order)))
        ours[np.ix_(self.order, self.order)] = theirs
        return ours


@pytest.mark.parametrize("name", ["solo12", "humanoid"])
def test_equations_are_those_of_pinocchio(name: str) -> None:
    robot = Robot(name)
    model, n = robot.model, len(robot.order)
    assert len(model.positions) == n + 1
    for state in robot.states:
        q, v = robot.positions(state["q"]), robot.velocities(state["v"])
        a, u = robot.velocities(state["a_in"]), robot.velocities(state["tau"])[robot.inputs]
        near(model.mass_matrix(q), robot.matrix(state["M"]))
        near(-model.bias_force(q, v), robot.velocities(state["bias"]))
        near(model.inverse_dynamics(q, v, a), robot.velocities(state["tau_id"]))
        near(model.forward_dynamics(q, v, u), robot.velocities(state["a"]))
        slopes = model.derivatives(q, v, u)
        near(slopes.a_q, robot.matrix(state["da_dq"]))
        near(slopes.a_v, robot.matrix(state["da_dv"]))
        near(slopes.a_u, robot.matrix(state["da_dtau"])[:, robot.inputs])
        for link, jacobian in zip(robot.links, state["J"], strict=True):
            near(model.frame_jacobian(link, q)[:, robot.order], jacobian)


def test_a_batch_is_its_states_and_compiled_code_the_same(quadruped: dynamics.Model) -> None:
    robot = Robot("solo12")
    q = np.array([robot.positions(state["q"]) for state in robot.states])
    v = np.array([robot.velocities(state["v"]) for state in robot.states])
    compiled = quadruped.compile(options=("-O1",))
    for model in (quadruped, compiled):
        masses, forces = model.mass_matrix(q), model.bias_force(q, v)
        assert masses.shape == (2, 18, 18) and forces.shape == (2, 18)
        for k in range(2):
            np.testing.assert_array_equal(masses[k], quadruped.mass_matrix(q[k]))
            np.testing.assert_array_equal(forces[k], quadruped.bias_force(q[k], v[k]))


def test_a_box_tumbles_and_keeps_its_energy() -> None:
    model = dynamics.Model.load(ROOT / "tests" / "data" / "models" / "tumbling.model")
    assert (len(model.positions), len(model.coordinates)) == (7, 6)
    q, v = [0, 0, 0, 0, 0, 0, 1], [0.4, -0.2, 0.1, 0.02, 2.0, 0.01]
    motion = model.simulate(q, v, duration=3.0, rate=10.0)
    assert motion.q.shape == (31, 7) and motion.v.shape == motion.a.shape == (31, 6)
    np.testing.assert_allclose(np.linalg.norm(motion.q[:, 3:], axis=1), 1, atol=1e-12)
    inertia = np.array([2, 2, 2, 1 / 120, 17 / 600, 1 / 30])
    energy = (motion.v**2 @ inertia) / 2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    columns = motion.columns()
    np.testing.assert_array_equal(columns["q_box_qw"], motion.q[:, 6])
    np.testing.assert_array_equal(columns["dq_box_wy"], motion.v[:, 4])
    np.testing.assert_array_equal(columns["ddq_box_vx"], motion.a[:, 0])


def test_what_does_not_fit_is_said(quadruped: dynamics.Model) -> None:
    with pytest.raises(dynamics.Error, match="19"):
        quadruped.mass_matrix(np.zeros(18))
    with pytest.raises(dynamics.Error, match="floats by its twist"):
        LatentForceRegressor(quadruped).fit(np.zeros((60, 49)), np.zeros((60, 18)))
