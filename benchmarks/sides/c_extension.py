"""The floor: an extension module in C, written by hand for this one robot and compiled here."""

from __future__ import annotations

import importlib.util
import math
import shlex
import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import numpy as np

from hybrid_dynamics_core import Robot

from ..closed_form import ARM, B3, C2, FORE, L1, L2, L11, L21
from ..side import Side

FLAGS = ("-O3", "-march=native", "-ffast-math", "-fno-finite-math-only", "-fopenmp-simd", "-fPIC")
C1, FORE_ARM, L42, L4, ROD = 0.2, 0.6, 0.2, 0.2, 0.4
# Of each link of the arm: kx, a, b of its mass, and the direction with which it turns.
ARM_LINKS = {
    "l2": (0.0, L2 / 2, 0.0, "e2"),
    "l31": (-C1, L2 / 2, 0.0, "e2"),
    "l3": (0.0, L2, 0.2, "e3"),
    "l41": (0.0, L2, FORE_ARM / 2, "e3"),
    "l32": (-C1 / 2, L2, 0.0, ""),
    "l42": (L42 / 2, L2, FORE_ARM, ""),
    "l4": (L42 + L4 / 2, L2, FORE_ARM, ""),
}
YAW_LINKS = ("l2", "l31", "l3", "l41", "l42", "l4", "l11", "l12", "l21", "l22")


def numbers(robot: Robot) -> list[float]:
    """What `setup` takes, in the order of the structure in floor.c."""
    links = robot.description.links
    mass = {name: link.mass for name, link in links.items()}
    ixx = {name: float(link.inertia[0, 0]) for name, link in links.items()}
    iyy = {name: float(link.inertia[1, 1]) for name, link in links.items()}
    izz = {name: float(link.inertia[2, 2]) for name, link in links.items()}
    difference = {name: ixx[name] - iyy[name] for name in links}
    yaw = izz["l1"] + ixx["l32"] + sum(iyy[name] for name in YAW_LINKS)
    cylinders: list[float] = []
    for barrel, rod, length in (("l11", "l12", L11), ("l21", "l22", L21)):
        both = (izz[barrel] + izz[rod], difference[barrel] + difference[rod])
        cylinders += [mass[barrel], length / 2, mass[rod], -ROD / 2, *both]
    triangles = [L1, ARM, L11, FORE, B3, L21]
    return [
        -float(robot.description.gravity[2]),
        *triangles,
        *_mass_sums(mass),
        _turning("e2", izz),
        _turning("e3", izz),
        _turning("e2", difference),
        _turning("e3", difference),
        yaw,
        ixx["l4"],
        *cylinders,
        -L1,
        C2,
    ]


def _mass_sums(mass: dict[str, float]) -> list[float]:
    """Sums over the links of the arm of mass times a, b, kx^2, a^2, a b, b^2, kx a, kx b."""
    sums = [0.0] * 8
    for name, (kx, a, b, _) in ARM_LINKS.items():
        factors = (a, b, kx * kx, a * a, a * b, b * b, kx * a, kx * b)
        for k, factor in enumerate(factors):
            sums[k] += mass[name] * factor
    return sums


def _turning(direction: str, values: dict[str, float]) -> float:
    """The sum over the links of the arm that turn with a direction."""
    return sum(values[name] for name, row in ARM_LINKS.items() if row[3] == direction)


def extension(name: str, sources: Sequence[Path], flags: Sequence[str]) -> ModuleType:
    """Compile and load an extension module.

    Raises:
        OSError: there is no C compiler, or it fails.
    """
    command = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if command is None:
        raise OSError("no C compiler")
    include = [f"-I{sysconfig.get_path('include')}", f"-I{np.get_include()}"]
    with tempfile.TemporaryDirectory(prefix=name) as place:
        objects = [str(Path(place, f"{source.stem}.o")) for source in sources]
        for source, code in zip(sources, objects, strict=True):
            _call([command, *flags, *include, "-c", str(source), "-o", code])
        target = Path(place, f"{name}{sysconfig.get_config_var('EXT_SUFFIX')}")
        # FLAGS here would disable subnormals: fast-math.
        _call([command, "-shared", *objects, "-o", str(target), "-lm"])
        return _loaded(name, target)


def _call(arguments: list[str]) -> None:
    # The system's compiler.
    answer = subprocess.run(arguments, capture_output=True, text=True, check=False)  # noqa: S603
    if answer.returncode != 0:
        raise OSError(f"{shlex.join(arguments)}\n{answer.stderr}")


def _loaded(name: str, target: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, target)
    if spec is None or spec.loader is None:
        raise OSError("the extension module cannot be loaded")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def sides(robot: Robot) -> list[Side]:
    """The floor, for single calls and batches."""
    module = extension("floor", [Path(__file__).with_name("floor.c")], FLAGS)
    values = numbers(robot)
    if not all(map(math.isfinite, values)):
        raise ValueError("the robot's numbers are not finite")
    module.setup(*values)
    return [
        Side(
            "C by hand, extension module",
            {"id": module.one, "id_out": module.one, "id_batch": module.batch},
        )
    ]
