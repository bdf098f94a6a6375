"""From loads with names to a LoadPattern and the input arrays of kernels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..algebra.vector import Vector, constant
from ..description.effects import Payload
from ..description.model import Frame
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.wording import counted
from ..mechanism.inertia import parallel_axis_term
from ..mechanism.tree import Tree
from .load_pattern import FRICTION, INERTIAL, SPRINGS, WRENCH, LoadPattern
from .loads import AppliedWrench, Loads

FindFrame = Callable[[str], Frame]


class _FrameWrench(NamedTuple):
    """A wrench in base axes, (6,) or (N, 6), at a place (3,) [m] of a body."""

    body: int
    place: Vector
    values: Array


def pack_loads(
    loads: Loads, tree: Tree, find: FindFrame, rows: int | None
) -> tuple[LoadPattern, dict[str, Array]]:
    """The pattern of loads, and their values.

    Args:
        loads: the loads. Those on the base have no effect.
        tree: the spanning tree.
        find: gives a frame by its name.
        rows: number of states, None for a single one.

    Returns:
        The pattern, and its input arrays by name.

    Raises:
        InputError: a frame does not exist, or a batch has another length.
    """
    _require_coordinates(loads, tree)
    payloads = _payloads(loads, tree, find)
    in_base_axes, in_link_axes = _wrenches(loads, tree, find, rows)
    pattern = LoadPattern(
        payloads=tuple(payloads),
        frames=tuple((wrench.body, wrench.place) for wrench in in_base_axes),
        links=tuple(in_link_axes),
        friction=loads.effects.has_friction,
        drives=loads.effects.has_drives,
        springs=loads.effects.has_springs,
        gravity=_components(loads.gravity),
    )
    arrays = {
        "payloads": np.concatenate([*payloads.values(), np.empty(0)]),
        "frame_wrenches": _side_by_side([wrench.values for wrench in in_base_axes]),
        "link_wrenches": _side_by_side(list(in_link_axes.values())),
    }
    for name in (*FRICTION, *SPRINGS, "armature"):
        arrays[name] = getattr(loads.effects, name)
    return pattern, {name: arrays[name] for name in pattern.inputs}


def inertial_parameters(payload: Payload, frame: Frame) -> Array:
    """The ten inertial parameters of a payload about the origin of its link, in link axes.

    Args:
        payload: the body that is fixed to the frame.
        frame: a frame on the link.

    Returns:
        (10,), in the order of `inertial_vector`.
    """
    com = frame.translation + frame.rotation @ np.asarray(payload.com)
    inertia = frame.rotation @ np.asarray(payload.inertia) @ frame.rotation.T
    return inertial_vector(payload.mass, com, inertia)


def inertial_vector(mass: float, com: Array, inertia: Array) -> Array:
    """The ten inertial parameters of a body about the origin of its link.

    Args:
        mass: [kg].
        com: centre of mass (3,) [m].
        inertia: about the centre of mass (3, 3) [kg m^2].

    Returns:
        m, m c (3), Jxx, Jxy, Jxz, Jyy, Jyz, Jzz, about the origin.
    """
    about_origin = inertia + parallel_axis_term(mass, com)
    components = about_origin[np.triu_indices(3)]
    return np.array([mass, *(mass * com), *components])


def _components(gravity: Array) -> tuple[bool, bool, bool]:
    """Which components of gravity differ from zero."""
    x, y, z = gravity.tolist()
    return (x != 0.0, y != 0.0, z != 0.0)


def _require_coordinates(loads: Loads, tree: Tree) -> None:
    """Raise if the joint effects are those of another robot."""
    size = len(loads.effects.viscous)
    if size != len(tree.coordinates):
        names = ", ".join(tree.coordinates)
        raise InputError(
            f"the joint effects have {counted(size, 'entry', 'entries')}; the robot's coordinates"
            f" are {names}"
        )


def _payloads(loads: Loads, tree: Tree, find: FindFrame) -> dict[int, Array]:
    """Inertial parameters (10,) of all payloads of a body, by body, in ascending order."""
    total: dict[int, Array] = {}
    for name, payloads in loads.payloads.items():
        frame = find(name)
        body = tree.body_index(frame.link)
        if body < 0:
            continue
        for payload in payloads:
            before = total.get(body, np.zeros(INERTIAL))
            total[body] = before + inertial_parameters(payload, frame)
    return dict(sorted(total.items()))


def _wrenches(
    loads: Loads, tree: Tree, find: FindFrame, rows: int | None
) -> tuple[list[_FrameWrench], dict[int, Array]]:
    """Wrenches in base axes, and those in link axes about the link origin, summed per body."""
    in_base_axes: list[_FrameWrench] = []
    in_link_axes: dict[int, Array] = {}
    for name, wrench in loads.wrenches.items():
        frame = find(name)
        body = tree.body_index(frame.link)
        _require_rows(name, wrench, rows)
        if body < 0:
            continue
        if wrench.axes == "base":
            place = constant(frame.translation)
            in_base_axes.append(_FrameWrench(body, place, wrench.values))
        else:
            before = in_link_axes.get(body, np.zeros(WRENCH))
            in_link_axes[body] = before + _at_origin(wrench, frame)
    return in_base_axes, in_link_axes


def _require_rows(name: str, wrench: AppliedWrench, rows: int | None) -> None:
    """Raise if a wrench of a batch does not have a row for each state."""
    if wrench.values.ndim != 2 or len(wrench.values) == rows:
        return
    expected = 1
    if rows is not None:
        expected = rows
    raise InputError(
        f"the wrench on '{name}' has {counted(len(wrench.values), 'row')}; it acts on"
        f" {counted(expected, 'state')}"
    )


def _at_origin(wrench: AppliedWrench, frame: Frame) -> Array:
    """A wrench in frame axes, in link axes about the link origin: (6,) or (N, 6)."""
    force = wrench.values[..., :3] @ frame.rotation.T
    moment = wrench.values[..., 3:] @ frame.rotation.T
    about_origin = moment + np.cross(frame.translation, force)
    return np.concatenate([force, about_origin], axis=-1)


def _side_by_side(parts: Sequence[Array]) -> Array:
    """Concatenate vectors (k,) or (N, k); if one has rows, all are repeated for each row."""
    rows = [len(part) for part in parts if part.ndim == 2]
    if rows:
        parts = [np.broadcast_to(part, (rows[0], part.shape[-1])) for part in parts]
    if not parts:
        return np.empty(0)
    return np.concatenate(parts, axis=-1)
