"""Links, joints and frames of a document as one tree that reaches the base."""

from __future__ import annotations

from ...ground.suggestions import did_you_mean, suggestion
from ..document import Document


class LinkTree:
    """The tree while its joints are checked.

    Attributes:
        base: name of the base link.
        links, joints, frames: entries of the document by name.
        parent_joint: the joint above each link, for the joints added so far.
    """

    def __init__(self, document: Document) -> None:
        self.document = document
        self.base: str = document.data.get("base", "base")
        self.links = document.entries("links")
        self.joints = document.entries("joints")
        self.frames = document.entries("frames")
        self.parent_joint: dict[str, str] = {}

    def hang(self, link: str, joint: str) -> None:
        """Add a joint to a link.

        Raises:
            DescriptionError: the link is the base, or has a joint already.
        """
        path = ("joints", joint, "child")
        if link == self.base:
            raise self.document.error(
                path, f"the base '{self.base}' cannot be a child; swap parent and child"
            )
        if link in self.parent_joint:
            raise self.document.error(
                path,
                f"link '{link}' already hangs on joint '{self.parent_joint[link]}'; a link has one"
                " joint to its parent: close the second connection with a loop or a closure",
            )
        self.parent_joint[link] = joint

    def carrier(self, name: str) -> str:
        """The link under a frame.

        Raises:
            DescriptionError: frames form a cycle.
        """
        visited: list[str] = []
        while name in self.frames and self.frames[name]["link"] != name:
            if name in visited:
                cycle = " on ".join([*visited, name])
                raise self.document.error(("frames", name), f"stands on itself: {cycle}")
            visited.append(name)
            name = self.frames[name]["link"]
        return name

    def check_base(self) -> None:
        """Check that the base exists, whether the file names it or not.

        Raises:
            DescriptionError: there is no such link.
        """
        loose = [link for link in self.links if link not in self.parent_joint]
        if "base" in self.document.data or self.base in self.links:
            self._check_named_base(loose)
        elif len(loose) == 1 and self.base not in self._carriers():
            link = loose[0]
            raise self.document.error(
                ("links", link),
                f"hangs on no joint, and no link is called '{self.base}'; if it is what does not"
                f" move, write `base: {link}`, or call it '{self.base}'",
            )

    def check_connected(self) -> None:
        """Check that every link reaches the base.

        Raises:
            DescriptionError: a link hangs on no joint, or the joints form a cycle.
        """
        for link in self.links:
            self._check_reaches_base(link)

    def _check_named_base(self, loose: list[str]) -> None:
        names = {*self.links, *self._carriers(), *self._tied()}
        if self.base in names:
            return
        hint = suggestion(self.base, loose or self.links)
        if len(loose) == 1:
            hint = did_you_mean(loose[0])
        raise self.document.error(
            ("base",),
            f"there is no link '{self.base}'{hint}; known: {', '.join(self.links)}",
        )

    def _check_reaches_base(self, link: str) -> None:
        chain = [link]
        while chain[-1] != self.base:
            joint = self._joint_to(chain[-1])
            parent = self.carrier(self.joints[joint]["parent"])
            if parent in chain:
                cycle = " -> ".join([*chain, parent])
                raise self.document.error(
                    ("joints", self.parent_joint[link]),
                    f"the joints form a cycle ({cycle}) that never reaches the base"
                    f" '{self.base}'; cut it at one joint and close it there with a loop or a"
                    " closure",
                )
            chain.append(parent)

    def _joint_to(self, link: str) -> str:
        if link not in self.parent_joint:
            raise self.document.error(
                ("links", link),
                "no joint has this link as its child; add the joint or remove the link",
            )
        return self.parent_joint[link]

    def _carriers(self) -> set[str]:
        """Names of links and frames that carry joints or frames."""
        carriers = {joint["parent"] for joint in self.joints.values()}
        return carriers | {frame["link"] for frame in self.frames.values()}

    def _tied(self) -> set[str]:
        """Names that closures tie."""
        tied: set[str] = set()
        for closure in self.document.entries("closures").values():
            tied.update(closure["between"])
        return tied
