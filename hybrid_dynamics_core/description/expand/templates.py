"""Templates of modules, and the search for them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path

from ...ground.regular_files import may_be_file
from ...ground.suggestions import suggestion
from ..checks.schema import check_schema
from ..document import Data, Document, KeyPath
from ..files import read_text
from ..located_yaml import read_yaml

_FOLDER = resources.files("hybrid_dynamics_core").joinpath("templates")


@dataclass(frozen=True, eq=False)
class Template:
    """A template: parameters, and entries to add once and for every leg.

    Attributes:
        name: the name by which modules refer to it.
        data: entries of the template.
    """

    name: str
    data: Data


def shipped_templates() -> tuple[str, ...]:
    """Names of the templates in this package."""
    files = [file.name for file in _FOLDER.iterdir() if file.name.endswith(".yaml")]
    return tuple(sorted(_shipped(file).name for file in files))


def shipped_template(name: str) -> Template:
    """The template of a name in this package."""
    return _shipped(name.replace("/", "-") + ".yaml")


def find_template(document: Document, name: str, path: KeyPath) -> Template:
    """The template of a module.

    Args:
        document: may contain templates of its own.
        name: name of a template in the document or in this package, or path of a file relative to
            the document's folder.
        path: path of the entry that names the template.

    Raises:
        DescriptionError: there is no such template, or its file is wrong.
    """
    given_templates = document.entries("templates")
    if name in given_templates:
        return Template(name, given_templates[name])
    if name.endswith((".yaml", ".yml")):
        return _from_file(document, name, path)
    if name not in shipped_templates():
        names = [*given_templates, *shipped_templates()]
        hint = suggestion(name, names)
        raise document.error(
            path,
            f"there is no template '{name}'{hint}; known: {', '.join(names)}, or a path to a file",
        )
    return shipped_template(name)


def _from_file(document: Document, name: str, path: KeyPath) -> Template:
    folder = Path()
    if document.file:
        folder = Path(document.file).parent
    file = folder / name
    if not may_be_file(file):
        raise document.error(
            path, f"there is no file {file}; the path starts at the folder of this file"
        )
    return _parse(read_text(file), file)


@cache
def _shipped(file: str) -> Template:
    text = _FOLDER.joinpath(file).read_text(encoding="utf-8")
    return _parse(text, Path(file))


def _parse(text: str, file: Path) -> Template:
    document = read_yaml(text, file)
    check_schema(document, "template")
    if "template" not in document.data:
        raise document.error((), "missing 'template', the name of the template")
    return Template(document.data["template"], document.data)
