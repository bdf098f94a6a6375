"""Loads with names and units -> which loads there are (LoadPattern) and the arrays a kernel takes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..algebra.vector import constant
from ..description.effects import Payload
from ..description.model import Frame
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.wording import counted
from ..mechanism.tree import Tree
from .load_pattern import FRICTION, SPRINGS, LoadPattern
from .loads import AppliedWrench, Loads

FindFrame = Callable[[str], Frame]


def pack_loads(
    loads: Loads, tree: Tree, find: FindFrame, rows: int | None
) -> tuple[LoadPattern, dict[str, Array]]:
    """The pattern and its input arrays for one state (`rows` None) or a batch. What is on the base has no effect.

    Raises InputError for unknown frames and batches of another length.
    """
    if len(loads.effects.viscous) != len(tree.coordinates):
        count = counted(len(loads.effects.viscous), "entry", "entries")
        told = ", ".join(tree.coordinates)
        raise InputError(f"the joint effects have {count}; the robot's coordinates are {told}")
    payloads = _payloads(loads, tree, find)
    fixed, turning = _wrenches(loads, tree, find, rows)
    pattern = LoadPattern(
        payloads=tuple(payloads),
        frames=tuple((body, place) for body, place, _ in fixed),
        links=tuple(turning),
        friction=loads.effects.has_friction,
        drives=loads.effects.has_drives,
        springs=loads.effects.has_springs,
    )
    arrays = {
        "payloads": np.concatenate([*payloads.values(), np.empty(0)]),
        "frame_wrenches": _joined([values for _, _, values in fixed]),
        "link_wrenches": _joined(list(turning.values())),
        **{name: getattr(loads.effects, name) for name in (*FRICTION, *SPRINGS, "armature")},
    }
    return pattern, {name: arrays[name] for name in pattern.inputs}


def inertial_parameters(payload: Payload, frame: Frame) -> Array:
    """The ten inertial parameters of a payload about the origin of the link that carries its frame, in link axes."""
    com = frame.translation + frame.rotation @ np.asarray(payload.com)
    inertia = frame.rotation @ np.asarray(payload.inertia) @ frame.rotation.T
    return inertial_vector(payload.mass, com, inertia)


def inertial_vector(mass: float, com: Array, inertia: Array) -> Array:
    """m, m c (3), Jxx, Jxy, Jxz, Jyy, Jyz, Jzz about the origin, from the inertia about the centre of mass."""
    about = inertia + mass * (com @ com * np.eye(3) - np.outer(com, com))
    return np.array([mass, *(mass * com), *about[np.triu_indices(3)]])


def _payloads(loads: Loads, tree: Tree, find: FindFrame) -> dict[int, Array]:
    total: dict[int, Array] = {}
    for name, payloads in loads.payloads.items():
        frame = find(name)
        body = tree.body_index(frame.link)
        for payload in payloads if body >= 0 else ():
            total[body] = total.get(body, np.zeros(10)) + inertial_parameters(payload, frame)
    return dict(sorted(total.items()))


def _wrenches(
    loads: Loads, tree: Tree, find: FindFrame, rows: int | None
) -> tuple[list[tuple[int, tuple[float, ...], Array]], dict[int, Array]]:
    """Wrenches in base axes with their places, and wrenches in link axes about the link origin, summed per body."""
    fixed: list[tuple[int, tuple[float, ...], Array]] = []
    turning: dict[int, Array] = {}
    for name, wrench in loads.wrenches.items():
        frame = find(name)
        body = tree.body_index(frame.link)
        if wrench.values.ndim == 2 and len(wrench.values) != rows:
            expected = counted(1 if rows is None else rows, "state")
            raise InputError(
                f"the wrench on '{name}' has {counted(len(wrench.values), 'row')}; it acts on"
                f" {expected}"
            )
        if body >= 0 and wrench.axes == "base":
            fixed.append((body, constant(frame.translation), wrench.values))
        elif body >= 0:
            turning[body] = turning.get(body, np.zeros(6)) + _at_origin(wrench, frame)
    return fixed, turning


def _at_origin(wrench: AppliedWrench, frame: Frame) -> Array:
    force = wrench.values[..., :3] @ frame.rotation.T
    moment = wrench.values[..., 3:] @ frame.rotation.T + np.cross(frame.translation, force)
    return np.concatenate([force, moment], axis=-1)


def _joined(parts: list[Array]) -> Array:
    """Vectors side by side; where one has rows, all get them."""
    rows = [len(p) for p in parts if p.ndim == 2]
    if rows:
        parts = [np.broadcast_to(p, (rows[0], p.shape[-1])) for p in parts]
    return np.concatenate(parts, axis=-1) if parts else np.empty(0)
