"""Files of figures, and the library that makes them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import MissingPackageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write(figure: Figure, path: str | os.PathLike[str] | None) -> None:
    """Write a figure; nothing without a path."""
    from .figure import save  # noqa: PLC0415  needs Matplotlib

    if path is not None:
        save(figure, Path(path))


def need_matplotlib() -> None:
    """Raise MissingPackageError without Matplotlib."""
    try:
        import matplotlib  # noqa: F401, PLC0415
    except ImportError as error:
        raise MissingPackageError("matplotlib", "plot", "drawings") from error
