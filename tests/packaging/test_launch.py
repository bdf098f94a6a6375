"""The launch file: what its arguments make of the node. Stand-ins take the place of launch."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

FILE = Path(__file__).resolve().parents[2] / "launch" / "hybrid_dynamics.launch.py"


class Anything:
    """Keeps what it was made with."""

    def __init__(self, *given: Any, **named: Any) -> None:
        self.given, self.named = given, named

    def perform(self, context: dict[str, str]) -> str:
        """As a LaunchConfiguration does it."""
        return context[self.given[0]]


@pytest.fixture
def launch_file(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    names = {
        "launch": ("LaunchContext", "LaunchDescription"),
        "launch.actions": ("DeclareLaunchArgument", "OpaqueFunction"),
        "launch.substitutions": ("LaunchConfiguration",),
        "launch_ros": (),
        "launch_ros.actions": ("Node",),
    }
    for module, classes in names.items():
        stand_in = ModuleType(module)
        for name in classes:
            setattr(stand_in, name, Anything)
        monkeypatch.setitem(sys.modules, module, stand_in)
    return SimpleNamespace(**runpy.run_path(str(FILE)))


def node_of(launch_file: SimpleNamespace, **arguments: str) -> dict[str, Any]:
    context = {name: default for name, default, _ in launch_file.ARGUMENTS}
    assert set(arguments) <= set(context)
    (node,) = launch_file.start_node(context | arguments)
    named: dict[str, Any] = node.named
    return named


def test_without_arguments_the_parameters_have_their_defaults(launch_file: SimpleNamespace) -> None:
    node = node_of(launch_file)
    assert node["parameters"] == [
        {"robot": "forging_chu2020", "autostart": True, "use_sim_time": False}
    ]
    assert node["ros_arguments"] == ["--log-level", "info"]
    assert (node["respawn"], node["namespace"]) == (False, "")


def test_every_argument_reaches_the_node(launch_file: SimpleNamespace) -> None:
    node = node_of(
        launch_file,
        params_file="file.yaml",
        namespace="left",
        qos="sensor_data",
        log_level="debug",
        respawn="true",
    )
    first, arguments = node["parameters"]
    assert first == "file.yaml"
    assert (arguments["qos.input"], arguments["qos.output"]) == ("sensor_data", "sensor_data")
    assert node["ros_arguments"] == ["--log-level", "debug"]
    assert (node["respawn"], node["namespace"]) == (True, "left")


def test_every_argument_is_declared_with_a_text(launch_file: SimpleNamespace) -> None:
    (actions,) = launch_file.generate_launch_description().given
    declared = {action.given[0]: action.named for action in actions[:-1]}
    assert set(declared) >= {"log_level", "respawn", "qos", "namespace"}
    assert all(named["description"] for named in declared.values())
