"""A node whose cache of compiled code is empty: the stream goes on while code is made beside it."""

import subprocess
import sys

import numpy as np
import pytest
from hybrid_dynamics_msgs.msg import ErrorCode, JointMotion
from hybrid_dynamics_msgs.srv import ListAssemblyModes, SetPayload, SwitchAssemblyMode
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from hybrid_dynamics_core import load
from hybrid_dynamics_core.kernels import cache, run

ROBOT = load("five_bar")


def motion():
    count = len(ROBOT.active)
    return JointMotion(
        name=list(ROBOT.active),
        position=ROBOT.reference.tolist(),
        velocity=[0.0] * count,
        acceleration=[1.0] * count,
    )


class Stream:
    """Sends states until a call is answered, and finds what came back for each."""

    def __init__(self, client):
        self._client = client

    def until(self, future):
        """Efforts of every input that was sent before a call was answered; then of one after."""
        stamps = []

        def answered():
            stamps.append(self._send())
            return future.done()

        self._client.wait_until(answered, "an answer", 60.0)
        before = [self._efforts(stamp) for stamp in stamps]
        return before, self._efforts(self._send())

    def _send(self):
        stamp = self._client.new_stamp(0.01)
        self._client.publish("active_joint_motions", motion(), stamp)
        return stamp

    def _efforts(self, stamp):
        return np.array(self._client.wait_for("required_efforts", stamp).effort)


@pytest.fixture(scope="module")
def cold(tmp_path_factory):
    return {
        cache.VARIABLE: str(tmp_path_factory.mktemp("cache")),
        run.VARIABLE: "python",  # quicker to make
    }


@pytest.mark.sweep(sample="test_code_of_a_change_is_made_in_another_process")
def test_every_input_is_answered_while_code_is_made(start_node, connect, cold):
    """Each answer under the old or the new conditions, and the new ones after the call's answer."""
    node = start_node("-p", "robot:=five_bar", "-r", "__ns:=/cold", environment=cold)
    node.wait_for("active joints")
    client = connect("/cold/hybrid_dynamics", only=("set_payload", "set_parameters"))
    stream = Stream(client)
    client.wait_until(lambda: stream_is_there(client, stream), "an answer")
    frame = ROBOT.frames[-1]

    request = SetPayload.Request(frame=frame)
    request.inertia.m = 2.0
    future = client.call_async("set_payload", request)
    before, laden = stream.until(future)
    assert future.result().error_code == ErrorCode.OK
    assert_one_or_other(before, before[0], laden)

    names = {"payload.frame": ROBOT.frames[-2], "payload.mass": 3.0}
    parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in names.items()]
    future = client.call_async("set_parameters", SetParameters.Request(parameters=parameters))
    before, heavier = stream.until(future)
    assert all(result.successful for result in future.result().results)
    assert_one_or_other(before, laden, heavier)
    assert np.abs(heavier - laden).max() > 1e-3

    modes = client.call("list_assembly_modes", ListAssemblyModes.Request())
    other = modes.modes[1 - modes.current]
    switch = SwitchAssemblyMode.Request(loops=other.loops, branches=other.branches)
    future = client.call_async("switch_assembly_mode", switch)
    before, switched = stream.until(future)
    assert future.result().error_code == ErrorCode.OK, future.result().error_text
    assert_one_or_other(before, heavier, switched)
    assert node.stop() == 0
    assert "Traceback" not in node.output()


def stream_is_there(client, stream):
    stamp = stream._send()
    return client.received("required_efforts", stamp) or client.received(
        "required_efforts", stamp - 10**8
    )


def assert_one_or_other(rows, old, new):
    """Each row is the old or the new one, and none is old after a new one."""
    is_new = [not np.array_equal(row, old) for row in rows]
    for row, changed in zip(rows, is_new, strict=True):
        if changed:
            np.testing.assert_array_equal(row, new)
    assert is_new == sorted(is_new)


@pytest.mark.parametrize("part", ["node.lifecycle", "services.worker"])
def test_a_start_takes_no_libraries_that_are_slow_to_start(part):
    code = (
        f"import sys, hybrid_dynamics_ros.{part};"
        "print([name for name in sys.modules if name.startswith('scipy')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
