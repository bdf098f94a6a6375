"""The robot's exported C, compiled as a controller would compile it, as an extension module."""

from __future__ import annotations

import tempfile
from pathlib import Path

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.export import to_c

from ..side import Side
from .c_extension import extension

FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fPIC")


def sides(robot: Robot) -> list[Side]:
    """Inverse dynamics, for single calls.

    Raises:
        OSError: there is no C compiler, or it fails.
    """
    with tempfile.TemporaryDirectory(prefix="c_export") as folder:
        for name, text in to_c(robot, ["inverse_dynamics"]).items():
            Path(folder, name).write_text(text, encoding="utf-8")
        wrapper = Path(__file__).with_name("c_export.c")
        sources = [wrapper, Path(folder, f"{robot.name}.c")]
        module = extension("c_export", sources, (*FLAGS, f"-I{folder}"))
    return [Side("C export, extension module", {"id": module.one, "id_out": module.one})]
