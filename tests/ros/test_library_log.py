"""What the library says while a node runs stands in the node's log."""

from __future__ import annotations

import logging

from hybrid_dynamics_ros.node.library_log import LIBRARY, forwarded


class Lines:
    """A logger that keeps what it is told."""

    def __init__(self) -> None:
        self.told: list[tuple[str, str]] = []

    def info(self, message: str) -> None:
        self.told.append(("info", message))

    def warning(self, message: str) -> None:
        self.told.append(("warning", message))


def test_what_the_library_says_is_handed_on_for_as_long_as_it_is_wanted() -> None:
    lines, library = Lines(), logging.getLogger(LIBRARY)
    level, inner = library.level, logging.getLogger(f"{LIBRARY}.kernels.waiting")
    with forwarded(lines):
        inner.info("compiling %s", "close of arm")
        inner.warning("slow")
        inner.debug("nothing of interest")
    inner.warning("afterwards")
    assert lines.told == [("info", "compiling close of arm"), ("warning", "slow")]
    assert library.level == level
    assert not library.handlers
