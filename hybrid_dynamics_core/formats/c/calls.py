"""The C functions of a robot: what they take and give."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from ... import programs
from ...description.model import Frame
from ...dynamics.load_pattern import LoadPattern
from ...errors import InputError
from ...ground.suggestions import no_such_name
from ...programs import Program
from ...robot.actuation import Actuation
from ...robot.closure import Closure
from ...robot.frameworks.calls import CALL_BY_NAME
from ...robot.kernel_store import KernelStore
from ...robot.model import RobotModel
from ...robot.robot import Robot

GUESS = "guess"
FRICTION = ("viscous", "coulomb")
ALL_LOADS = ("payload", *FRICTION)
NAMES_IN_C = {"jacobian": "J"}  # of results that have other names in programs


@dataclass(frozen=True)
class Setting:
    """What the program of a function depends on besides its arguments.

    Attributes:
        model: constants of the robot.
        pattern: pattern of the loads.
        frame: the end effector.
    """

    model: RobotModel
    pattern: LoadPattern
    frame: Frame


OfSetting = Callable[[Setting], Program]


def _needs_nothing(_robot: Robot) -> str:
    return ""


@dataclass(frozen=True)
class CFunction:
    """A C function.

    Attributes:
        name: after the robot's prefix.
        inputs: vectors before the guess, in order.
        results: names of its outputs in C, by their names in the program, in order.
        program: the program in a setting.
        text: what it computes.
        loads: arguments, before the guess, where loads are arguments.
        on_request: whether it is written only where it is named.
        lacks: what a robot lacks for it; empty if nothing.
        open: outputs that may be NaN or infinite, in C.
    """

    name: str
    inputs: tuple[str, ...]
    results: Mapping[str, str]
    program: OfSetting
    text: str
    loads: tuple[str, ...] = ()
    on_request: bool = False
    lacks: Callable[[Robot], str] = field(default=_needs_nothing)
    open: tuple[str, ...] = ()


def same_names(*names: str) -> dict[str, str]:
    """Results that have the same names in C and in programs."""
    return {name: name for name in names}


def _of_robot(name: str, text: str, loads: tuple[str, ...] = ()) -> CFunction:
    """The function of a call that robots have in other frameworks too."""
    call = CALL_BY_NAME[name]

    def program(setting: Setting) -> Program:
        return call.program(setting.pattern, setting.frame)

    results = {result: NAMES_IN_C.get(result, result) for result in call.results}
    return CFunction(name, call.inputs, results, program, text, loads)


def _reactions(setting: Setting) -> Program:
    closures = setting.model.description.closures
    return programs.reactions(closures, setting.pattern)


def _hydraulics(setting: Setting) -> Program:
    model = setting.model
    actuation = Actuation(model, Closure(model, KernelStore(model)))
    drives = [model.coordinates.index(name) for name in actuation.determining]
    return programs.hydraulics(actuation.cylinders, drives)


def lack_of_masses(robot: Robot) -> str:
    """What a robot without masses lacks; empty if it has some."""
    links = robot.description.links.values()
    if any(link.mass for link in links) or robot.loads.payloads:
        return ""
    return "no link has a mass"


def _no_cylinders(robot: Robot) -> str:
    if robot.cylinders:
        return ""
    return "no joint has a hydraulic cylinder"


AT_ACCELERATION = ("u", "du", "ddu", "gravity")
AT_EFFORT = ("u", "du", "tau", "gravity")
PINS = ("pin_places", "pin_forces", "pin_moments", "pin_shares")
JOINTS = ("joint_places", "joint_forces", "joint_moments")
CALLS = (
    _of_robot(
        "close",
        "all coordinates s (NS) and their rates s' (NS)",
    ),
    _of_robot(
        "inverse_dynamics",
        "efforts of the drives tau (NU) for accelerations u''",
        ALL_LOADS,
    ),
    _of_robot(
        "forward_dynamics",
        "accelerations u'' (NU) from efforts tau",
        ALL_LOADS,
    ),
    _of_robot(
        "minimal_form",
        "M (NU, NU), h = C u' (NU) and g (NU) of M u'' + h + g = tau; friction, springs and"
        " wrenches are not in them",
        ("payload",),
    ),
    _of_robot(
        "forward_kinematics",
        "position (3) and rotation (3, 3) of the end effector in base axes",
    ),
    _of_robot(
        "jacobian",
        "J (6, NU): linear, then angular velocity of the end effector per unit rate",
    ),
    CFunction(
        "reactions",
        AT_ACCELERATION,
        same_names("tau", *PINS, *JOINTS, "base"),
        _reactions,
        "tau (NU); place, force and moment (3 each) in every loop closure, on its link a, and in\n"
        "   every joint, on the link that it carries; the wrench (6) of the foundation; base axes."
        "\n   pin_shares: how well a pin is determined, 1 at best. One that is not is NaN, and so"
        "\n   are the joints of its loop",
        ALL_LOADS,
        on_request=True,
        lacks=lack_of_masses,
        open=(*PINS[1:], *JOINTS[1:]),
    ),
    CFunction(
        "inverse_dynamics_derivatives",
        AT_ACCELERATION,
        same_names("tau", "d_u", "d_du", "d_ddu"),
        lambda setting: programs.inverse_dynamics_derivatives(setting.pattern),
        "tau (NU) and its derivatives (NU, NU) by u, u' and u''; the last is M",
        ALL_LOADS,
        on_request=True,
    ),
    CFunction(
        "forward_dynamics_derivatives",
        AT_EFFORT,
        same_names("ddu", "d_u", "d_du", "d_tau"),
        lambda setting: programs.forward_dynamics_derivatives(setting.pattern),
        "u'' (NU) and its derivatives (NU, NU) by u, u' and tau",
        ALL_LOADS,
        on_request=True,
        lacks=lack_of_masses,
    ),
    CFunction(
        "ik_step",
        ("u", *programs.TARGET),
        same_names("next", "error"),
        lambda setting: programs.ik_step(setting.frame),
        "next (NU): u after a damped least-squares step to a pose of the end effector; error (6)\n"
        "   before it, along and about x, y, z. weights (6): of these errors, 0 leaves one out",
        on_request=True,
    ),
    CFunction(
        "generalised_forces",
        ("u", "forces"),
        same_names("tau"),
        lambda _: programs.generalised_forces(),
        "efforts of the drives tau (NU) that do the work of forces (NS) along all coordinates",
        on_request=True,
    ),
    CFunction(
        "hydraulics",
        ("u", "du", "tau"),
        same_names(*programs.HYDRAULICS),
        _hydraulics,
        "force [N], chamber pressures [Pa], flows into the chambers [m^3/s], flow from the supply,"
        "\n   power [W] and distances to the ends of the stroke [m], one entry for each cylinder",
        on_request=True,
        lacks=_no_cylinders,
        open=("to_lower", "to_upper"),
    ),
)


def calls_of(names: Sequence[str] | None, robot: Robot) -> list[CFunction]:
    """The calls of some names; those that are always written if None.

    Raises:
        InputError: there is no such program, or the robot lacks what it needs.
    """
    if names is None:
        return [call for call in CALLS if not call.on_request]
    by_name = {call.name: call for call in CALLS}
    for name in names:
        if name not in by_name:
            raise InputError(no_such_name("program", name, by_name))
        lack = by_name[name].lacks(robot)
        if lack:
            raise InputError(f"{robot.name}: {lack}, so the program '{name}' has no results")
    if not names:
        raise InputError(f"no program is named; expected some of {', '.join(by_name)}")
    return [by_name[name] for name in dict.fromkeys(names)]
