"""The published JSON Schema: valid, described throughout, and of one mind with the loader."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from hybrid_dynamics_core import DescriptionError
from hybrid_dynamics_core.description.checks.schema import robot_schema
from hybrid_dynamics_core.description.expand.templates import find_template, shipped_templates
from hybrid_dynamics_core.description.located_yaml import read_yaml
from hybrid_dynamics_core.formats.reader import parse_description
from tests.description.robots import HEAD, four_bar, parse
from tests.sampling import SHIPPED_SAMPLE, swept

PACKAGE = Path(str(resources.files("hybrid_dynamics_core")))
ROBOTS = sorted((PACKAGE / "robots").glob("*.yaml"))
SLIPPED = [path for path in ROBOTS if path.stem in SHIPPED_SAMPLE]
TEMPLATES = sorted((PACKAGE / "templates").glob("*.yaml"))


def properties(node: Any, path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every property that the schema names, wherever it stands."""
    if isinstance(node, dict):
        for name, sub in (
            node.get("properties", {}).items() if isinstance(node.get("properties"), dict) else ()
        ):
            yield f"{path}.{name}", sub
        for key, sub in node.items():
            yield from properties(sub, f"{path}.{key}")
    elif isinstance(node, list):
        for k, sub in enumerate(node):
            yield from properties(sub, f"{path}[{k}]")


def test_schema_is_valid_and_named() -> None:
    schema = robot_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["$id"] == "urn:hybrid-dynamics:robot:1"


def test_every_property_is_described() -> None:
    """Editors show the description, beside the property or in the definition it refers to."""
    schema = robot_schema()
    described = dict(properties({**schema, "if": None}))
    assert len(described) > 100
    for path, entry in described.items():
        if set(entry) <= {"const", "enum"} and ".if." in path:
            continue
        definition = schema["$defs"][entry["$ref"].rpartition("/")[2]] if "$ref" in entry else {}
        assert "description" in entry or "description" in definition, path


def test_every_reference_has_its_definition() -> None:
    text = (PACKAGE / "description" / "robot.schema.json").read_text(encoding="utf-8")
    assert set(re.findall(r'"#/\$defs/(\w+)"', text)) <= set(robot_schema()["$defs"])


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_shipped_robots_fit(path: Path) -> None:
    document = read_yaml(path.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(robot_schema()).validate(document.data)


@pytest.mark.parametrize("path", TEMPLATES, ids=lambda path: path.stem)
def test_shipped_templates_fit_and_are_loaded_by_their_name(path: Path) -> None:
    document = read_yaml(path.read_text(encoding="utf-8"))
    schema = robot_schema()
    jsonschema.Draft202012Validator(
        {"$defs": schema["$defs"], "$ref": "#/$defs/template"}
    ).validate(document.data)
    name = document.data["template"]
    assert name in shipped_templates()
    assert find_template(read_yaml("{}"), name, ()).data == document.data
    for part in (document.data, document.data.get("legs", {})):
        for described in part.get("parameters", {}).values():
            assert described["about"]


MESSAGES = {
    "a list for the file": ("format: 1", "- format: 1", "not valid YAML"),
    "empty key": ("name: small", "'': small", "unknown key"),
    "a character": ("source: invented", "source: a\x00b", "the character U+0000 is not allowed"),
    "comma in an expression": (
        "origin: {xyz: [0.3, 0, 0]}",
        "origin: {xyz: [atan2(1, 2), 0, 0]}",
        "with a comma in quotes",
    ),
    "two arguments": (
        "xyz: [0.3, 0, 0]}, axis: z}",
        'xyz: ["sin(1, 2)", 0, 0]}, axis: z}',
        "sin() takes 1 value",
    ),
    "one argument": (
        "xyz: [0.3, 0, 0]}, axis: z}",
        'xyz: ["atan2(1)", 0, 0]}, axis: z}',
        "atan2() takes 2 values",
    ),
    "outside a domain": (
        "xyz: [0.3, 0, 0]}, axis: z}",
        "xyz: [acos(2), 0, 0]}, axis: z}",
        "acos(2) has no value",
    ),
    "unknown function": (
        "xyz: [0.3, 0, 0]}, axis: z}",
        "xyz: [exp(2), 0, 0]}, axis: z}",
        "and sqrt, abs, sin, cos",
    ),
    "an attribute": (
        "xyz: [0.3, 0, 0]}, axis: z}",
        "xyz: [a.b, 0, 0]}, axis: z}",
        "something else than numbers, parameters",
    ),
    "huge": (
        "xyz: [0.3, 0, 0]}, axis: z}",
        "xyz: [1e300, 0, 0]}, axis: z}",
        "expected a finite number",
    ),
    "date": ("source: invented", "source: 2020-01-01", "expected text"),
    "no links": ("active: [q1, q4]", "active: []", "has 0 entries; expected 1"),
    "empty name": ("active: [q1, q4]", 'active: [q1, ""]', "is empty"),
}


@pytest.mark.parametrize(("old", "new", "words"), MESSAGES.values(), ids=MESSAGES.keys())
def test_messages(old: str, new: str, words: str) -> None:
    text = four_bar("A")
    assert old in text
    with pytest.raises(DescriptionError) as caught:
        parse(text.replace(old, new, 1))
    assert words in str(caught.value)
    assert caught.value.line is not None


def test_other_documents() -> None:
    for text in (
        "",
        "3",
        "[1]",
        "a: &a [*a]",
        "? [1]\n: 2",
        "- " * 5000,
        HEAD + "x: !!python/name:os.system ''\n",
    ):
        with pytest.raises(DescriptionError):
            parse(text)


TOKEN = re.compile(r"[A-Za-z_]\w*|[\d.]+|\S")
JUNK = [
    "",
    "null",
    "-1",
    "0",
    "1e400",
    ".nan",
    "[]",
    "{}",
    "x",
    "1/0",
    "é",
    "q1",
    "base",
    "fixed",
    "on",
    "&a",
    "*a",
    "|",
    "~",
]


@pytest.mark.parametrize("path", swept(ROBOTS, SLIPPED), ids=lambda path: path.stem)
def test_a_slip_anywhere_is_a_message_or_another_robot(path: Path) -> None:
    """A word replaced by another one or by junk never ends in anything but a DescriptionError."""
    text = path.read_text(encoding="utf-8")
    chance = random.Random(3)  # noqa: S311  not for secrets
    words, said = list(TOKEN.finditer(text)), []
    for _ in range(40):
        at, other = chance.choice(words), chance.choice(words)
        new = chance.choice([other.group(), chance.choice(JUNK)])
        try:
            parse_description(text[: at.start()] + new + text[at.end() :], file="slip.yaml")
        except DescriptionError as error:
            said.append(str(error))
    assert all("slip.yaml" in message for message in said)
    assert said


@pytest.mark.parametrize(
    ("joint", "words"),
    [
        (
            "{type: fixd, parent: base, child: arm}",
            r"a\.type: is 'fixd' \(did you mean 'fixed'\?\); expected one of rev",
        ),
        ("{type: prismatic, parent: base, child: arm}", "a: missing 'axis'"),
        ("{parent: base, child: arm}", "a: missing 'type'"),
    ],
)
def test_a_wrong_type_is_reported_before_what_it_would_need(joint: str, words: str) -> None:
    text = (
        f"format: 1\nname: arm\nlinks: {{base: {{}}, arm: {{}}}}\njoints:\n  a: {joint}\nactive:"
        " [a]\n"
    )
    with pytest.raises(DescriptionError, match=words):
        parse_description(f"{text}end_effector: {{link: arm}}\n")
