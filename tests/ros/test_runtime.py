"""What may change while a robot works: calibration, payload, assembly modes."""

import threading

import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.messages.joint_samples import JointSample
from hybrid_dynamics_ros.parameters import NodeSettings, sensor_rows
from hybrid_dynamics_ros.stream.conditions import NewMode, NewPayload, PayloadBody
from hybrid_dynamics_ros.stream.runtime import Runtime

MS = 10**6


@pytest.fixture
def runtime():
    return Runtime(load("forging_chu2020"), NodeSettings())


def at_rest(runtime, count, start=0):
    """Results of a robot that stands, told by positions alone."""
    robot = runtime.robot
    return [
        runtime.process(JointSample((start + k) * 10 * MS, robot.active, robot.reference.copy()))
        for k in range(count)
    ]


def test_a_new_calibration_is_no_motion(runtime):
    before = at_rest(runtime, 30)[-1]
    assert before.efforts is not None
    offset = sensor_rows("q12")[0]
    runtime.take(runtime.settings.replaced({offset.name: 0.02}))
    for result in at_rest(runtime, 30, start=30):
        assert result.active.acceleration is None or not result.active.acceleration.any()
        assert result.velocity is None or not result.velocity.any()
    assert result.efforts is not None
    assert result.active.position[1] == before.active.position[1] - 0.02
    runtime.take(runtime.settings)
    assert (
        at_rest(runtime, 1, start=60)[0].efforts is not None
    )  # nothing changed, nothing starts anew


def test_changes_of_calls_do_not_undo_each_other(runtime):
    robot = runtime.robot
    mode = robot.assembly_modes(robot.reference)[1].state
    switch = NewMode(mode)  # asked for, and worked on while
    runtime.change(
        NewPayload("end_effector", PayloadBody(5.0, (0.0, 0.0, 0.0), (0.0,) * 6))
    )  # this call is answered
    runtime.change(switch)
    assert runtime.conditions.mode is mode
    assert runtime.conditions.payloads["end_effector"].mass == 5.0
    assert dict(at_rest(runtime, 1)[0].state.branch) == dict(mode.branch)


def test_a_switch_waits_for_the_sample_that_is_worked_on(runtime):
    """A switch in the middle of a sample would be lost.

    The state that the sample ends with has the old modes.
    """
    robot = runtime.robot
    one, two = (entry.state for entry in robot.assembly_modes(robot.reference)[:2])
    runtime.change(NewMode(one))
    at_rest(runtime, 2)
    close, threads = robot.close, []

    def slow(*arguments, **options):
        threads.append(threading.Thread(target=runtime.change, args=(NewMode(two),)))
        threads[0].start()
        threads[0].join(0.2)  # it has to wait: the lock is held
        return close(*arguments, **options)

    robot.close = slow
    at_rest(runtime, 1, start=5)
    del robot.close
    threads[0].join()
    assert dict(at_rest(runtime, 1, start=6)[0].state.branch) == dict(two.branch)
