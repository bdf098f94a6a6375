"""Random stacks of parallel modules.

Platforms on legs, in series, with an arm and its loops on top.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from hypothesis import strategies as st

from tests.generated.assembly import BASE, Assembly, Z, turn, unit
from tests.generated.case import Case, complete
from tests.generated.class_three import EXTRAS, JOINTS, SEEDS, TRIES, add_loop, build_arm, built
from tests.generated.loops import KIND, FourBar, joint_point, leg

# joints that hold the platform to its base: slides along x, y, z, turns about a, b, c
PLATFORMS = {
    "translation": "xyz",
    "rotation": "abc",
    "planar": "xyc",
    "free": "xyzabc",
    "lift": "zab",
}
LEGS = ("UPS", "RUS", "PUS")
PLANAR_LEGS = ("RR", "RP", "PR")


@dataclass(frozen=True)
class Module:
    """A platform by its freedoms, and its legs.

    `carried`: the platform hangs on its first leg, not on the base.
    """

    platform: str
    leg: str
    carried: bool = False


@dataclass(frozen=True)
class Stack:
    """Modules in series, an arm on the last, loops on the arm.

    Which joints are active: 'legs', 'pose' or 'any'.
    """

    modules: tuple[Module, ...]
    arm: tuple[str | FourBar, ...]
    extra: tuple[tuple[str, int, FourBar], ...]
    active: str
    tidy: bool
    seed: int


@lru_cache(maxsize=64)
def build_stack(stack: Stack) -> Case | None:
    """The robot of a stack; None if every geometry tried is next to singular."""
    for k in range(TRIES):
        a = Assembly(np.random.default_rng([stack.seed, k]), stack.tidy)
        link = BASE
        for module in stack.modules:
            link = add_module(a, link, module, stack.active)
        tool = build_arm(a, stack.arm, link) if stack.arm else link
        for kind, place, bar in stack.extra:
            add_loop(a, tool, kind, place, bar)
        case = complete(a, tool, repr(stack), stack.seed + k)
        if case is not None:
            return case
    return None


def add_module(a: Assembly, on: str, module: Module, active: str) -> str:
    """A module on a link; returns its platform."""
    rng = a.rng
    frame = np.eye(3)
    if not a.tidy:
        frame = turn(unit(rng.normal(size=3)), rng.uniform(0.0, 0.5)) @ a.poses[on][0]
    foot = joint_point(a, on) + 0.1 * rng.normal(size=3)
    centre = foot + frame @ (0.8 * Z)
    freedoms = PLATFORMS[module.platform]
    planar = module.platform == "planar"
    near, far = _rings(rng, len(freedoms))
    lift = np.zeros(3) if planar else foot - centre
    height = 0.0 if planar else 0.05
    tips = [centre + frame @ (place + height * rng.normal(size=3)) for place in near]
    feet = [centre + lift + frame @ place for place in far]
    if module.carried and module.leg == "UPS" and module.platform == "free":
        platform = _carried_platform(a, on, feet[0], tips[0], frame)
        feet, tips = feet[1:], tips[1:]
    else:
        before = len(a.joints)
        platform = _platform(a, on, centre, frame, freedoms)
        if active == "pose":
            a.preferred += list(a.joints)[before:]
    for start, end in zip(feet, tips, strict=True):
        if planar:
            driven = _planar_leg(a, on, platform, start, end, frame[:, 2], module.leg)
        else:
            driven = leg(a, on, platform, start, end, module.leg)
        if active == "legs":
            a.preferred.append(driven)
    return platform


def _rings(rng: np.random.Generator, legs: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Places of tips and of feet of some legs, on two rings about the origin."""
    inner = rng.uniform(0.15, 0.3)
    outer = rng.uniform(0.5, 0.8)
    tips: list[np.ndarray] = []
    feet: list[np.ndarray] = []
    for k in range(legs):
        first, second = np.sort(rng.uniform(0.0, 2.0 * np.pi / legs, 2))
        sector = 2.0 * np.pi * k / legs
        tips.append(inner * turn(Z, first + sector)[:, 0])
        feet.append(outer * turn(Z, second + sector)[:, 0])
    return tips, feet


def _platform(a: Assembly, on: str, centre: np.ndarray, frame: np.ndarray, freedoms: str) -> str:
    link = on
    for freedom in freedoms:
        kind = "prismatic" if freedom in "xyz" else "revolute"
        axis = frame[:, "xyzabc".index(freedom) % 3]
        value = float(a.rng.uniform(-0.2, 0.2))
        last = link
        link = a.hang(last, kind, axis, centre, value)
        if last != on:
            a.massless.add(last)
        # axes that meet in the centre
        if kind == "revolute" and not a.tidy:
            frame = turn(axis, 0.3) @ frame
    return link


def _carried_platform(
    a: Assembly, on: str, foot: np.ndarray, tip: np.ndarray, frame: np.ndarray
) -> str:
    """A platform on the end of a leg, by a ball of three revolute joints."""
    along = unit(tip - foot)
    first = unit(np.cross(along, frame[:, 0]))
    link = on
    for kind, axis, at in (
        ("revolute", first, foot),
        ("revolute", np.cross(along, first), foot),
        ("prismatic", along, 0.5 * (foot + tip)),
        ("revolute", frame[:, 0], tip),
        ("revolute", frame[:, 1], tip),
        ("revolute", frame[:, 2], tip),
    ):
        link = a.hang(link, kind, axis, at)
    return link


def _planar_leg(
    a: Assembly,
    on: str,
    platform: str,
    foot: np.ndarray,
    tip: np.ndarray,
    normal: np.ndarray,
    kind: str,
) -> str:
    """A leg of two joints in the plane of the platform and a pin; returns its first joint."""
    along = unit(tip - foot)
    bend = np.cross(normal, along)
    if kind not in PLANAR_LEGS:
        kind = PLANAR_LEGS[len(kind + platform) % 3]
    axes = {"R": normal, "P": unit(along + 0.3 * bend)}
    link = a.hang(on, KIND[kind[0]], axes[kind[0]], foot)
    driven = f"q_{link}"
    link = a.hang(link, KIND[kind[1]], axes[kind[1]], 0.5 * (foot + tip) + 0.3 * bend)
    a.tie(link, platform, tip, "planar")
    a.rank += 2
    return driven


MODULES = st.builds(
    Module, st.sampled_from(sorted(PLATFORMS)), st.sampled_from(LEGS), st.booleans()
)


@st.composite
def stacks(draw: st.DrawFn, max_modules: int = 3) -> Case:
    """1 to 3 modules in series; alone, under an arm, or under an arm with a loop.

    At most one has six legs.
    """
    modules: list[Module] = draw(st.lists(MODULES, min_size=1, max_size=max_modules))
    six_legged = [module for module in modules if module.platform == "free"]
    modules = [module for module in modules if module not in six_legged[1:]]
    arm = tuple(draw(st.lists(JOINTS, max_size=2)))
    most_loops = 1 if arm else 0
    extra = tuple(draw(st.lists(EXTRAS, max_size=most_loops)))
    active = draw(st.sampled_from(("legs", "pose", "any")))
    tidy = draw(st.booleans())
    stack = Stack(tuple(modules), arm, extra, active, tidy, draw(SEEDS))
    return built(build_stack(stack))
