"""What the two packages say of themselves agrees, in every place that says it."""

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
    assert all(
        ElementTree.parse(manifest).find("license").get("file") == "LICENSE"
        for manifest in MANIFESTS
    )


def test_the_interfaces_that_are_built_are_those_that_are_there() -> None:
    cmake = (ROOT / "msg_defs" / "CMakeLists.txt").read_text(encoding="utf-8")
    there = sorted([*ROOT.glob("msg_defs/msg/*.msg"), *ROOT.glob("msg_defs/srv/*.srv")])
    built = [
        line.strip().strip('"')
        for line in cmake.splitlines()
        if line.strip().endswith(('.msg"', '.srv"'))
    ]
    assert built == [str(path.relative_to(ROOT / "msg_defs")) for path in there]


@pytest.mark.parametrize(
    "path", sorted(ROOT.glob("msg_defs/*/*.[ms][sr][gv]")), ids=lambda path: path.name
)
def test_every_field_of_an_interface_is_explained(path: Path) -> None:
    for block in path.read_text(encoding="utf-8").replace("---\n", "\n").split("\n\n"):
        lines = block.strip().splitlines()
        explained = all("#" in line for line in lines) or lines[0].startswith("#")
        assert explained, f"no comment above: {block}"


def test_the_ros_wheels_are_pinned_alike_everywhere() -> None:
    build = tomllib.loads((ROOT / "msg_defs" / "pyproject.toml").read_text(encoding="utf-8"))[
        "build-system"
    ]
    setups = [
        (ROOT / folder / "setup.py").read_text(encoding="utf-8") for folder in (".", "msg_defs")
    ]
    for pin in (requirement for requirement in build["requires"] if "-msgs==" in requirement):
        assert all(pin in setup for setup in setups), pin


@pytest.mark.ros
def test_the_shipped_parameters_are_all_of_the_node_with_their_defaults() -> None:
    from hybrid_dynamics_ros.parameters import TABLE

    text = (ROOT / "config" / "forging_chu2020.yaml").read_text(encoding="utf-8")
    values = flat(yaml.safe_load(text)["/**"]["ros__parameters"])
    given = {
        name: tuple(value) if isinstance(value, list) else value for name, value in values.items()
    }
    assert given == {row.name: row.default for row in TABLE if row.default is not None}
    for row in TABLE:
        assert row.text.split()[0] in text
        assert f"{row.name.rpartition('.')[2]}: " in text


@pytest.mark.ros
def test_every_shipped_robot_has_parameters_that_the_node_knows() -> None:
    from hybrid_dynamics_ros.parameters import TABLE

    known = {row.name for row in TABLE}
    assert {path.stem for path in ROOT.glob("config/*.yaml")} == set(
        hybrid_dynamics_core.shipped_robots()
    )
    for path in ROOT.glob("config/*.yaml"):
        values = flat(yaml.safe_load(path.read_text(encoding="utf-8"))["/**"]["ros__parameters"])
        assert values["robot"] == path.stem
        assert set(values) <= known


def flat(tree: dict, prefix: str = "") -> dict:
    """{"a": {"b": 1}} as {"a.b": 1}."""
    entries = {}
    for key, value in tree.items():
        entries |= (
            flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value}
        )
    return entries
