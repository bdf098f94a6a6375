"""The table of parameters and the profiles."""

import pytest
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSReliabilityPolicy

from hybrid_dynamics_ros.node import qos
from hybrid_dynamics_ros.node.declare_parameters import descriptor
from hybrid_dynamics_ros.parameters import (
    AUTOSTART,
    BANDWIDTH,
    GRAVITY,
    INPUT_DEPTH,
    INPUT_QOS,
    KALMAN_BANDWIDTH,
    MEASURED,
    PAYLOAD_COM,
    PROFILES,
    ROBOT,
    TABLE,
    XACRO_ARGS,
    NodeSettings,
    ParameterError,
    checked,
    sensor_rows,
)


def test_the_table_is_complete_and_consistent():
    assert len({parameter.name for parameter in TABLE}) == len(TABLE)
    for parameter in TABLE:
        assert parameter.text.endswith(".")
        assert (
            checked(parameter, parameter.default) == parameter.default == NodeSettings()[parameter]
        )


def test_both_filters_take_the_same_bandwidths():
    ranges = [descriptor(row).floating_point_range[0] for row in (BANDWIDTH, KALMAN_BANDWIDTH)]
    assert ranges[0] == ranges[1]


def test_descriptors_say_range_unit_choices_and_read_only():
    bandwidth = descriptor(BANDWIDTH)
    assert bandwidth.description.endswith("[Hz]")
    assert not bandwidth.read_only
    assert descriptor(AUTOSTART).read_only
    assert "cleanup" in descriptor(ROBOT).additional_constraints
    assert [(r.from_value, r.to_value) for r in bandwidth.floating_point_range] == [(0.01, 1000.0)]
    assert not bandwidth.integer_range
    assert [(r.from_value, r.to_value) for r in descriptor(INPUT_DEPTH).integer_range] == [
        (1, 100000)
    ]
    assert descriptor(INPUT_QOS).additional_constraints.startswith("one of: reliable, best_effort,")
    assert not descriptor(ROBOT).floating_point_range


@pytest.mark.parametrize(
    ("name", "reliability"),
    [
        ("reliable", QoSReliabilityPolicy.RELIABLE),
        ("best_effort", QoSReliabilityPolicy.BEST_EFFORT),
    ],
)
def test_profiles_do_what_they_are_called(name, reliability):
    profile = qos.profile(name, depth=7)
    assert profile.reliability == reliability
    assert profile.depth == 7
    assert profile.durability == QoSDurabilityPolicy.VOLATILE
    assert profile.history == QoSHistoryPolicy.KEEP_LAST


def test_every_profile_can_be_chosen():
    assert [qos.profile(name, 7).depth for name in PROFILES] == [7, 7, 5, 1]


@pytest.mark.parametrize(
    ("row", "given", "taken"),
    [
        (BANDWIDTH, 12, 12.0),
        (GRAVITY, [0, 0, -10], (0.0, 0.0, -10.0)),
        (GRAVITY, None, None),
        (GRAVITY, [], None),
        (MEASURED, [], None),
        (PAYLOAD_COM, [], (0.0, 0.0, 0.0)),
        (MEASURED, ["a", "b"], ("a", "b")),
        (INPUT_DEPTH, 3, 3),
    ],
)
def test_values_are_taken_as_the_table_has_them(row, given, taken):
    value = checked(row, given)
    assert value == taken
    assert type(value) is type(taken)


@pytest.mark.parametrize(
    ("row", "given", "words"),
    [
        (BANDWIDTH, float("nan"), ["acceleration_filter.bandwidth", "nan", "0.01 to 1000 Hz"]),
        (BANDWIDTH, "fast", ["'fast'", "expected a number"]),
        (BANDWIDTH, True, ["True", "expected a number"]),
        (INPUT_DEPTH, 3.0, ["3.0", "expected a whole number"]),
        (INPUT_QOS, "perfect", ["'perfect'", "reliable, best_effort"]),
        (GRAVITY, [0.0, 1.0], ["gravity", "expected 3 entries"]),
        (GRAVITY, 9.81, ["9.81", "expected an array"]),
        (PAYLOAD_COM, [0.0, float("inf"), 0.0], ["payload.com", "inf"]),
        (ROBOT, "", ["robot"]),
        (XACRO_ARGS, ["prefix=a"], ["xacro_args", "'prefix=a'", "NAME:=VALUE"]),
        (XACRO_ARGS, ["a:=1", " a:=2"], ["xacro_args", "'a' is given twice"]),
        (sensor_rows("q1")[1], 0.5, ["sensors.q1.sign", "0.5", "1.0 or -1.0"]),
        (sensor_rows("q1")[2], 0.0, ["sensors.q1.scale", "0.0"]),
    ],
)
def test_what_cannot_be_taken_is_named_with_what_is_expected(row, given, words):
    with pytest.raises(ParameterError) as caught:
        checked(row, given)
    assert all(word in str(caught.value) for word in words), caught.value


def test_settings_never_change():
    settings = NodeSettings()
    other = settings.replaced({BANDWIDTH.name: 3.0})
    assert (settings[BANDWIDTH], other[BANDWIDTH]) == (10.0, 3.0)
    assert other[sensor_rows("anything")[2]] == 1.0
