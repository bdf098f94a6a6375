"""Parameter files offline: the sections that the node would read."""

import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.bags.errors import BagError
from hybrid_dynamics_ros.bags.settings import make_pipeline, read_settings
from hybrid_dynamics_ros.parameters import GRAVITY, MEASURED, PAYLOAD_MASS, ParameterError

MASS = "{}:\n  ros__parameters:\n    payload: {{mass: {}}}\n"


@pytest.mark.parametrize(
    "name",
    ["hybrid_dynamics", "/hybrid_dynamics", "/**", "/**/hybrid_dynamics", "/arm/hybrid_dynamics"],
)
def test_a_section_for_the_node_is_read_wherever_it_stands(tmp_path, name):
    other = "/camera:\n  ros__parameters:\n    gravity: [0.0, 0.0, -1.0]\n"
    for text in (MASS.format(name, 200.0) + other, other + MASS.format(name, 200.0)):
        (tmp_path / "p.yaml").write_text(text, encoding="utf-8")
        settings = read_settings(tmp_path / "p.yaml")
        assert settings[PAYLOAD_MASS] == 200.0
        assert settings[GRAVITY] is None


def test_a_later_section_wins(tmp_path):
    (tmp_path / "p.yaml").write_text(
        MASS.format("/**", 1.0) + MASS.format("/hybrid_dynamics", 2.0), encoding="utf-8"
    )
    assert read_settings(tmp_path / "p.yaml")[PAYLOAD_MASS] == 2.0


def test_a_file_for_other_nodes_is_refused(tmp_path):
    (tmp_path / "p.yaml").write_text(
        MASS.format("/camera", 1.0) + MASS.format("/lidar", 2.0), encoding="utf-8"
    )
    with pytest.raises(BagError, match=r"camera, /lidar.*hybrid_dynamics"):
        read_settings(tmp_path / "p.yaml")


def test_sensors_of_unknown_joints_are_refused(tmp_path):
    text = "/**:\n  ros__parameters:\n    sensors: {q99: {offset: 0.1}}\n"
    (tmp_path / "p.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ParameterError, match=r"q99.*measured are q1"):
        make_pipeline(load("forging_chu2020"), read_settings(tmp_path / "p.yaml"))


def test_a_dump_of_all_parameters_is_read(tmp_path):
    """`ros2 param dump` writes the names of ROS too, and empty arrays for what is not set."""
    (tmp_path / "p.yaml").write_text(DUMP, encoding="utf-8")
    settings = read_settings(tmp_path / "p.yaml")
    assert (settings[GRAVITY], settings[MEASURED]) == (None, None)
    assert settings[PAYLOAD_MASS] == 3.0


DUMP = """\
/hybrid_dynamics:
  ros__parameters:
    gravity: []
    measured: []
    payload:
      mass: 3.0
    qos_overrides:
      /parameter_events:
        publisher:
          depth: 1000
    start_type_description_service: true
    use_sim_time: false
"""
