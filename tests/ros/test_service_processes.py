"""The processes that answer calls: one that imports everything, and forks of it."""

import os
import subprocess
import time

import pytest
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import DescribeRobot

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.services.processes import start_alike
from hybrid_dynamics_ros.stream.situation import Situation

PROGRAM = "hybrid_dynamics_ros.services.worker"
DEADLINE = 60.0  # [s], for what takes parts of a second on an idle machine


@pytest.fixture
def children():
    """A process and two forks of it, of which the last gives way."""
    started = start_alike(PROGRAM, [False, False, True])
    yield started
    for process, connection in started:
        process.kill()
        process.wait(DEADLINE)
        connection.close()


def received(child):
    assert child.connection.poll(DEADLINE)
    return child.connection.recv()


def answer_of(child):
    child.connection.send(("describe_robot", DescribeRobot.Request(), Situation()))
    return received(child)[0]


def process_id(child):
    """The id of a process; a fork is there when the first process has imported everything."""
    end = time.monotonic() + DEADLINE
    while child.process.pid is None:
        assert time.monotonic() < end
        time.sleep(0.01)
    return child.process.pid


def test_forks_answer_as_the_first_process_and_outlive_it(children):
    for child in children:
        child.connection.send(load("five_bar").description)
    assert [received(child) for child in children] == [None] * 3
    answers = [answer_of(child) for child in children]
    assert answers[0].error_code == ErrorCode.OK
    assert answers[1:] == [answers[0]] * 2
    assert len({process_id(child) for child in children}) == 3
    own, *others = [os.getpriority(os.PRIO_PROCESS, process_id(child)) for child in children]
    assert others == [own, min(own + 5, 19)]
    first, *forks = children
    first.process.kill()
    first.process.wait(DEADLINE)
    for fork in forks:
        assert answer_of(fork) == answers[0]
        with pytest.raises(subprocess.TimeoutExpired):
            fork.process.wait(0.0)
        fork.process.kill()
        fork.process.wait(DEADLINE)
        with pytest.raises(EOFError):  # nobody else holds its end
            fork.connection.recv()


def test_a_fork_that_is_not_there_yet_is_killed_when_it_is(children):
    first, fork, other = children
    assert fork.process.pid is None
    fork.process.kill()
    fork.process.wait(DEADLINE)
    assert process_id(fork) != process_id(other)
    for child in (first, other):
        with pytest.raises(subprocess.TimeoutExpired):
            child.process.wait(0.0)


def test_forks_of_a_process_that_does_not_start_have_ended():
    first, fork = start_alike("hybrid_dynamics_ros.no_such_module", [False, False])
    assert first.process.wait(DEADLINE) == 1
    fork.process.wait(DEADLINE)
    assert fork.process.pid is None
    with pytest.raises(EOFError):
        fork.connection.recv()
