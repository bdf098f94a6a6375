"""The link that does not move: `base`, or the one that the key names."""

from __future__ import annotations

import pytest

from hybrid_dynamics_core import DescriptionError
from tests.description.robots import four_bar, parse

GROUND = four_bar("A").replace("base: {}", "ground: {}").replace("parent: base", "parent: ground")
GROUND = GROUND.replace("base: base", "base: ground")


def test_another_name_needs_the_key() -> None:
    with pytest.raises(DescriptionError) as caught:
        parse(GROUND)
    assert (
        str(caught.value)
        == "small.yaml:5: links.ground: hangs on no joint, and no link is called 'base'; if it is"
        " what does not move, write `base: ground`, or call it 'base'"
    )
    assert parse(GROUND + "base: ground\n").base == "ground"


def test_a_link_beside_a_base_lacks_its_joint() -> None:
    with pytest.raises(
        DescriptionError, match=r"links\.spare: no joint has this link as its child; add the joint"
    ):
        parse(four_bar("A").replace("  tool: {mass", "  spare: {}\n  tool: {mass"))


def test_of_two_loose_links_neither_is_taken_for_the_base() -> None:
    with pytest.raises(
        DescriptionError, match="no joint has this link as its child; add the joint"
    ):
        parse(GROUND.replace("  tool: {mass", "  spare: {}\n  tool: {mass"))


def test_a_link_that_others_hang_on_lacks_its_joint() -> None:
    text = "format: 1\nname: loose\nlinks: {a: {}, b: {}, c: {}}\n"
    text += "joints: {j: {type: revolute, parent: b, child: a, axis: z}}\n"
    text += "active: [j]\nend_effector: {link: a}\n"
    with pytest.raises(DescriptionError, match=r"links\.b: no joint has this link as its child"):
        parse(text)
