"""What the two packages say of themselves agrees, in every place that says it."""

import re
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

import hybrid_dynamics_core

ROOT = Path(__file__).resolve().parents[2]
MANIFESTS = [ROOT / "package.xml", ROOT / "msg_defs" / "package.xml"]


@pytest.mark.parametrize("manifest", MANIFESTS, ids=lambda path: path.parent.name)
def test_both_packages_have_the_version_of_the_library(manifest: Path) -> None:
    assert ElementTree.parse(manifest).findtext("version") == hybrid_dynamics_core.__version__


def test_both_packages_carry_the_licence() -> None:
    """The interfaces are released from a branch that holds their folder alone."""
    texts = {manifest.with_name("LICENSE").read_text(encoding="utf-8") for manifest in MANIFESTS}
    assert len(texts) == 1
    for manifest in MANIFESTS:
        assert ElementTree.parse(manifest).find("license").get("file") == "LICENSE"


def test_the_interfaces_that_are_built_are_those_that_are_there() -> None:
    cmake = (ROOT / "msg_defs" / "CMakeLists.txt").read_text(encoding="utf-8")
    kinds = ("action", "msg", "srv")
    files = sorted(path for kind in kinds for path in ROOT.glob(f"msg_defs/{kind}/*.{kind}"))
    lines = [line.strip() for line in cmake.splitlines()]
    built = [line.strip('"') for line in lines if line.endswith(('.action"', '.msg"', '.srv"'))]
    assert built == [str(path.relative_to(ROOT / "msg_defs")) for path in files]


@pytest.mark.parametrize(
    "path",
    sorted([*ROOT.glob("msg_defs/*/*.[ms][sr][gv]"), *ROOT.glob("msg_defs/action/*.action")]),
    ids=lambda path: path.name,
)
def test_every_field_of_an_interface_is_explained(path: Path) -> None:
    for block in path.read_text(encoding="utf-8").replace("---\n", "\n").split("\n\n"):
        lines = block.strip().splitlines()
        explained = all("#" in line for line in lines) or lines[0].startswith("#")
        assert explained, f"no comment above: {block}"


def test_the_ros_wheels_are_pinned_alike_everywhere() -> None:
    settings = tomllib.loads((ROOT / "msg_defs/pyproject.toml").read_text(encoding="utf-8"))
    setup = (ROOT / "setup.py").read_text(encoding="utf-8")
    setup_of_messages = (ROOT / "msg_defs/setup.py").read_text(encoding="utf-8")
    for requirement in settings["build-system"]["requires"]:
        if "-msgs==" in requirement:
            assert requirement in setup
            assert requirement in setup_of_messages


@pytest.mark.ros
def test_the_shipped_parameters_are_all_of_the_node_with_their_defaults() -> None:
    from hybrid_dynamics_ros.parameters import TABLE

    text = (ROOT / "config" / "forging_chu2020.yaml").read_text(encoding="utf-8")
    values = flat(yaml.safe_load(text)["/**"]["ros__parameters"])
    for name, value in values.items():
        if isinstance(value, list):
            values[name] = tuple(value)
    assert values == {row.name: row.default for row in TABLE if row.default is not None}
    comments = re.sub(r"\n *# ", " ", text)
    for row in TABLE:
        assert row.text in comments
        assert f"{row.name.rpartition('.')[2]}: " in text


@pytest.mark.ros
def test_every_shipped_robot_has_parameters_of_the_node() -> None:
    from hybrid_dynamics_ros.parameters import TABLE

    parameters = {row.name for row in TABLE}
    files = list(ROOT.glob("config/*.yaml"))
    assert {path.stem for path in files} == set(hybrid_dynamics_core.shipped_robots())
    for path in files:
        values = flat(yaml.safe_load(path.read_text(encoding="utf-8"))["/**"]["ros__parameters"])
        assert values["robot"] == path.stem
        assert set(values) <= parameters


def flat(tree: dict, prefix: str = "") -> dict:
    """{"a": {"b": 1}} as {"a.b": 1}."""
    entries = {}
    for key, value in tree.items():
        if isinstance(value, dict):
            entries |= flat(value, f"{prefix}{key}.")
        else:
            entries[f"{prefix}{key}"] = value
    return entries
