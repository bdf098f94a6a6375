"""Entry of the command."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command; a missing click is told, not traced."""
    try:
        import click  # noqa: F401, PLC0415  an extra
    except ImportError:
        sys.exit("hybrid-dynamics needs click: pip install click, or this package with its extra 'cli'")
    from .app import run  # noqa: PLC0415

    run()


if __name__ == "__main__":
    main()
