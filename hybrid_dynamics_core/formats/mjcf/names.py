"""Names of bodies and joints: those of the file, or generated ones."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from .compiler.compiled import Body, Joint

WORLD = "world"


class Names:
    """Names by number.

    Attributes:
        bodies: `body3` and the like for those without a name.
        joints: `joint7` and the like for those without a name.
        given: generated names, by kind.
    """

    def __init__(self, bodies: Sequence[Body], joints: Sequence[Joint]) -> None:
        self.given: dict[str, list[str]] = {}
        self._taken = {
            "body": {WORLD, *_written(bodies)},
            "joint": {*_written(joints)},
        }
        self.bodies = [self._name("body", k, body.name) for k, body in enumerate(bodies)]
        self.joints = [self._name("joint", k, joint.name) for k, joint in enumerate(joints)]

    def free(self, kind: str, name: str) -> str:
        """A name that no other body or joint has."""
        taken = self._taken[kind]
        while name in taken:
            name += "_"
        taken.add(name)
        return name

    def _name(self, kind: str, number: int, written: str) -> str:
        if written:
            return written
        name = self.free(kind, f"{kind}{number}")
        self.given.setdefault(kind, []).append(name)
        return name


def _written(elements: Iterable[Body | Joint]) -> list[str]:
    return [element.name for element in elements if element.name]
