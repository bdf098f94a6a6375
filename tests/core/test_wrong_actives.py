"""Active joints that are too few, too many or the wrong ones: which others there are to name."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load

DRIVES = ("slew", "boom_cylinder", "stick_cylinder", "bucket_cylinder")  # of the excavator


def refused(*active: str) -> str:
    """What is said of an excavator with these active joints."""
    with pytest.raises(DescriptionError) as caught:
        Robot(replace(load("excavator").description, active=active))
    return caught.value.problem


@pytest.mark.parametrize(
    ("active", "words"),
    [
        (
            ("boom_cylinder", "stick_cylinder", "bucket_cylinder"),
            "name 4: besides those named, slew",
        ),  # a joint of no loop
        (
            ("slew", "stick_cylinder", "bucket_cylinder"),
            "name 4: besides those named, one of boom_pitch, boom_barrel_pitch, boom_cylinder",
        ),
        (
            ("stick_cylinder", "bucket_cylinder"),
            "name 4: besides those named, 2 of slew, boom_pitch, boom_barrel_pitch, boom_cylinder",
        ),
        ((*DRIVES, "boom_pitch"), "name 4: boom_loop would be fixed more than once"),
        (("coupler_pitch", *DRIVES[1:]), "name slew in place of one of bucket_bars"),
    ],
)
def test_what_else_may_be_named_is_told(active: tuple[str, ...], words: str) -> None:
    assert words in refused(*active)


def test_each_that_is_offered_is_accepted() -> None:
    offered = (
        refused("slew", "stick_cylinder", "bucket_cylinder").rpartition("one of ")[2].split(", ")
    )
    for name in offered:
        assert (
            len(
                Robot(
                    replace(
                        load("excavator").description,
                        active=("slew", name, "stick_cylinder", "bucket_cylinder"),
                    )
                ).active
            )
            == 4
        )
