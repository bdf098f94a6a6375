"""Entry point of the command, also by `python -m hybrid_dynamics_cli`."""

from __future__ import annotations

import os
import sys

ABORTED = "Aborted!"  # the message of click


def main() -> None:
    """Run the command.

    If click is missing, or an interrupt comes while modules are loaded, it ends with a message,
    without a traceback.
    """
    # Matrices are small here. On a busy machine the threads of OpenBLAS wait for each other, up to
    # forty times longer than they compute.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        import click  # noqa: F401, PLC0415  an extra
    except ImportError:
        sys.exit(
            "hybrid-dynamics needs click: pip install click, or this package with its extra 'cli'"
        )
    except KeyboardInterrupt:
        sys.exit(ABORTED)
    try:
        from .app import run  # noqa: PLC0415
    except KeyboardInterrupt:
        sys.exit(ABORTED)
    run()


if __name__ == "__main__":
    main()
