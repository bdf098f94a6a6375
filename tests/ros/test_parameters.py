"""The table of parameters and the profiles."""

import pytest
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSReliabilityPolicy

from hybrid_dynamics_ros import qos
from hybrid_dynamics_ros.parameters import BANDWIDTH, INPUT_DEPTH, INPUT_QOS, ROBOT, TABLE, Settings, descriptor


def test_the_table_is_complete_and_consistent():
    assert len({parameter.name for parameter in TABLE}) == len(TABLE) == len(Settings.__dataclass_fields__)
    for parameter in TABLE:
        assert parameter.text.endswith(".")
        if parameter.bounds is not None:
            low, high = parameter.bounds
            assert low <= parameter.default <= high
        if parameter.choices:
            assert parameter.default in parameter.choices


def test_descriptors_say_range_unit_choices_and_read_only():
    bandwidth = descriptor(BANDWIDTH)
    assert bandwidth.description.endswith("[Hz]")
    assert bandwidth.read_only
    assert [(r.from_value, r.to_value) for r in bandwidth.floating_point_range] == [(0.01, 1000.0)]
    assert not bandwidth.integer_range
    assert [(r.from_value, r.to_value) for r in descriptor(INPUT_DEPTH).integer_range] == [(1, 100000)]
    assert descriptor(INPUT_QOS).additional_constraints == "one of: reliable, best_effort"
    assert not descriptor(ROBOT).floating_point_range


@pytest.mark.parametrize(
    ("name", "reliability"),
    [("reliable", QoSReliabilityPolicy.RELIABLE), ("best_effort", QoSReliabilityPolicy.BEST_EFFORT)],
)
def test_profiles_do_what_they_are_called(name, reliability):
    profile = qos.profile(name, depth=7)
    assert profile.reliability == reliability
    assert profile.depth == 7
    assert profile.durability == QoSDurabilityPolicy.VOLATILE
    assert profile.history == QoSHistoryPolicy.KEEP_LAST


def test_every_profile_can_be_chosen():
    assert [qos.profile(name, 1).depth for name in qos.NAMES] == [1, 1]
