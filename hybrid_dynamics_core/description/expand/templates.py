"""Templates of modules: where they are found, and what they hold."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from ...ground.suggestions import suggestion
from ..checks.schema import check_schema
from ..document import Document, Path_
from ..files import read_text
from ..located_yaml import read_yaml

_FOLDER = resources.files("hybrid_dynamics_core").joinpath("templates")


@dataclass(frozen=True, eq=False)
class Template:
    """A kind of module as data: parameters, and links, joints, frames and closures once and for every leg."""

    name: str
    data: dict[str, Any]


def shipped_templates() -> tuple[str, ...]:
    """Names that need no path."""
    return tuple(
        sorted(_shipped(f.name).name for f in _FOLDER.iterdir() if f.name.endswith(".yaml"))
    )


def find_template(document: Document, name: str, path: Path_) -> Template:
    """By name from the document's own `templates` or the shipped ones, or by the path of a file."""
    own = document.data.get("templates", {})
    if name in own:
        return Template(name, own[name])
    if name.endswith((".yaml", ".yml")):
        folder = Path(document.file).parent if document.file else Path()
        if not (folder / name).is_file():
            raise document.error(
                path,
                f"there is no file {folder / name}; the path starts at the folder of this file",
            )
        return _parse(read_text(folder / name), folder / name)
    if name not in shipped_templates():
        known = [*own, *shipped_templates()]
        problem = (
            f"there is no template '{name}'{suggestion(name, known)}; known: {', '.join(known)}, or a"
            " path to a file"
        )
        raise document.error(path, problem)
    return _shipped(name.replace("/", "-") + ".yaml")


@cache
def _shipped(file: str) -> Template:
    return _parse(_FOLDER.joinpath(file).read_text(encoding="utf-8"), Path(file))


def _parse(text: str, file: Path) -> Template:
    document = read_yaml(text, file)
    check_schema(document, "template")
    if "template" not in document.data:
        raise document.error((), "missing 'template', the name of the template")
    return Template(document.data["template"], document.data)
