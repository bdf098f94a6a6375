"""What a perfect run would have received, computed from the model without ROS."""

import numpy as np
import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.demo.expectation import expect
from hybrid_dynamics_ros.demo.judge.results import JointSeries, PoseSeries, Results
from hybrid_dynamics_ros.demo.play.recording import START_NS, shipped_messages
from hybrid_dynamics_ros.demo.trajectory import JOINTS, paper_trajectory

DELAY_NS = 700_000


@pytest.fixture(scope="session")
def robot():
    return load("forging_chu2020")


@pytest.fixture(scope="session")
def expected():
    """Expectation with the node's default filter."""
    return expect(shipped_messages(), bandwidth=10.0, max_gap=0.5)


def series(names, stamp_ns, log_ns, **tables):
    empty = np.full((len(stamp_ns), len(names)), np.nan)
    return JointSeries(
        tuple(names),
        stamp_ns,
        log_ns,
        *(tables.get(k, empty) for k in ("position", "velocity", "effort")),
    )


@pytest.fixture
def results(robot, expected):
    """Every message of the shipped recording answered, efforts as the model gives them."""
    motion = paper_trajectory(100)
    stamp_ns = START_NS + np.arange(motion.time.size) * 10_000_000
    state = robot.close(motion.position, motion.velocity)
    pose = robot.forward_kinematics(state)
    tau = robot.inverse_dynamics(state, np.zeros_like(motion.velocity))
    sent = expected.with_efforts
    return Results(
        inputs=series(
            JOINTS, stamp_ns, stamp_ns, position=motion.position, velocity=motion.velocity
        ),
        states=series(
            robot.coordinates, stamp_ns, stamp_ns + DELAY_NS, position=state.s, velocity=state.ds
        ),
        efforts=series(
            robot.active,
            stamp_ns[sent],
            stamp_ns[sent] + DELAY_NS,
            position=state.u[sent],
            velocity=state.du[sent],
            effort=tau[sent],
        ),
        pose=PoseSeries(robot.base_frame, stamp_ns, pose.position, pose.quaternion),
    )
