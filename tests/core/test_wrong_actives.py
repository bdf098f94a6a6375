"""Active joints that are too few, too many or the wrong ones: which others there are to name."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load

DRIVES = ("q1", "q12", "q22", "q32")  # of the excavator


def refused(*active: str) -> str:
    """What is said of an excavator with these active joints."""
    with pytest.raises(DescriptionError) as caught:
        Robot(replace(load("excavator").description, active=active))
    return caught.value.problem


@pytest.mark.parametrize(
    ("active", "words"),
    [
        (("q12", "q22", "q32"), "name 4: besides those named, q1"),  # a joint of no loop
        (("q1", "q22", "q32"), "name 4: besides those named, one of q2, q11, q12"),
        (("q22", "q32"), "name 4: besides those named, 2 of q1, q2, q11, q12"),
        ((*DRIVES, "q2"), "name 4: boom_cylinder would be fixed more than once"),
        (("q34", *DRIVES[1:]), "name q1 in place of one of bucket_bars"),
    ],
)
def test_what_else_may_be_named_is_told(active: tuple[str, ...], words: str) -> None:
    assert refused(*active).endswith(words)


def test_each_that_is_offered_is_accepted() -> None:
    offered = refused("q1", "q22", "q32").rpartition("one of ")[2].split(", ")
    for name in offered:
        assert (
            len(
                Robot(
                    replace(load("excavator").description, active=("q1", name, "q22", "q32"))
                ).active
            )
            == 4
        )
