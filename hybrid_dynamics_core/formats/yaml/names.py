"""Replacement of names that a description file does not allow."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable

from ...description.model import RobotDescription

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./-]{0,199}")
_OTHERS = re.compile(r"[^A-Za-z0-9_./-]")
_LONGEST = 190  # leaves room for a suffix that makes a name unique


class Names:
    """Names of a robot, mapped to names in the file.

    Attributes:
        changed: new names by old ones, if they differ.
    """

    def __init__(self, robot: RobotDescription) -> None:
        self.changed: dict[str, str] = {}
        self._add([robot.name])
        self._add([robot.base, *robot.links, *robot.parts, *robot.frames])
        self._add(robot.joints)
        self._add([*(closure.name for closure in robot.closures), *robot.payloads])
        self._add(robot.transmissions)

    def __getitem__(self, name: str) -> str:
        """The name in the file."""
        return self.changed.get(name, name)

    def list(self, names: Iterable[str]) -> list[str]:
        """Names in the file."""
        return [self[name] for name in names]

    def _add(self, names: Collection[str]) -> None:
        """Map names that must differ from each other."""
        taken = {*names, *self.changed.values()}
        for name in names:
            if _NAME.fullmatch(name) or name in self.changed:
                continue
            new_name = _OTHERS.sub("_", name)[:_LONGEST].lstrip("./-") or "_"
            while new_name in taken:
                new_name += "_"
            taken.add(new_name)
            self.changed[name] = new_name
