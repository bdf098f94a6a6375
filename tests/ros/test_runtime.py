"""What may change while a robot works: calibration, payload, assembly modes, and their code."""

import threading
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import load
from hybrid_dynamics_core.kernels import artifact, cache, run
from hybrid_dynamics_core.kernels.run import Kernel
from hybrid_dynamics_ros.messages.joint_samples import JointSample, Rejection
from hybrid_dynamics_ros.parameters import (
    MEASURED,
    PAYLOAD_FRAME,
    PAYLOAD_MASS,
    NodeSettings,
    sensor_rows,
)
from hybrid_dynamics_ros.services.code_maker import CodeMaker
from hybrid_dynamics_ros.stream.conditions import (
    Conditions,
    NewMode,
    NewPayload,
    PayloadBody,
    loads_of,
)
from hybrid_dynamics_ros.stream.runtime import Runtime
from hybrid_dynamics_ros.stream.topics import topics_of
from tests.sampling import examples, swept

MS = 10**6
BODY = PayloadBody(5.0, (0.0, 0.0, 0.0), (0.0,) * 6)


@pytest.fixture
def runtime():
    return Runtime(load("forging_chu2020"), NodeSettings())


def changed(runtime, change):
    """As the thread of the changes makes them."""
    runtime.prepare(change.applied(runtime.conditions))
    assert runtime.change(change)


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
    changed(runtime, NewPayload("end_effector", BODY))  # this call is answered
    changed(runtime, switch)
    assert runtime.conditions.mode is mode
    assert runtime.conditions.payloads["end_effector"].mass == 5.0
    assert dict(at_rest(runtime, 1)[0].state.branch) == dict(mode.branch)


def test_a_switch_waits_for_the_sample_that_is_worked_on(runtime):
    """A switch in the middle of a sample would be lost.

    The state that the sample ends with has the old modes.
    """
    robot = runtime.robot
    one, two = (entry.state for entry in robot.assembly_modes(robot.reference)[:2])
    changed(runtime, NewMode(one))
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


FRAMES = ("", "end_effector", "bucket")
PAYLOADS = st.tuples(st.sampled_from(FRAMES), st.sampled_from([2.0, 5.0, 0.0]))


@examples(800)
@given(st.lists(PAYLOADS, min_size=1, max_size=4), st.booleans())
def test_the_payload_of_the_parameters_is_where_the_newest_put_it(payloads, has_call):
    """One that a call has put at another frame stays."""
    conditions, before = Conditions(), None
    if has_call:
        conditions = conditions.with_payload("boom", BODY)
    for frame, mass in payloads:
        settings = NodeSettings({PAYLOAD_FRAME.name: frame, PAYLOAD_MASS.name: mass})
        conditions = conditions.with_settings(settings, before, "end_effector")
        before = settings
    expected = {"boom": BODY.mass} if has_call else {}
    if mass:
        expected[frame or "end_effector"] = mass
    assert {name: body.mass for name, body in conditions.payloads.items()} == expected


# -- code


@contextmanager
def no_code_is_loaded():
    """Fails where a kernel is made, or taken from disk: both hold up the stream."""

    def load_one(kernel, form):
        raise AssertionError(f"{kernel._label}, {form}")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Kernel, "_load", load_one)
        yield


@st.composite
def changes(draw, robot):
    """Payloads at some frames, gravity, and perhaps an assembly mode."""
    frames = draw(st.sampled_from([(), (robot.end_effector,)]))
    payloads = dict.fromkeys(frames, BODY)
    gravity = draw(st.sampled_from([None, (0.0, 0.0, -1.62)]))
    modes = [None, *(mode.state for mode in robot.assembly_modes(robot.reference))]
    return Conditions(gravity, payloads, draw(st.sampled_from(modes)))


@st.composite
def samples(draw, runtime, stamp):
    """Any joint states that may come: with rates or without, near or far."""
    robot, names = runtime.robot, runtime.measured
    state = robot.close(robot.reference).s
    places = [robot.coordinates.index(name) for name in names]
    shift = draw(st.sampled_from([0.0, 1e-5, 1e-2, 0.3, 50.0]))
    velocity, acceleration = None, None
    if draw(st.booleans()):
        velocity = np.full(len(names), draw(st.sampled_from([0.0, 0.1])))
        acceleration = draw(st.sampled_from([None, np.zeros(len(names))]))
    return JointSample(stamp, names, state[places] + shift, velocity, acceleration)


SERIAL = ("q1", "q2", "q3", "q4")
CASES = [("ankle", None), ("five_bar", None), ("palletizer", None), ("forging_chu2020", SERIAL)]


@pytest.mark.parametrize(("name", "measured"), swept(CASES, ["five_bar"]))
@examples(8)
@given(st.data())
def test_under_prepared_conditions_no_sample_waits_for_code(name, measured, data):
    """Whatever comes: a rehearsal runs all that any sample needs."""
    robot = load(name)
    runtime = Runtime(robot, NodeSettings({MEASURED.name: measured}))
    conditions = data.draw(changes(robot))
    runtime.prepare(conditions)
    topics = topics_of(robot, NodeSettings())
    with no_code_is_loaded():
        runtime.evaluator.loads = loads_of(robot, conditions)
        runtime.evaluator.set_mode(conditions.mode)
        for k in range(8):
            result = runtime.process(data.draw(samples(runtime, (k + 1) * 10 * MS)))
            if not isinstance(result, Rejection):
                for topic in topics:
                    topic.fill(result)


def efforts(runtime):
    """For an acceleration out of rest."""
    robot = runtime.robot
    ones = np.ones(len(robot.active))
    return runtime.process(JointSample(MS, robot.active, robot.reference, 0 * ones, ones)).efforts


def test_code_of_a_change_is_made_in_another_process(monkeypatch, tmp_path):
    """With an empty cache: this process makes none, and works under the change afterwards."""
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    monkeypatch.setenv(run.VARIABLE, "python")  # quicker to make
    robot = load("five_bar")
    runtime = Runtime(robot, NodeSettings())
    before = efforts(runtime)
    maker = CodeMaker(robot.description)
    runtime.make_code = maker.make

    def make(*_arguments):
        raise AssertionError("code is made in the process of the stream")

    monkeypatch.setattr(artifact, "make", make)
    try:
        frame = robot.frames[-1]
        change = NewPayload(frame, BODY)
        assert not runtime.change(change)  # nothing is here for it yet
        np.testing.assert_array_equal(efforts(runtime), before)
        maker._running().process.kill()  # it is replaced
        changed(runtime, change)
        assert np.abs(efforts(runtime) - before).max() > 1e-3
    finally:
        maker.close()
    assert not maker.make(None)  # a maker that was closed makes nothing
