"""What every text file of the repository keeps to, for pre-commit.

python tools/check_files.py FILE ...

No blanks at ends of lines, one newline at the end, no marks of a merge. YAML, JSON, TOML and XML
parse.
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.parsers import expat

import yaml

MARK = re.compile(r"^(<{7} |={7}$|>{7} )")


def parse_xml(text: str) -> None:
    """Raise where a text is not XML."""
    expat.ParserCreate().Parse(text, True)


def parse_yaml(text: str) -> None:
    """Raise where a text is not YAML; its tags may be any."""
    for _ in yaml.parse(text, Loader=yaml.SafeLoader):
        pass


PARSERS: dict[str, Callable[[str], object]] = {
    ".json": json.loads,
    ".toml": tomllib.loads,
    ".xml": parse_xml,
    ".yaml": parse_yaml,
    ".yml": parse_yaml,
}
BAD = (ValueError, yaml.YAMLError, expat.ExpatError)


def problems(path: Path) -> Iterator[str]:
    """What is wrong with a file, each with its place."""
    text = path.read_text(encoding="utf-8")
    for number, line in enumerate(text.split("\n"), 1):
        if line != line.rstrip():
            yield f"{path}:{number}: blanks at the end of the line"
        if MARK.match(line):
            yield f"{path}:{number}: a mark of a merge"
    if text and (not text.endswith("\n") or text.endswith("\n\n")):
        yield f"{path}: does not end with one newline"
    try:
        PARSERS.get(path.suffix, str)(text)
    except BAD as error:
        yield f"{path}: {error}"


def main(paths: list[str]) -> int:
    """Print every problem; 1 where there are any."""
    status = 0
    for path in paths:
        for problem in problems(Path(path)):
            print(problem)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
