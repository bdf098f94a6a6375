"""Reactions of pins, joints and the foundation, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..description.model import Closure
from ..errors import UnknownNameError
from ..ground.arrays import Array, Picklable
from ..ground.suggestions import no_such_name
from ..mechanism.tree import Tree
from .pins import Pin

T = TypeVar("T")
UNDEFINED = 1e-10  # share below which a pin's force would lose half its digits


@dataclass(frozen=True, eq=False)
class PinReaction:
    """The wrench in a closure, in base axes; a batch has a leading N.

    Attributes:
        place: (3,) the pin [m].
        force: (3,) [N] on link a, by link b.
        moment: (3,) [N m] about the pin, on link a.
        links: names of link a and link b.
        silent: undetermined directions, in x, y, z of the pin; z is the normal of a planar loop.
            With rigid links, a closure and the joints of its loop may share such a load in any way.
            It is assigned to the joints.
        share: how well force and moment are determined by the forces along the joints, 1 at best.
            They are NaN where this is 0 to working precision. An example is a parallelogram with
            all bars in line: the force along them may have any value.
    """

    place: Array
    force: Array
    moment: Array
    links: tuple[str, str]
    silent: tuple[str, ...]
    share: float | Array


@dataclass(frozen=True, eq=False)
class JointReaction:
    """The wrench that a joint transmits to its link, in base axes; a batch has a leading N.

    Attributes:
        place: (3,) origin of the link that the joint carries [m].
        force: (3,) [N] on that link, by the link before it.
        moment: (3,) [N m] about the place. Along the joint's axis, force or moment is that of the
            actuator minus friction, springs and rotor. It is zero for a passive joint without them.
        links: names of the link before and of the link that the joint carries.
    """

    place: Array
    force: Array
    moment: Array
    links: tuple[str, str]


class Named(dict[str, T]):
    """Values by name; the error for an unknown name lists all names."""

    def __init__(self, kind: str, values: Mapping[str, T]) -> None:
        super().__init__(values)
        self.kind = kind

    def __missing__(self, name: object) -> T:
        raise UnknownNameError(no_such_name(self.kind, str(name), self))


@dataclass(frozen=True, eq=False)
class Reactions(Picklable):
    """All reactions at a state and acceleration; a batch has a leading N.

    An unknown name raises UnknownNameError, a KeyError.

    Attributes:
        tau: (n,) actuator forces [N m, N].
        pins: reactions by closure.
        joints: reactions by joint.
        base: (6,) force [N] and moment [N m] about the base origin that the foundation exerts on
            the robot, base axes.
    """

    tau: Array
    pins: Mapping[str, PinReaction]
    joints: Mapping[str, JointReaction]
    base: Array

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore the fields, with the names."""
        pins = Named("pin", state["pins"])
        joints = Named("joint", state["joints"])
        super().__setstate__({**state, "pins": pins, "joints": joints})


def named_reactions(
    values: Mapping[str, Array], pins: Sequence[Pin], tree: Tree, closures: Sequence[Closure]
) -> Reactions:
    """The flat results of the program with their names.

    Args:
        values: results of `programs.reactions`; undetermined ones are set to NaN in place.
        pins: the pins of the program.
        tree: the spanning tree.
        closures: the closures of the pins.
    """
    undefined = ~(values["pin_shares"] > UNDEFINED)
    shares = values["pin_shares"]
    has_answer = np.isfinite(values["tau"][..., :1])
    shares[np.isnan(shares) & has_answer] = 0.0
    if undefined.any():
        _empty(values, undefined, pins, tree)
    by_pin: dict[str, PinReaction] = {}
    for k, (pin, closure) in enumerate(zip(pins, closures, strict=True)):
        by_pin[pin.name] = _pin(values, k, pin, closure)
    by_joint: dict[str, JointReaction] = {}
    for i, body in enumerate(tree.bodies):
        by_joint[body.joint] = _joint(values, i, tree)
    return Reactions(
        values["tau"],
        MappingProxyType(Named("pin", by_pin)),
        MappingProxyType(Named("joint", by_joint)),
        values["base"],
    )


def _empty(
    values: Mapping[str, Array], undefined: NDArray[np.bool_], pins: Sequence[Pin], tree: Tree
) -> None:
    """Set undetermined pins, and the joints between their bodies, to NaN."""
    for key in ("pin_forces", "pin_moments"):
        values[key][undefined] = np.nan
    for k, pin in enumerate(pins):
        side_a, side_b, _ = tree.branches(pin.body_a, pin.body_b)
        for i in (*side_a, *side_b):
            for key in ("joint_forces", "joint_moments"):
                values[key][..., i, :][undefined[..., k]] = np.nan


def _pin(values: Mapping[str, Array], k: int, pin: Pin, closure: Closure) -> PinReaction:
    shares = values["pin_shares"][..., k]
    share: float | Array = shares
    if shares.ndim == 0:
        share = float(shares)
    return PinReaction(
        place=values["pin_places"][..., k, :],
        force=values["pin_forces"][..., k, :],
        moment=values["pin_moments"][..., k, :],
        links=(closure.link_a, closure.link_b),
        silent=pin.silent,
        share=share,
    )


def _joint(values: Mapping[str, Array], i: int, tree: Tree) -> JointReaction:
    body = tree.bodies[i]
    before = tree.base
    if body.parent >= 0:
        before = tree.bodies[body.parent].name
    return JointReaction(
        place=values["joint_places"][..., i, :],
        force=values["joint_forces"][..., i, :],
        moment=values["joint_moments"][..., i, :],
        links=(before, body.name),
    )
